"""What nodes and their connections lose in another product."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from graph.node.declaration import NEVER_FIRES, PHYSICS_STEP
from graph.session.graph_links import TIMES

from .case import Case, Found, finds

if TYPE_CHECKING:
    from pxr import Usd

EXTRACT = "isaacsim.sensors.rtx.nodes.OgnIsaacExtractRTXSensorPointCloud"
REPLACED = {
    "IsaacCreateRTXLidarScanBuffer": EXTRACT,
    "IsaacComputeRTXLidarFlatScan": "ROS2RtxLidarHelper with type laser_scan",
    "IsaacReadRTXLidarData": EXTRACT,
    "IsaacReadRTXLidarPointData": EXTRACT,
    "IsaacComputeRTXLidarPointCloud": EXTRACT,
    "IsaacComputeRTXRadarPointCloud": EXTRACT,
    "IsaacPrintRTXLidarInfo": "inspect_lidar_gmo, a script",
    "IsaacPrintRTXRadarInfo": "inspect_radar_gmo, a script",
    "IsaacRenderVarToCpuPointer": "omni.syntheticdata.SdRenderVarPtr",
}
"""Node types that 6.0 deprecates or no longer has, by their last part without `Ogn`, and what replaces them."""
GATE = "isaacsim.core.nodes.IsaacSimulationGate"
CONTROLLER = "isaacsim.core.nodes.IsaacArticulationController"
WRITER = "omni.graph.nodes.WritePrimAttribute"
PLACES = ("xformOp:translate", "xformOp:orient", "xformOp:rotate", "xformOp:transform")
WAITING = ("physics:", "physxScene:", "physxRigidBody:", "physxJoint:", "drive:", "omni:sensor:")
"""Attributes whose values play reads once; targets of drives are live."""
LIVE = ("TargetPosition", "TargetVelocity", "targetPosition", "targetVelocity", "physics:velocity", "angularVelocity")


def last_part(type_id: str) -> str:
    """The name of a node type without its extension and `Ogn`."""
    return type_id.rpartition(".")[2].removeprefix("Ogn")


@finds("frame-skip-deprecated")
def _frame_skip(case: Case) -> Iterator[Found]:
    for node in case.links.nodes:
        if "frameSkipCount" in node.type.inputs and (count := node.get("frameSkipCount")):
            yield f"{node.path}.inputs:frameSkipCount", f"it leaves out {count} frames between two messages"


@finds("full-scan-deprecated")
def _full_scan(case: Case) -> Iterator[Found]:
    for node in case.links.nodes:
        if "fullScan" in node.type.inputs and case.gives(node, "fullScan"):
            yield f"{node.path}.inputs:fullScan", f"it is {str(node.get('fullScan')).lower()}"


@finds("node-deprecated")
def _deprecated(case: Case) -> Iterator[Found]:
    for graph in case.spec.graphs:
        for node in graph.nodes:
            if instead := REPLACED.get(last_part(node.type)):
                yield f"{graph.path}/{node.name}", f"{last_part(node.type)} gives way to {instead}"


@finds("timeline-stamp")
def _wrong_clock(case: Case) -> Iterator[Found]:
    for link in case.links.all:
        if link.input in link.target.type.inputs_as("stamp"):
            for source in case.links.data_sources(link):
                clock = source.source.type.find("outputs", source.output)
                if clock is not None and clock.role in TIMES:
                    yield (
                        f"{link.target.path}.inputs:{link.input}",
                        f"gets {source.source.name}.{source.output}: {TIMES[clock.role]}",
                    )


@finds("system-time-never-resets")
def _no_reset(case: Case) -> Iterator[Found]:
    for node in case.links.nodes:
        has_both = node.type.inputs.keys() >= {"useSystemTime", "resetSimulationTimeOnStop"}
        if has_both and node.get("useSystemTime") and node.get("resetSimulationTimeOnStop"):
            yield f"{node.path}.inputs:resetSimulationTimeOnStop", "it is true beside useSystemTime"


@finds("physics-step-stage")
def _not_on_demand(case: Case) -> Iterator[Found]:
    for node in case.links.nodes:
        if node.type.phase == PHYSICS_STEP and node.graph.pipeline_stage != "on_demand":
            yield node.path, NEVER_FIRES.format(stage=node.graph.pipeline_stage).partition(";")[0]


@finds("gate-step-zero")
def _gate(case: Case) -> Iterator[Found]:
    for node in case.links.nodes:
        if node.type.id == GATE and not node.connected("step") and node.get("step") == 0:
            yield f"{node.path}.inputs:step", "step is 0"


@finds("joint-indices-zero")
def _first_joint(case: Case) -> Iterator[Found]:
    for node in case.links.nodes:
        if node.type.id != CONTROLLER or any(node.connected(name) for name in ("jointIndices", "jointNames")):
            continue
        if list(node.get("jointIndices")) == [0] and not len(node.get("jointNames")):
            yield f"{node.path}.inputs:jointIndices", "jointIndices is [0]"


@finds("fabric-parent-moved")
def _moved_parents(case: Case) -> Iterator[Found]:
    for place, prim, name in _written_attributes(case):
        if name.startswith(PLACES) and (below := _bodies_below(prim)):
            yield place, f"it moves {prim.GetPath()}, above the body {below}"


@finds("edit-not-live")
def _late_edits(case: Case) -> Iterator[Found]:
    for place, prim, name in _written_attributes(case):
        if name.startswith(WAITING) and not name.endswith(LIVE):
            yield place, f"it writes {prim.GetPath()}.{name}"


def _written_attributes(case: Case) -> Iterator[tuple[str, Usd.Prim, str]]:
    """Nodes that write an attribute of a prim: their place, the prim, the attribute's name."""
    for node in case.links.nodes:
        if node.type.id == WRITER:
            paths = node.get("prim") or [node.get("primPath")]
            for prim in (case.stage.GetPrimAtPath(str(path)) for path in paths if path):
                if prim:
                    yield f"{node.path}.inputs:name", prim, str(node.get("name") or "")


def _bodies_below(prim: Usd.Prim) -> str:
    """The first rigid body below a prim; "" without one."""
    if "PhysicsRigidBodyAPI" in prim.GetAppliedSchemas() or "PhysicsArticulationRootAPI" in prim.GetAppliedSchemas():
        return ""
    from graph.sim.usd import Usd

    bodies = (one for one in Usd.PrimRange(prim) if "PhysicsRigidBodyAPI" in one.GetAppliedSchemas())
    return next((str(one.GetPath()) for one in bodies), "")
