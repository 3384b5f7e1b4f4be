"""The asyncio loop of the running script, made when the script first needs asyncio, which takes long to import."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import asyncio

_LOOPS: list[asyncio.AbstractEventLoop] = []
_FAILED: list[BaseException] = []
"""At most one."""
_TASKS: set[asyncio.Task[Any]] = set()
"""Those that run, and those that failed."""


def script_loop() -> asyncio.AbstractEventLoop:
    """The loop of the running script; it may be there before the App."""
    import asyncio  # where a script waits for it, this makes the loop

    if (found := made_loop()) is None:
        found = asyncio.new_event_loop()
        found.set_exception_handler(_note_failure)
        found.set_task_factory(_noted)
        _LOOPS[:] = [found]
    return found


def made_loop() -> asyncio.AbstractEventLoop | None:
    """The loop of the running script, if it has needed one."""
    return _LOOPS[0] if _LOOPS and not _LOOPS[0].is_closed() else None


def failure() -> BaseException | None:
    """The first error of a task that nothing waited for."""
    unseen = (task.exception() for task in list(_TASKS) if task.done() and getattr(task, "_log_traceback", True))
    return _FAILED[0] if _FAILED else next(unseen, None)


def _noted(loop: asyncio.AbstractEventLoop, coroutine: Any, **named: Any) -> asyncio.Task[Any]:
    """A task, kept until it has ended well: a script may hold a failed one and never look at it."""
    import asyncio

    made: asyncio.Task[Any] = asyncio.Task(coroutine, loop=loop, **named)
    _TASKS.add(made)
    made.add_done_callback(lambda task: _TASKS.discard(task) if getattr(task, "_exception", None) is None else None)
    return made


def _note_failure(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    if (error := context.get("exception")) is not None and not _FAILED:
        _FAILED.append(error)
    else:  # the first ends the script; errors of every update are not kept
        loop.default_exception_handler(context)


@contextmanager
def current_loop() -> Iterator[None]:
    """Makes the script's loop the current one, now or when asyncio is imported; ends it with all of its tasks."""
    hook = _OnImport()
    _FAILED.clear()
    _TASKS.clear()
    if "asyncio" in sys.modules:
        _take_place()
    else:
        sys.meta_path.insert(0, hook)
    try:
        yield
    finally:
        if hook in sys.meta_path:
            sys.meta_path.remove(hook)
        if "asyncio" in sys.modules:
            _end()


def _take_place() -> None:
    import asyncio

    asyncio.set_event_loop(script_loop())


def _end() -> None:
    import asyncio

    loop = script_loop()
    for task in asyncio.all_tasks(loop):
        task.cancel()
    loop.set_exception_handler(None)
    if not loop.is_running():
        loop.close()
    asyncio.set_event_loop(None)


class _OnImport(MetaPathFinder, Loader):
    """Imports asyncio as Python does, and makes the script's loop the current one."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Python's own answer for asyncio, once; None for all else."""
        if fullname != "asyncio":
            return None
        sys.meta_path.remove(self)
        spec = PathFinder.find_spec(fullname, path, target)
        if spec is not None and spec.loader is not None:
            self._loader, spec.loader = spec.loader, self
        return spec

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """Leaves it to Python."""
        return self._loader.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        """Runs the module, then sets the loop."""
        self._loader.exec_module(module)
        _take_place()
