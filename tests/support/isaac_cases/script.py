"""A script for `graph exec`: runs the unittest cases of one module; writes what became of each, as JSON.

Arguments: the module, the file to write, the limit of a case [s], the text that names of cases contain, whether CUDA is
left out, and the folders in which modules of tests and helpers are. Cases that are in the file already are left out; a
case that takes too long ends the process. A module that cannot be imported fails as a whole.
"""

import ast
import importlib.util
import json
import re
import signal
import sys
import traceback
import unittest
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path

from isaacsim import SimulationApp  # type: ignore[import-not-found]

module, out, limit, only, without_cuda, helpers = sys.argv[1:7]
folders = [Path(one) for one in sys.argv[7:]]
simulation_app = SimulationApp({"headless": True})


class TimeUpError(Exception):
    """A case took longer than its limit."""


def without_gpu(text):
    """The text without CUDA in lists; what had two entries stays a tuple of one."""
    return re.sub(r',\s*"cuda(:\d+)?"', "", re.sub(r',\s*"cuda(:\d+)?"(?=\s*\))', ",", text))


class Loader(SourceFileLoader):
    """Loads a file of tests, without CUDA in its lists of devices if that is asked for."""

    def source_to_code(self, data, path, *options, **named):
        text = bytes(data).decode()
        return super().source_to_code(without_gpu(text) if int(without_cuda) else text, path)

    def path_stats(self, path):
        raise OSError("no cached code: it may differ from the text")


class Package:
    """A package of tests of which only single modules are loaded: its own text would load all of them."""

    def __init__(self, folder):
        self.folder = folder

    def create_module(self, spec):
        return None

    def exec_module(self, made):
        made.__path__ = [str(self.folder)]


class Finder:
    """Finds modules of tests, and the named helpers; everything else is this project's."""

    def find_spec(self, name, path=None, target=None):
        is_test = "tests" in name.split(".")
        if not is_test and not any(f"{name}.".startswith(f"{one}.") for one in helpers.split(",") if one):
            return None
        for folder in folders:
            place = folder.joinpath(*name.split("."))
            if place.is_dir() and (is_test or not (place / "__init__.py").is_file()):
                return ModuleSpec(name, Package(place), is_package=True)
            file = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
            if file.is_file():
                inside = [str(place)] if place.is_dir() else None
                return importlib.util.spec_from_file_location(
                    name, file, loader=Loader(name, str(file)), submodule_search_locations=inside
                )
        return None


class Above:
    """Finds the packages above the module of tests that exist nowhere else: as empty ones, for what they hold."""

    def find_spec(self, name, path=None, target=None):
        place = next(
            (one.joinpath(*name.split(".")) for one in folders if one.joinpath(*name.split(".")).is_dir()), None
        )
        return ModuleSpec(name, Package(place), is_package=True) if place and module.startswith(f"{name}.") else None


def time_up(*_):
    raise TimeUpError(f"longer than {limit} s")


class Outcome(unittest.TestResult):
    """Keeps the first error of a case."""

    first = None

    def addError(self, test, err):
        self.first = self.first or err[1]

    addFailure = addError

    def addSubTest(self, test, subtest, err):
        if err is not None:
            self.addError(test, err)


def outcome_of(case):
    result = Outcome()
    signal.setitimer(signal.ITIMER_REAL, float(limit))
    try:
        case.run(result)
    except Exception as error:
        result.first = error
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
    if result.skipped:
        return "skips", result.skipped[0][1], ""
    return ("agrees", "", "") if result.first is None else told(result.first)


def told(error):
    """Whether an error means that something is missing here, with its message and place."""
    causes = [error]
    while (cause := causes[-1].__cause__ or causes[-1].__context__) is not None and cause not in causes:
        causes.append(cause)
    absent = next((one for one in causes if isinstance(one, (ImportError, NotImplementedError)) or no_gpu(one)), None)
    text = f"{type(absent or error).__name__}: {absent or error}"
    return "deviates" if absent is None else "absent", text, "".join(traceback.format_exception(error))


def no_gpu(error):
    """Whether this project refuses a device because its physics runs on the processor."""
    return isinstance(error, ValueError) and "an engine that runs on a GPU is missing" in str(error)


def written_cases(folder_of):
    """The names of the cases that a file has, by its text."""
    tree = ast.parse(Path(folder_of.origin).read_text())
    for one in (node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)):
        for part in one.body:
            if isinstance(part, (ast.FunctionDef, ast.AsyncFunctionDef)) and part.name.startswith("test"):
                yield f"{one.name}.{part.name}"


found = json.loads(Path(out).read_text())["cases"] if Path(out).exists() else {}


def write(done=False):
    Path(out).write_text(json.dumps({"cases": found, "done": done}))


sys.meta_path.insert(0, Finder())
sys.meta_path.append(Above())
signal.signal(signal.SIGALRM, time_up)
try:
    loaded = importlib.import_module(module)
except Exception as error:
    found = {name: told(error) for name in written_cases(Finder().find_spec(module)) if only in name}
    write(done=True)
    simulation_app.close()
for made in [one for one in vars(loaded).values() if isinstance(one, type)]:
    if issubclass(made, unittest.TestCase) and made.__module__ == module:
        for name in unittest.defaultTestLoader.getTestCaseNames(made):
            full = f"{made.__name__}.{name}"
            if only in full and full not in found:
                found[full] = ["deviates", "ended the process, or the script", ""]
                write()
                found[full] = outcome_of(made(name))
                write()
                if found[full][1].startswith(TimeUpError.__name__):  # what it was cut off from may be broken
                    simulation_app.close()
write(done=True)
simulation_app.close()
