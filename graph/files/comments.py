"""Comments of a YAML graph file: what stands above the file's first key, above a graph, above or beside a node."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from .tree import Map

_TEXT_OR_COMMENT = re.compile(r'"(?:[^"\\]|\\.)*"|\'(?:[^\']|\'\')*\'|(?P<comment>(?:^|(?<=\s))#.*)')


def comments_of(root: Map, text: str) -> dict[str, str]:
    """Comments by the path of their graph or node, "" for the head of the file; without the `#`."""
    lines = text.splitlines()
    found = {"": _head(lines)}
    starts = _starts(text)
    for path, key_at in _keys(root):
        line = _line_of(starts, key_at)
        above = _above(lines, line)
        beside = _beside(lines[line]) if line < len(lines) else ""
        found[path] = "\n".join(filter(None, (above, beside)))
    return {path: comment for path, comment in found.items() if comment}


def _keys(root: Map) -> Iterator[tuple[str, int]]:
    graphs = root.get("graphs")
    if not isinstance(graphs, Map):
        return
    for path, graph in graphs.items():
        yield path, graphs.places[path][0]
        nodes = graph.get("nodes") if isinstance(graph, Map) else None
        if isinstance(nodes, Map):
            yield from ((f"{path}/{name}", nodes.places[name][0]) for name in nodes)


def _starts(text: str) -> list[int]:
    return [0, *(found.end() for found in re.finditer("\r\n|\n|\r", text))]


def _line_of(starts: Sequence[int], at: int) -> int:
    from bisect import bisect_right

    return bisect_right(starts, at) - 1


def _head(lines: Sequence[str]) -> str:
    """The comment lines that the file begins with."""
    head = []
    for line in lines:
        if line.strip() and not line.lstrip().startswith("#"):
            break
        head.append(_bare(line))
    return "\n".join(head).strip("\n")


def _above(lines: Sequence[str], line: int) -> str:
    """The comment lines directly above a line; those at the top of the file are its head."""
    first = line
    while first > 0 and lines[first - 1].lstrip().startswith("#"):
        first -= 1
    if all(not one.strip() or one.lstrip().startswith("#") for one in lines[:line]):
        return ""
    return "\n".join(map(_bare, lines[first:line]))


def _beside(line: str) -> str:
    for token in _TEXT_OR_COMMENT.finditer(line):
        if token["comment"]:
            return _bare(token["comment"])
    return ""


def _bare(line: str) -> str:
    return re.sub(r"^\s*# ?", "", line).rstrip()
