"""Comments of a YAML graph file: each belongs to the key, or the connection, below it or on its line.

Places are texts: "" is the head of the file; the path of a graph or node stands for itself; `#clock` is a key of the
file, `/World/G#variables/gain` a key of a graph, `/World/G#a.x -> b.y` a connection, `#end` the end of the file.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator, Sequence

from . import connections
from .tree import Map, Seq

END = "#end"
"""Comments below the last key."""
_LINE = re.compile("\r\n|\n|\r")
_COMMENT = re.compile(r"(?:(?<=\s)|^)#[^\r\n]*", re.MULTILINE)


def comments_of(root: Map, text: str) -> dict[str, str]:
    """Every comment by its place, without the `#`; several comments at one place are joined by newlines."""
    if "#" not in text:
        return {}
    starts = [0, *(found.end() for found in _LINE.finditer(text))]
    lines = text.splitlines()
    places = sorted((at, len(place), place) for place, at in _places(root))
    first_on_line: dict[int, str] = {}
    for at, _, place in places:
        first_on_line.setdefault(bisect_right(starts, at) - 1, place)
    offsets = [at for at, _, _ in places]
    found: dict[str, list[str]] = {}
    for at, comment in _comments(text):
        line = bisect_right(starts, at) - 1
        alone = not text[starts[line] : at].strip()
        subject = _next_content(lines, line) if alone else line
        behind = bisect_right(offsets, at) - 1
        if alone and behind < 0:
            place = ""
        elif subject in first_on_line:
            place = first_on_line[subject]
        else:
            place = places[behind][2] if behind >= 0 and subject < len(lines) else END
        found.setdefault(place, []).append(re.sub(r"^# ?", "", comment).rstrip())
    return {place: text for place, parts in found.items() if (text := "\n".join(parts).strip("\n"))}


def place_of(at: Sequence[str]) -> str:
    """The place of the key at a location; `location`: the keys that lead to it."""
    if at[0] != "graphs" or len(at) == 1:
        return "#" + "/".join(at)
    if len(at) == 4 and at[2] == "nodes":
        return f"{at[1]}/{at[3]}"
    return "#".join(filter(None, (at[1], "/".join(at[2:]))))


def place_of_connection(graph: str, text: str) -> str:
    """The place of a connection, by its first source and target."""
    try:
        link = connections.parse(text)[0]
    except ValueError:
        return f"{graph}#{text}"
    return f"{graph}#{link.source} -> {link.target}"


def _places(root: Map) -> Iterator[tuple[str, int]]:
    """The places that have a line of their own, with their offsets."""
    for key, value in root.items():
        yield place_of((key,)), root.places[key][0]
        if not isinstance(value, Map) or key not in ("graphs", "scene"):
            continue
        for name, part in value.items():
            yield place_of((key, name)), value.places[name][0]
            if isinstance(part, Map) and (key, name) == ("scene", "prims"):
                yield from ((place_of((key, name, prim)), part.places[prim][0]) for prim in part)
            elif isinstance(part, Map) and key == "graphs":
                yield from _places_of_graph(name, part)


def _places_of_graph(path: str, graph: Map) -> Iterator[tuple[str, int]]:
    for key, value in graph.items():
        yield place_of(("graphs", path, key)), graph.places[key][0]
        if isinstance(value, Map) and key in ("nodes", "variables"):
            yield from ((place_of(("graphs", path, key, name)), value.places[name][0]) for name in value)
        elif isinstance(value, Seq) and key == "connections":
            for item, at in zip(value, value.item_at, strict=True):
                yield place_of_connection(path, str(item)), at


def _comments(text: str) -> Iterator[tuple[int, str]]:
    """Offset and text of every comment; a `#` inside a quoted or block scalar does not start one."""
    from ruamel.yaml import YAML
    from ruamel.yaml.events import ScalarEvent

    quoted = [
        (event.start_mark.index, event.end_mark.index)
        for event in YAML(typ="safe", pure=True).parse(text)
        if isinstance(event, ScalarEvent) and event.style in ("'", '"', "|", ">")
    ]
    starts = [start for start, _ in quoted]
    for one in _COMMENT.finditer(text):
        before = bisect_right(starts, one.start()) - 1
        if before < 0 or one.start() >= quoted[before][1]:
            yield one.start(), one.group()


def _next_content(lines: Sequence[str], line: int) -> int:
    """The next line with more than a comment; the number of lines if no such line follows."""
    while line < len(lines) and (not lines[line].strip() or lines[line].lstrip().startswith("#")):
        line += 1
    return line
