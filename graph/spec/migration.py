"""Old files: type ids and attributes that were renamed since, and what became of them.

Sources: the extension renaming of Isaac Sim 4.5 (`omni.isaac.*` to `isaacsim.*`), the removal of the ROS 1 bridge, and
the attributes of older type versions found in saved graphs. An id that a registered type has is never touched.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from graph.base.errors import Mark
from graph.node.absent import why_absent
from graph.node.registry import DEFAULT, Registry

from .file_spec import ConnectionSpec, FileSpec, GraphSpec, NodeSpec, Note

PREFIXES: Mapping[str, tuple[str, ...]] = {
    "omni.isaac.ros2_bridge.": ("isaacsim.ros2.bridge.",),
    "omni.isaac.ros_bridge.": ("isaacsim.ros2.bridge.",),
    "isaacsim.ros2.nodes.": ("isaacsim.ros2.bridge.",),
    "isaacsim.ros1.bridge.": ("isaacsim.ros2.bridge.",),
    "omni.isaac.core_nodes.": ("isaacsim.core.nodes.",),
    "omni.isaac.wheeled_robots.": ("isaacsim.robot.wheeled_robots.",),
    "isaacsim.robot.wheeled_robots.nodes.": ("isaacsim.robot.wheeled_robots.",),
    "omni.isaac.sensor.": (
        "isaacsim.sensors.physics.",
        "isaacsim.sensors.rtx.",
        "isaacsim.sensors.physx.",
        "isaacsim.sensors.rtx.nodes.Ogn",
    ),
    "omni.isaac.isaac_sensor.": ("isaacsim.sensors.physics.", "isaacsim.sensors.rtx.", "isaacsim.sensors.physx."),
    "omni.isaac.range_sensor.": ("isaacsim.sensors.physx.", "isaacsim.sensors.rtx.", "isaacsim.sensors.physics."),
    "isaacsim.sensors.physics.nodes.": ("isaacsim.sensors.physics.",),
    "isaacsim.sensors.rtx.nodes.": ("isaacsim.sensors.rtx.", "isaacsim.sensors.rtx.nodes.Ogn"),
    "omni.isaac.conveyor.": ("isaacsim.asset.gen.conveyor.",),
    "omni.isaac.surface_gripper.": ("isaacsim.robot.surface_gripper.",),
    "omni.isaac.manipulators.": ("isaacsim.robot.manipulators.",),
    "omni.isaac.debug_draw.": ("isaacsim.util.debug_draw.",),
    "isaacsim.ucx.bridge.": ("isaacsim.ucx.nodes.",),
    "isaacsim.ucx.nodes.": ("isaacsim.ucx.bridge.",),
    "omni.graph.ui.": ("omni.graph.ui_nodes.",),
    "omni.graph.action_nodes.": ("omni.graph.action.",),
    "omni.graph.action_nodes_core.": ("omni.graph.action.",),
    "omni.graph.nodes_core.": ("omni.graph.nodes.",),
}
"""Old beginnings of type ids to what they may have become; the first that gives a registered type is taken."""

TYPES: Mapping[str, str] = {
    "omni.graph.nodes.ReadVariable": "omni.graph.core.ReadVariable",
    "omni.graph.nodes.WriteVariable": "omni.graph.core.WriteVariable",
    "omni.graph.ui.PrintText": "omni.graph.ui_nodes.PrintText",
    "omni.graph.action.PrintText": "omni.graph.ui_nodes.PrintText",
    "omni.isaac.core_nodes.IsaacSetViewportResolution": "isaacsim.core.nodes.IsaacSetViewportResolution",
    "omni.graph.scriptnode.OgnScriptNode": "omni.graph.scriptnode.ScriptNode",
    "omni.graph.nodes.MakeArray": "omni.graph.nodes.ConstructArray",
}
"""Ids that follow no rule."""

RENAMED: Mapping[str, Mapping[str, str]] = {
    "isaacsim.core.nodes.IsaacReadSimulationTime": {},
    "isaacsim.ros2.bridge.ROS2Context": {"inputs:domainId": "inputs:domain_id"},
    "isaacsim.ros2.bridge.ROS2PublishTransformTree": {"inputs:targetPrim": "inputs:targetPrims"},
    "isaacsim.core.nodes.IsaacArticulationController": {"inputs:usePath": ""},
    "isaacsim.core.nodes.IsaacComputeOdometry": {"inputs:robotPrim": "inputs:chassisPrim"},
    "omni.graph.nodes.ConstructArray": {f"inputs:{old}": f"inputs:input{new}" for new, old in enumerate("abcde")},
}
"""Attributes by new type id: old full name to the new one, "" for one that is gone."""

REMOVED: Mapping[str, str] = {
    "inputs:swhFrameNumber": "use the reference time inputs for the time of a past frame",
    "inputs:resetSimulationTimeOnStop": "set resetOnStop of the node that reads the time",
    "inputs:viewport": "connect renderProductPath",
    "inputs:forceUSDRead": "values are always read as they are now",
    "inputs:nodeType": "it has no meaning any more",
}
"""Attributes that old type versions had, wherever the present type has none of that name, and what to do instead."""


MEANT_NOTHING: Mapping[str, tuple[int, Mapping[str, Any]]] = {
    "omni.graph.nodes.ReadPrimAttribute": (3, {"usdTimecode": -1}),
    "omni.graph.nodes.ReadPrimAttributes": (3, {"usdTimecode": -1}),
}
"""By type: the version from which on these values mean what they say; before, files had them as the unset ones."""


def upgraded(type_id: str, version: int | None, inputs: Mapping[str, Any]) -> Mapping[str, Any]:
    """The inputs that a file of an old type version sets, as the present version would have them."""
    since, unset = MEANT_NOTHING.get(type_id, (0, {}))
    if version is None or version >= since:
        return inputs
    return {name: value for name, value in inputs.items() if name not in unset or value != unset[name]}


@dataclass(slots=True)
class Notes:
    """Notes of one file: each said once, for the first place it holds, with how many more there are."""

    first: dict[tuple[str, str], tuple[Mark | None, str]] = field(default_factory=dict)
    more: dict[tuple[str, str], int] = field(default_factory=dict)

    def add(self, code: str, message: str, mark: Mark | None, path: str) -> None:
        """Notes what holds at `mark`, or where there is none at the prim path."""
        key = (code, message)
        if key in self.first:
            self.more[key] = self.more.get(key, 0) + 1
        else:
            self.first[key] = mark, path

    def all(self) -> tuple[Note, ...]:
        """Every note, in the order they came up."""

        def line(key: tuple[str, str]) -> str:
            count = self.more.get(key)
            return f"{key[1]} (and {count} more)" if count else key[1]

        return tuple((key[0], str(mark or path), line(key)) for key, (mark, path) in self.first.items())


def migrated_type(type_id: str, registry: Registry = DEFAULT) -> tuple[str, str | None]:
    """The present id of a type and, where it differs, a sentence that says so; an unknown id comes back unchanged.

    An id that moved to a type which is not registered here gets its new name too, so that messages show it.
    """
    if type_id in registry:
        return type_id, None
    new = TYPES.get(type_id) or _by_prefix(type_id, registry)
    if new is None or (new not in registry and not type_id.startswith("omni.isaac.")):
        return type_id, None
    if "ROS1" in type_id or ".ros_bridge." in type_id or ".ros1." in type_id:
        if new in registry:
            return new, f'the ROS 1 node type "{type_id}" is gone; its ROS 2 twin "{new}" runs instead'
        if why_absent(new) is None:
            return type_id, None  # no twin: the message about an unknown type shows the file's own id
        return new, f'the ROS 1 node type "{type_id}" is gone; its ROS 2 twin is "{new}"'
    return new, f'node type "{type_id}" is now called "{new}"; the new name is used'


def _by_prefix(type_id: str, registry: Registry) -> str | None:
    for old in sorted(PREFIXES, key=len, reverse=True):
        if not type_id.startswith(old):
            continue
        name = type_id[len(old) :].replace("ROS1", "ROS2")
        spellings = dict.fromkeys((name, f"Ogn{name}", name.removeprefix("Ogn")))
        candidates = [new + spelling for new in PREFIXES[old] for spelling in spellings]
        known = next((one for one in candidates if one in registry), None)
        likely = next((one for one in candidates if "RTX" in name and ".rtx." in one), candidates[0])
        return known or likely
    return None


def migrate(spec: FileSpec, registry: Registry = DEFAULT) -> FileSpec:
    """The file with every old id and attribute brought up to date; each change is noted once for the whole file."""
    notes = Notes()
    graphs = tuple(_graph(graph, registry, notes) for graph in spec.graphs)
    if not notes.first and all(new is old for new, old in zip(graphs, spec.graphs, strict=True)):
        return spec
    return replace(spec, graphs=graphs, notes=(*spec.notes, *notes.all()))


def _graph(graph: GraphSpec, registry: Registry, notes: Notes) -> GraphSpec:
    fed = _fed_inputs(graph)
    types: dict[str, tuple[str, str | None]] = {}
    changes: dict[str, Mapping[str, str]] = {}
    nodes = []
    for node in graph.nodes:
        if node.type not in types:
            types[node.type] = migrated_type(node.type, registry)
        type_id, sentence = types[node.type]
        if sentence:
            notes.add("type-renamed", sentence, node.mark, f"{graph.path}/{node.name}")
            node = replace(node, type=type_id)
        renamed = _renamed(node, graph, fed.get(node.name, ()), registry, notes)
        if renamed:
            changes[node.name] = renamed
            node = replace(
                node,
                inputs=_with_names(node.inputs, renamed),
                input_marks=_with_names(node.input_marks, renamed),
                attributes=_with_names(node.attributes, renamed),
            )
        nodes.append(node)
    if all(new is old for new, old in zip(nodes, graph.nodes, strict=True)):
        return graph
    return replace(graph, nodes=tuple(nodes), connections=tuple(_connections(graph, changes)))


def _renamed(node: NodeSpec, graph: GraphSpec, fed: Sequence[str], registry: Registry, notes: Notes) -> dict[str, str]:
    """The attributes of a node that have another name now, or none (""); `fed` are those that connections lead to."""
    table = RENAMED.get(node.type, {})
    found: dict[str, str] = {}
    for key in dict.fromkeys((*node.inputs, *fed)) if table or _has_old(node) else ():
        full = key if ":" in key and key.split(":")[0] in ("inputs", "outputs", "state") else f"inputs:{key}"
        change = changed_attribute(node.type, full, registry)
        if change is None:
            continue
        found[full], code, sentence = change
        notes.add(code, sentence, node.input_marks.get(key, node.mark), f"{graph.path}/{node.name}")
    return found


def changed_attribute(type_id: str, full: str, registry: Registry = DEFAULT) -> tuple[str, str, str] | None:
    """What an old attribute of a present type is called now, "" where it is gone, with a warning's code and sentence.

    None for one that the type has, or of which nothing is known.
    """
    table = RENAMED.get(type_id, {})
    prefix, _, name = full.partition(":")
    if full not in table and (full not in REMOVED or type_id not in registry):
        return None
    if type_id in registry and registry.get(type_id).find(prefix, name) is not None:
        return None
    kind, new = type_id.rpartition(".")[2], table.get(full, "")
    if new:
        return new, "attribute-renamed", f"{kind}: {full} is now called {new}; the new name is used"
    return "", "attribute-removed", f"{kind}: {full} is gone and is left out; {REMOVED.get(full, 'remove it')}"


def _has_old(node: NodeSpec) -> bool:
    return any(f"inputs:{key}" in REMOVED for key in node.inputs)


def _fed_inputs(graph: GraphSpec) -> Mapping[str, list[str]]:
    """What connections lead to, by the node's name."""
    found: dict[str, list[str]] = {}
    for one in graph.connections:
        node, _, attribute = one.target.rpartition(".")
        found.setdefault(node, []).append(attribute)
    return found


def _with_names(values: Mapping[str, Any], renamed: Mapping[str, str]) -> dict[str, Any]:
    kept = {}
    for key, value in values.items():
        full = key if key.startswith(("inputs:", "outputs:", "state:")) else f"inputs:{key}"
        if full not in renamed:
            kept[key] = value
        elif renamed[full]:
            kept.setdefault(renamed[full].removeprefix("inputs:") if key != full else renamed[full], value)
    return kept


def _connections(graph: GraphSpec, changes: Mapping[str, Mapping[str, str]]) -> Iterable[ConnectionSpec]:
    for connection in graph.connections:
        node, _, attribute = connection.target.rpartition(".")
        full = attribute if ":" in attribute else f"inputs:{attribute}"
        renamed = changes.get(node, {})
        if full not in renamed:
            yield connection
        elif renamed[full]:
            yield replace(connection, target=f"{node}.{renamed[full]}")
