"""From a graph file to graphs that run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from .errors import Problem, UserError
from .evaluate import Graph
from .spec import FileSpec


@dataclass(frozen=True, slots=True)
class LoadedFile:
    """What a file says (`spec`) and its graphs, compiled, in file order."""

    spec: FileSpec
    graphs: tuple[Graph, ...]

    def graph(self, path: str) -> Graph:
        """The graph of that path. Raises KeyError with the nearest one."""
        from .suggest import did_you_mean

        for graph in self.graphs:
            if graph.path == path:
                return graph
        raise KeyError(f'no graph "{path}"{did_you_mean(path, (graph.path for graph in self.graphs))}')


def load_graph(path: str | Path, allow: Iterable[Path] = ()) -> LoadedFile:
    """Loads a YAML or JSON graph file and compiles its graphs.

    allow: folders, beside the file's own, that it may name files in. Raises UserError with every problem of the file
    and of its graphs together.
    """
    from .files import examine
    from .plan import compile_graphs

    examined = examine(path, allow=tuple(allow))
    problems: list[Problem] = list(examined.problems)
    graphs: list[Graph] = []
    if examined.spec is not None:
        try:
            graphs = compile_graphs(examined.spec.graphs)
        except UserError as error:
            problems += error.problems
    if problems or examined.spec is None:
        raise UserError(problems)
    return LoadedFile(examined.spec, tuple(graphs))
