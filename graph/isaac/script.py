"""Runs one script of Isaac Sim: its arguments, its code with `await` at top level, the loop after its last line."""

from __future__ import annotations

import ast
import builtins
import inspect
import os
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from itertools import count
from pathlib import Path
from types import ModuleType, TracebackType
from typing import Any

from graph.base.errors import UserError
from graph.base.inputs import start_of

from . import saving
from .assets import missing_below
from .finder import ROS, importable
from .kit import kit_of
from .loops import current_loop, failure, script_loop
from .names import names_of
from .run import RUN, Run, ScriptEnd
from .session import begin

MAX_BYTES = 10_000_000
AFTER = 30
"""Most updates that tasks get after the last line of a snippet."""
PACKAGES = {
    "cv2": "opencv-python",
    "PIL": "pillow",
    "yaml": "pyyaml",
    "skimage": "scikit-image",
    "sklearn": "scikit-learn",
}
"""Packages whose modules have another name."""
APP_FOLDERS = ("CARB_APP_PATH", "EXP_PATH", "ISAAC_PATH")


class ScriptError(Exception):
    """The script failed: one line with the script's own line."""

    def __init__(self, message: str, cause: BaseException) -> None:
        super().__init__(message)
        self.cause = cause


class Script:
    """A script file and its arguments."""

    def __init__(self, path: Path, arguments: Sequence[str] = ()) -> None:
        """Raises UserError for a file that is missing or not Python."""
        self.path, self.arguments = path, list(arguments)
        try:
            data = start_of(path, MAX_BYTES + 1)
        except OSError as error:
            raise UserError(f"{path}: {error.strerror}; give the path of a Python script") from None
        if len(data) > MAX_BYTES:
            raise UserError(f"{path} is larger than {MAX_BYTES} bytes; that is not a script")
        try:
            self.tree = ast.parse(data, str(path))
            flags = ast.PyCF_ALLOW_TOP_LEVEL_AWAIT
            self.code = compile(data, str(path), "exec", flags=flags, dont_inherit=True)
        except (SyntaxError, ValueError) as error:
            line = getattr(error, "lineno", None) or 1
            raise UserError(f"{path}:{line}: not Python: {getattr(error, 'msg', error)}") from None
        self._caught: dict[str, None] = {}
        self._watched: list[UserError] = []

    @property
    def makes_app(self) -> bool:
        """Whether it makes its own application; otherwise it is a snippet for one that runs."""
        names = {node.id for node in ast.walk(self.tree) if isinstance(node, ast.Name)}
        names |= {node.attr for node in ast.walk(self.tree) if isinstance(node, ast.Attribute)}
        return not names.isdisjoint(("SimulationApp", "AppFramework"))

    @property
    def names_warp(self) -> bool:
        """Whether its text imports Warp."""
        imports = (node for node in ast.walk(self.tree) if isinstance(node, ast.Import | ast.ImportFrom))
        named = {
            one for node in imports for one in (getattr(node, "module", None), *(name.name for name in node.names))
        }
        return any(one is not None and one.partition(".")[0] == "warp" for one in named)

    @property
    def caught(self) -> list[str]:
        """The errors of ours that the script caught, each with its line."""
        return list(self._caught)

    def run(self, run: Run) -> int:
        """Runs it to its end; returns its exit code. Raises ScriptError if it fails."""
        run.each_update, run.names_warp = self._note_caught, self.names_warp
        token = RUN.set(run)
        try:
            with ExitStack() as held:
                held.callback(saving.end)
                held.enter_context(importable())
                held.enter_context(self._surroundings(run))
                held.enter_context(current_loop())
                held.enter_context(_watching(self._watched.append))
                try:
                    return self._executed(run)
                finally:
                    self._note_caught()
        finally:
            RUN.reset(token)

    def _executed(self, run: Run) -> int:
        code = 0
        try:
            if not self.makes_app:
                run.from_editor = True
                begin(run)
            module = _main_module(self.path, editor=not self.makes_app)
            sys.modules["__main__"] = module
            self._execute(module, run)
            self._finish(run)
        except ScriptEnd as end:
            code = end.code
        except SystemExit as left:
            code = _code(left)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            self._forget(error)
            if isinstance(error, (MemoryError, GeneratorExit)):
                raise
            raise ScriptError(self.place(error), error) from error
        if (failed := failure()) is not None:
            raise ScriptError(self.place(failed), failed) from failed
        run.close()
        return run.code if code == 0 and run.code else code

    def _execute(self, module: ModuleType, run: Run) -> None:
        if inspect.CO_COROUTINE & self.code.co_flags:
            coroutine = eval(self.code, module.__dict__)
            script_loop().run_until_complete(coroutine)
        else:
            exec(self.code, module.__dict__)

    def _finish(self, run: Run) -> None:
        """After the last line: tasks that are left get updates; a snippet's application goes on while they last."""
        if run.app is None or run.ended:
            return
        kit, timeline = kit_of(run.app), run.app.timeline
        if run.play and run.from_editor:
            timeline.play()
        kit.turn()
        for done in count():
            goes_on = run.from_editor and run.updates is not None and timeline.will_play()
            if run.over() or not (goes_on or (done < AFTER and kit.tasks())):
                break
            kit.update()

    def place(self, error: BaseException) -> str:
        """`script.py:12: RuntimeError: message`, with the calls inside the script that led there."""
        lines = self._lines(error.__traceback__)
        kind = "" if isinstance(error, UserError) else f"{type(error).__name__}: "
        text = " ".join(str(error).split()) or "no message"
        text = " ".join(filter(None, (text + _remedy(error), missing_below(text))))
        where = f"{self.path}:{lines[-1]}" if lines else str(self.path)
        calls = f" (called from {', '.join(f':{line}' for line in reversed(lines[:-1]))})" if len(lines) > 1 else ""
        return f"{where}{calls}: {kind}{text}"

    def _lines(self, trace: TracebackType | None) -> list[int]:
        name = str(self.path)
        return [frame.lineno or 0 for frame in traceback.extract_tb(trace) if frame.filename == name]

    def _note_caught(self) -> None:
        """Keeps the text of errors that reached the script's own code; it caught them, because it goes on."""
        seen, self._watched[:] = self._watched[:], []
        for error in seen:
            if self._lines(error.__traceback__):
                self._caught[self.place(error)] = None

    def _forget(self, error: BaseException) -> None:
        """The error that ends the script was not caught."""
        chain: BaseException | None = error
        while chain is not None:
            self._watched[:] = [one for one in self._watched if one is not chain]
            chain = chain.__cause__

    @contextmanager
    def _surroundings(self, run: Run) -> Iterator[None]:
        """Arguments, import path and environment as Python and Kit give them to a script; restored afterwards."""
        before = (sys.argv, list(sys.path), sys.modules.get("__main__"), dict(os.environ))
        folder = str(self.path.resolve().parent)
        sys.argv = [str(self.path), *self.arguments]
        sys.path.insert(0, folder)
        for name in APP_FOLDERS:
            os.environ.setdefault(name, folder)
        builtins.ISAAC_LAUNCHED_FROM_TERMINAL = not self.makes_app  # type: ignore[attr-defined]
        try:
            yield
        finally:
            sys.argv, main = before[0], before[2]
            sys.path[:] = before[1]
            if main is not None:
                sys.modules["__main__"] = main
            os.environ.clear()
            os.environ.update(before[3])


def _remedy(error: BaseException) -> str:
    """What to do about a module that is not installed, as the tail of a message."""
    if not isinstance(error, ModuleNotFoundError):
        return ""
    top = (error.name or "").partition(".")[0]
    if top in ROS or top.endswith(("_msgs", "_interfaces", "_srvs")):
        return "; give --rclpy for an rclpy over the message bus, or install ROS 2"
    if not top or names_of(top).known:
        return ""
    return f"; install it (pip install {PACKAGES.get(top, top)}), or put the script's own module beside the script"


def _main_module(path: Path, *, editor: bool) -> ModuleType:
    module = ModuleType("__main__")
    module.__file__ = str(path)
    module.__dict__["__builtins__"] = builtins
    return module


def _code(left: SystemExit) -> int:
    if left.code is None:
        return 0
    if isinstance(left.code, int):
        return left.code
    print(left.code, file=sys.stderr)
    return 1


@contextmanager
def _watching(note: Callable[[UserError], Any]) -> Iterator[None]:
    """Calls `note(error)` for every UserError that is made."""
    from graph.base import errors

    before = errors.watcher
    errors.watcher = note
    try:
        yield
    finally:
        errors.watcher = before
