"""The tests of a file: those that ran its lines in the last run with coverage, else those near it.

Near are tests of its folder, and those that import it or, if none does, the modules that import it.

python -m tests.support.covering FILE... [-- PYTEST OPTIONS]

`make test PYTEST="--cov --cov-context=test"` renews the coverage (`build/coverage`).
"""

from __future__ import annotations

import ast
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from tests.support.places import PACKAGES, ROOT

DATA = ROOT / "build" / "coverage"


def covering(file: Path, data: Path = DATA) -> list[str]:
    """What pytest runs for a file: tests by their ids if the coverage has lines of it, else test files."""
    beside = (ROOT / "tests" / file.parent.relative_to(ROOT)).glob("test_*.py")
    return ran_by(file, data) or [str(one.relative_to(ROOT)) for one in sorted({*near(file), *beside})]


def ran_by(file: Path, data: Path = DATA) -> list[str]:
    """The tests, without parameters, in which lines of a file ran after its import; empty without coverage of it."""
    if not data.exists():
        return []
    from coverage import CoverageData

    found = CoverageData(str(data))
    found.read()
    contexts = {one for line in found.contexts_by_lineno(str(file)).values() for one in line if one}
    ids = {one.partition("|")[0].partition("[")[0] for one in contexts}
    return sorted(one for one in ids if (ROOT / one.partition("::")[0]).exists())


def near(file: Path) -> list[Path]:
    """The test files that import a module or have its name; if none does, those of the modules that import it."""
    seen: set[str] = set()
    wave = {module_of(file)}
    while wave:
        names = {name.rpartition(".")[2].removeprefix("test_") for name in wave}
        found = [
            path
            for path, imported in imports().items()
            if path.name.startswith("test_")
            and (imported & wave or (path.stem.removeprefix("test_") in names and same_folder(path, wave)))
        ]
        if found:
            return sorted(found)
        seen |= wave
        wave = {module_of(path) for path, imported in imports().items() if imported & wave} - seen
    return []


def same_folder(test: Path, modules: Iterable[str]) -> bool:
    """Whether a test file is in the folder of `tests` that belongs to the folder of one of these modules."""
    folder = test.parent.relative_to(ROOT / "tests").parts
    return any(tuple(name.split(".")[:-1]) == folder for name in modules)


def module_of(file: Path) -> str:
    """The dotted name of a file's module."""
    parts = file.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def imports() -> dict[Path, set[str]]:
    """Each Python file of the packages and the tests, and the names that it imports, relative ones resolved."""
    files = [path for top in (*PACKAGES, "tests") for path in (ROOT / top).rglob("*.py")]
    return {path: set(_imported(path)) for path in files}


def _imported(path: Path) -> Iterable[str]:
    package = module_of(path) if path.name == "__init__.py" else module_of(path).rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            base = ".".join([*above, *filter(None, [node.module])])
            yield base
            yield from (f"{base}.{alias.name}" for alias in node.names)


def main(arguments: list[str]) -> int:
    """Runs the tests of the files; returns pytest's exit code, or 2 if there is nothing to run."""
    cut = arguments.index("--") if "--" in arguments else len(arguments)
    files, options = [Path(one).resolve() for one in arguments[:cut]], arguments[cut + 1 :]
    missing = [one for one in files if not one.is_file() or not one.is_relative_to(ROOT)]
    chosen = list(dict.fromkeys(test for one in files if one not in missing for test in covering(one)))
    if missing or not chosen:
        print(f"{', '.join(map(str, missing or files)) or 'no file'}: give files of this project that a test covers")
        return 2
    with tempfile.NamedTemporaryFile("w", encoding="utf8", suffix=".txt") as listed:
        listed.write("\n".join(chosen))
        listed.flush()
        command = [sys.executable, "-m", "pytest", *options, f"@{listed.name}"]
        return subprocess.run(command, cwd=ROOT, check=False).returncode


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
