"""What the rules look at: a file's compiled graphs, its stage and its settings, and where each part is written."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from graph.base.errors import Mark
from graph.base.records import dataclass
from graph.session.graph_links import Links

if TYPE_CHECKING:
    from pxr import Usd

    from graph.evaluate import Graph, Node
    from graph.sim.settings import Settings
    from graph.spec.file_spec import FileSpec, NodeSpec

SENSORS = ("OmniLidar", "OmniRadar", "Camera")
Found = tuple[str, str]
"""What it concerns (a prim, PRIM.ATTRIBUTE, NODE.inputs:NAME, a setting or `clock`), and what is wrong with it."""
Finder = Callable[["Case"], Iterator[Found]]
FINDERS: dict[str, list[Finder]] = {}


def finds(code: str) -> Callable[[Finder], Finder]:
    """Declares a function that finds what breaks a rule in graph files."""

    def register(finder: Finder) -> Finder:
        FINDERS.setdefault(code, []).append(finder)
        return finder

    return register


@dataclass(frozen=True, slots=True)
class Asked:
    """A render product that a script makes of a sensor, or what it asks of one: names of outputs; and where."""

    prim: str
    names: tuple[str, ...]
    mark: Mark

    @property
    def subject(self) -> str:
        """What findings call it."""
        return f"line {self.mark.line}, column {self.mark.column}"


class Case:
    """A graph file, as the rules see it. settings: the file's, over the defaults of its profile.

    by_script: what a script asks of sensors beside its graphs.
    """

    def __init__(
        self,
        spec: FileSpec,
        graphs: list[Graph],
        stage: Usd.Stage,
        settings: Settings,
        by_script: Sequence[Asked] = (),
    ) -> None:
        self.spec = spec
        self.stage = stage
        self.settings = settings
        self.by_script = by_script
        self.links = Links(graphs)
        self.written: Mapping[str, NodeSpec] = {
            f"{graph.path}/{node.name}": node for graph in spec.graphs for node in graph.nodes
        }

    def setting(self, path: str) -> Any:
        """A setting's value; None for an unset one without a default."""
        return self.settings.get(path)

    def prims(self, *types: str) -> Iterator[Usd.Prim]:
        """The sensor prims of these types on the stage."""
        return (prim for prim in self._sensors if prim.GetTypeName() in types)

    @cached_property
    def _sensors(self) -> list[Usd.Prim]:
        return [prim for prim in self.stage.Traverse() if prim.GetTypeName() in SENSORS]

    def rendered(self, *types: str) -> list[Usd.Prim]:
        """The prims of these types that nodes or a script have rendered."""
        paths = (*(path for _, path in self.links.makers), *(one.prim for one in self.by_script))
        prims = {path: self.stage.GetPrimAtPath(path) for path in paths}
        return [prim for prim in prims.values() if prim and prim.GetTypeName() in types]

    def sensors_behind(self, node: Node) -> list[Usd.Prim]:
        """The prims whose render product a node gets."""
        return list(filter(None, map(self.stage.GetPrimAtPath, self.links.sensors_behind(node))))

    def consumers(self) -> Iterator[tuple[Node, Usd.Prim, frozenset[str]]]:
        """Each node that asks a sensor for quantities beyond the points, the sensor, and the channels."""
        for node, path, channels in self.links.consumers():
            if prim := self.stage.GetPrimAtPath(path):
                yield node, prim, channels

    def gives(self, node: Node, name: str) -> bool:
        """Whether the file itself writes an input of a node."""
        spec = self.written.get(node.path)
        return spec is not None and (name in spec.inputs or f"inputs:{name}" in spec.inputs)

    # -- places --------------------------------------------------------------------------------------------------------

    def mark(self, subject: str) -> Mark | None:
        """The place in the file at which something is written (see `Found`)."""
        spec = self.spec
        for one in self.by_script:
            if one.subject == subject:
                return one.mark
        if subject.startswith("clock"):
            return spec.clock.mark
        if mark := spec.marks.get(("settings", subject)):
            return mark
        path, _, name = subject.partition(".")
        if node := self.written.get(path):
            return node.input_marks.get(name.removeprefix("inputs:"), node.mark)
        marks = spec.scene.prim_marks
        inline = marks.get((path, name)) or (name and marks.get((path, "attributes"))) or marks.get((path,))
        return inline or self._in_scene(subject)

    def _in_scene(self, subject: str) -> Mark | None:
        """The place of a prim or attribute in the text of the USD scene."""
        from graph.usd_files.places import Text

        scene = self.spec.scene.usd or self.spec.path
        prim = self.stage.GetPrimAtPath(subject.partition(".")[0]) if subject.startswith("/") else None
        if scene is None or not prim or not any(spec.layer.realPath == str(scene) for spec in prim.GetPrimStack()):
            return None
        line, column = Text(str(scene), scene.name).line_and_column(subject)
        return Mark(str(scene), line, column) if line else None
