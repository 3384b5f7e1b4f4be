"""Builds a `FileSpec` from validated models and their tree, and checks what the models alone cannot."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from graph.base.errors import Mark, Problem
from graph.spec.file_spec import (
    ClockSpec,
    ConnectionSpec,
    FileSpec,
    GraphSpec,
    NodeSpec,
    RecordSpec,
    SceneSpec,
    VariableSpec,
)

from . import connections, file_forms, paths
from .paths import is_own_file
from .source import Source
from .text import quoted
from .tree import Map, Seq, offset

_SCENE_SUFFIXES = {"usd": (".usd", ".usda", ".usdc", ".usdz"), "mjcf": (".xml",), "urdf": (".urdf", ".xml")}
LEAST_PART = 10_000
"""Least size of a part of a recording, in bytes."""
_MARKED_SECTIONS = ("scene", "clock", "settings", "fidelity", "randomize", "record")


class Builder:
    """Builds the specification of one file and collects the problems that it finds."""

    def __init__(
        self, source: Source, root: Map, problems: list[Problem], path: Path | None, folder: Path, allow: Sequence[Path]
    ) -> None:
        self.source = source
        self.root = root
        self.problems = problems
        self.path = path
        self.folder = folder
        self.allow = allow

    def build(self, file: file_forms.GraphFile) -> FileSpec:
        """The specification of a validated file, without the parts that are wrong."""
        return FileSpec(
            path=self.path,
            folder=self.folder,
            scene=self._scene(file.scene),
            clock=self._clock(file.clock),
            duration=file.duration,
            settings=file.settings,
            fidelity=file.fidelity,
            randomize=file.randomize,
            graphs=tuple(self._graph(path, graph) for path, graph in file.graphs.items()),
            record=self._record(file.record),
            marks=self._marks(),
        )

    def _scene(self, scene: file_forms.Scene) -> SceneSpec:
        given = [key for key in _SCENE_SUFFIXES if getattr(scene, key) is not None]
        if len(given) > 1:
            self._wrong(("scene", given[1]), f"scene: give {' or '.join(given)}, not both", key=True)
        if scene.keyframe is not None and scene.mjcf is None:
            self._wrong(("scene", "keyframe"), "scene.keyframe: only an MJCF model (scene.mjcf) has any", key=True)
        prims = self.root.get("scene")
        prims = prims.get("prims") if isinstance(prims, Map) else None
        return SceneSpec(
            usd=self._scene_file("usd", scene.usd),
            mjcf=self._scene_file("mjcf", scene.mjcf) or self._scene_file("urdf", scene.urdf),
            is_urdf=scene.urdf is not None,
            prims={path: self._prim(path, keys) for path, keys in scene.prims.items()},
            mark=self._key_mark("scene") if "scene" in self.root else None,
            prim_marks=dict(self._prim_marks(prims)) if isinstance(prims, Map) else {},
            keyframe=scene.keyframe,
        )

    def _scene_file(self, key: str, text: str | None) -> Path | None:
        if text is None:
            return None
        suffixes = _SCENE_SUFFIXES[key]
        if not text.lower().endswith(suffixes):
            other = next((one for one, ends in _SCENE_SUFFIXES.items() if text.lower().endswith(ends)), None)
            hint = f"; did you mean scene: {{{other}: {text}}}?" if other and "urdf" in (key, other) else ""
            self._wrong(("scene", key), f"scene.{key}: {quoted(text)} does not end in {' or '.join(suffixes)}{hint}")
            return None
        return self._file(("scene", key), f"scene.{key}", text)

    def _prim(self, path: str, keys: Mapping[str, Any]) -> Mapping[str, Any]:
        """The prim with absolute file names; a config without `.json` is a name, not a file."""
        resolved = dict(keys)
        for key in ("config", "reference"):
            text = keys.get(key)
            if isinstance(text, str) and is_own_file(key, text):
                file = self._file(("scene", "prims", path, key), f"prim {path}: {key}", text)
                if file is None:
                    del resolved[key]
                else:
                    resolved[key] = str(file)
        return resolved

    def _prim_marks(self, prims: Map) -> Iterator[tuple[tuple[str, ...], Mark]]:
        for path, keys in prims.items():
            yield (path,), self.source.mark(prims.places[path][0])
            if isinstance(keys, Map):
                for key in keys:
                    yield (path, key), self.source.mark(keys.places[key][0])

    def _file(self, location: Sequence[str], name: str, text: str) -> Path | None:
        try:
            return paths.confined(text, self.folder, self.allow)
        except ValueError as error:
            self._wrong(location, f"{name}: {error}")
            return None

    def _clock(self, clock: file_forms.Clock) -> ClockSpec:
        both = clock.physics_hz, clock.loop_hz
        if clock.experience == "zero_delay" and None not in both and both[0] != both[1]:
            self._wrong(
                ("clock", "physics_hz"),
                f"clock: zero_delay needs physics_hz = loop_hz, found {both[0]} and {both[1]}; give one of them",
                key=True,
            )
            clock = clock.replaced(physics_hz=None)  # report one mistake once
        mark = self._key_mark("clock") if "clock" in self.root else None
        return ClockSpec(clock.physics_hz, clock.loop_hz, clock.experience, clock.parity, mark)

    def _record(self, record: file_forms.Record) -> RecordSpec:
        try:
            name = paths.output_name(record.mcap)
        except ValueError as error:
            self._wrong(("record", "mcap"), f"record.mcap: {error}")
            name = file_forms.Record().mcap
        size, seconds = record.split_size, record.split_seconds
        if size is not None and size < LEAST_PART:
            self._wrong(("record", "split_size"), f"record.split_size: {size} bytes; give {LEAST_PART:,} or more")
        if not record.topics and "topics" in record.given:
            self._wrong(
                ("record", "topics"), "record.topics: the list is empty; leave it out for all, or write exclude: ['*']"
            )
        for key in ("topics", "exclude"):
            for index, topic in enumerate(getattr(record, key)):
                if not topic.strip("/ "):
                    self._wrong(
                        ("record", key, str(index)), f"record.{key}: a topic is empty; name one, such as /points"
                    )
        return RecordSpec(name, size, seconds, tuple(record.topics), tuple(record.exclude))

    def _graph(self, path: str, graph: file_forms.Graph) -> GraphSpec:
        tree = self.root["graphs"][path]
        tree = tree if isinstance(tree, Map) else Map()
        return GraphSpec(
            path=path,
            nodes=tuple(self._nodes(graph, tree.get("nodes"))),
            connections=tuple(self._connections(graph, tree.get("connections"))),
            evaluator=graph.evaluator,
            pipeline_stage=graph.pipeline_stage,
            variables={
                name: VariableSpec(variable.type, variable.value, self.source.mark(tree["variables"].places[name][0]))
                for name, variable in graph.variables.items()
            },
            mark=self._key_mark("graphs", path),
            unfinished=graph.lenient,
            saved=graph.lenient,
            evaluation_mode=graph.evaluation_mode,
            instances=graph.instances,
        )

    def _nodes(self, graph: file_forms.Graph, tree: Map | None) -> Iterator[NodeSpec]:
        if tree is None:
            return
        mark = self.source.mark
        for name, node in graph.nodes.items():
            inputs: dict[str, Any] = {}
            marks: dict[str, Mark] = {}
            written = tree[name]
            if isinstance(written, Map):
                self._values(name, written.get("inputs"), "inputs:", inputs, marks)
                self._values(name, written.get("state"), "state:", inputs, marks)
            yield NodeSpec(name, node.type, inputs, mark(tree.places[name][0]), marks, node.attributes)

    def _values(
        self, node: str, written: Map | None, prefix: str, values: dict[str, Any], marks: dict[str, Mark]
    ) -> None:
        """Adds the values that the file sets, by attribute name: inputs without prefix, state attributes with
        `state:`.
        """
        for key, value in (written or {}).items():
            at = written.places[key][0] if written else 0
            name = key.removeprefix(prefix)
            if not name or name.startswith("outputs:") or (prefix == "state:" and name.startswith("inputs:")):
                message = f"node {quoted(node)}: {quoted(key)} cannot be set; only inputs and state can"
                self.problems.append(self.source.problem(at, message))
                continue
            if prefix == "state:" or name.startswith("state:"):
                name = f"state:{name.removeprefix('state:')}"
            if name in values:
                message = f"node {quoted(node)}: {quoted(key)} is set twice; remove one"
                self.problems.append(self.source.problem(at, message))
                continue
            values[name] = value
            marks[name] = self.source.mark(at)

    def _connections(self, graph: file_forms.Graph, tree: Seq | None) -> Iterator[ConnectionSpec]:
        if tree is None:
            return
        source = self.source
        for text, at in zip(graph.connections, tree.item_at, strict=True):
            try:
                links = connections.parse(text)
            except ValueError as error:
                self.problems.append(source.problem(at, str(error)))
                continue
            if len(links) == 1:
                yield ConnectionSpec(links[0].source, links[0].target, source.mark(at))
                continue
            start = self._text_start(text, at)
            for link in links:
                place = at if start is None else start + link.target_at
                yield ConnectionSpec(link.source, link.target, source.mark(place))

    def _text_start(self, text: str, at: int) -> int | None:
        """The offset of a scalar's first character, if the file holds the text unchanged (no escapes, no folding)."""
        for start in (at, at + 1):
            if self.source.text.startswith(text, start):
                return start
        return None

    def _marks(self) -> dict[tuple[str, ...], Mark]:
        marks: dict[tuple[str, ...], Mark] = {}
        for key, value in self.root.items():
            marks[(key,)] = self._key_mark(key)
            if key in _MARKED_SECTIONS and isinstance(value, Map):
                for inner in value:
                    marks[(key, inner)] = self.source.mark(value.places[inner][0])
        return marks

    def _key_mark(self, *location: str) -> Mark:
        return self.source.mark(offset(self.root, location, key=True))

    def _wrong(self, location: Sequence[str], message: str, *, key: bool = False) -> None:
        self.problems.append(self.source.problem(offset(self.root, location, key=key), message))
