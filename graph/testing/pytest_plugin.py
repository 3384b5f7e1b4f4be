"""The pytest plugin: collects TickGraph's `*.test.yaml` files and provides the fixtures run_node, run_graph, make_app.

It is installed as the module `tickgraph_pytest`: every pytest run in the environment loads it, and loading it must not
import a package with the common name `graph`. It imports TickGraph only for a test file or when a fixture is used.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from graph.isaac.managers.app import App
    from graph.testing.cases import Case
    from graph.testing.node import Trace
    from graph.testing.trace import GraphTrace

_SUFFIXES = (".test.yaml", ".test.yml", ".test.json")
_MARKER = re.compile(rb"""^\s*\{?\s*["']?tickgraph""", re.MULTILINE)
_HEAD = 65536
"""The key that identifies our files must be within this many bytes."""


@pytest.fixture
def run_node() -> Callable[..., Trace]:
    """Runs one node for some updates: `graph.testing.run_node`."""
    from graph.testing.node import run_node

    return run_node


@pytest.fixture
def run_graph() -> Callable[..., GraphTrace]:
    """Runs whole graphs for some updates: `graph.testing.run_graph`."""
    from graph.testing.graphs import run_graph

    return run_graph


@pytest.fixture
def make_app() -> Iterator[Callable[..., App]]:
    """Makes Apps that are closed after the test:

    `make_app("file.yaml", ...)` for a graph file, else as `graph.sim.App`.

    With `stage=` or without a first argument the options are those of `App`; with a graph file those of
    `App.from_file`.
    """
    from graph.isaac.managers.app import App

    with ExitStack() as cleanup:

        def make(file: str | Path | None = None, **options: Any) -> App:
            return cleanup.enter_context(App(**options) if file is None else App.from_file(file, **options))

        yield make


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Takes files named *.test.yaml (.yml, .json) with a `tickgraph...` key; ignores all others."""
    if not file_path.name.lower().endswith(_SUFFIXES) or not _is_ours(file_path):
        return None
    return GraphTests.from_parent(parent, path=file_path)


def _is_ours(path: Path) -> bool:
    """Reads as `graph.base.inputs.start_of` does, which cannot be imported here: `graph` may be the project's own."""
    flags = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
    try:
        with open(path, "rb", opener=lambda name, mode: os.open(name, mode | flags)) as stream:
            regular = stat.S_ISREG(os.fstat(stream.fileno()).st_mode)
            return regular and _MARKER.search(stream.read(_HEAD)) is not None
    except OSError:
        return False


class WrongTestFileError(Exception):
    """The test file itself is wrong; its lines say where."""


class FailedError(Exception):
    """A case failed; its lines show expected and actual results."""


class GraphTests(pytest.File):
    """One *.test.yaml file."""

    def collect(self) -> Iterable[pytest.Item]:
        """One item for each case. Raises WrongTestFileError with every mistake of the file."""
        from graph.testing.cases import read_cases

        file = read_cases(self.path)
        if file.problems:
            raise WrongTestFileError("\n".join(map(str, file.problems)))
        for case in file.cases:
            yield GraphTest.from_parent(self, name=case.name, case=case)

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Returns lines instead of a traceback."""
        if isinstance(excinfo.value, WrongTestFileError):
            return str(excinfo.value)
        return super().repr_failure(excinfo)


class GraphTest(pytest.Item):
    """One case."""

    def __init__(self, *, case: Case, **options: Any) -> None:
        super().__init__(**options)
        self._case = case

    def runtest(self) -> None:
        """Runs the case. Raises FailedError with every expectation that was not met."""
        from graph.testing.checking import check_cases
        from graph.testing.running import run_case

        problems = check_cases([self._case])
        if problems:
            raise WrongTestFileError("\n".join(map(str, problems)))
        outcome = run_case(self._case)
        if not outcome.passed:
            raise FailedError("\n".join(map(str, outcome.failures)))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Returns lines instead of a traceback."""
        if isinstance(excinfo.value, (FailedError, WrongTestFileError)):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int, str]:
        """The place of the case."""
        return self.path, self._case.mark.line - 1, self.name
