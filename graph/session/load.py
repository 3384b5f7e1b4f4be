"""Loads a graph file and compiles its graphs."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from graph.base.errors import Problem, UserError
from graph.base.gc_pause import collector_paused
from graph.base.records import dataclass
from graph.evaluate import Graph
from graph.spec.file_spec import FileSpec


@dataclass(frozen=True, slots=True)
class LoadedFile:
    """The content of a file (`spec`) and its graphs, compiled, in file order."""

    spec: FileSpec
    graphs: tuple[Graph, ...]

    def graph(self, path: str) -> Graph:
        """The graph with that path. Raises KeyError with the nearest one."""
        from graph.base.suggest import did_you_mean

        for graph in self.graphs:
            if graph.path == path:
                return graph
        raise KeyError(f'no graph "{path}"{did_you_mean(path, (graph.path for graph in self.graphs))}')

    def to_networkx(self) -> Any:
        """All graphs as one `networkx.MultiDiGraph`, for analyses; see `graph.evaluate.links.to_networkx`."""
        from graph.evaluate.links import to_networkx

        return to_networkx(self.graphs)


@collector_paused()
def load_graph(path: str | Path, allow: Iterable[Path] = (), *, skip_unknown: bool = False) -> LoadedFile:
    """Loads a graph file (YAML, JSON or a USD scene with OmniGraph prims) and compiles its graphs.

    allow: further folders in which the file may name files, besides its own. skip_unknown: nodes of unknown types are
    left out. Raises UserError with every problem of the file and of its graphs together; warnings are in `spec.notes`.

    >>> loaded = load_graph("graphs/quickstart.yaml")
    >>> [graph.path for graph in loaded.graphs]
    ['/World/ActionGraph']
    """
    from graph.files import examine

    from .partial_compile import compile_file

    examined = examine(path, allow=tuple(allow))
    problems: list[Problem] = list(examined.problems)
    graphs: list[Graph] = []
    spec = examined.spec
    if spec is not None:
        try:
            graphs, spec = compile_file(spec, skip_unknown=skip_unknown)
        except UserError as error:
            problems += error.problems
    if problems or spec is None:
        raise UserError(problems)
    return LoadedFile(spec, tuple(graphs))
