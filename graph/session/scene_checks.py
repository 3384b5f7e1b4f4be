"""Warnings about prims that a graph file writes: values of another unit or order, sensors below a scale."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pxr import Usd

    from graph.base.errors import Mark
    from graph.evaluate import Graph
    from graph.spec.file_spec import FileSpec, Note, SceneSpec

NEAR = 0.004
"""How near an angle must be to a multiple of an eighth of a turn in radians to be taken for one: 3.14 is."""
DEGREES = (
    "drive:angular:physics:targetPosition",
    "physics:lowerLimit",
    "physics:upperLimit",
    "physics:coneAngle0Limit",
    "physics:coneAngle1Limit",
    "inputs:angle",
    "inputs:shaping:cone:angle",
)
"""Attributes in degrees that look like radians as `rotate` does; limits of revolute joints only."""


def prim_notes(spec: FileSpec) -> Iterator[Note]:
    """Warnings about colours, angles and quaternions of the prims that a file writes."""
    scene = spec.scene
    for path, keys in scene.prims.items():
        attributes = keys.get("attributes")
        attributes = attributes if isinstance(attributes, Mapping) else {}
        yield from _colours(scene, path, keys.get("color"), "color")
        yield from _turns(scene, path, keys.get("rotate"), "rotate")
        yield from _orders(scene, path, keys.get("orient"))
        for name, value in attributes.items():
            if name == "primvars:displayColor":
                yield from _colours(scene, path, value, name)
            if name in DEGREES and (name[-5:] != "Limit" or keys.get("type") != "PhysicsPrismaticJoint"):
                yield from _turns(scene, path, value, name)


def fast_cameras(spec: FileSpec, graphs: Sequence[Graph]) -> Iterator[Note]:
    """A warning for each camera with a shipped configuration that renders more often than the real one."""
    from sensors.configs.cameras import find_camera

    loop = float(spec.clock.loop_hz or 60)
    for path in named_sensors(graphs):
        keys = spec.scene.prims.get(path, {})
        if keys.get("type") != "Camera" or "config" not in keys:
            continue
        attributes = keys.get("attributes") or {}
        rate = float(attributes.get("omni:sensor:tickRate") or 0)
        real = find_camera(keys["config"]).imager(keys.get("variant")).rate_hz
        if real and (rate or loop) > real:
            why = (
                f"its tick rate is {rate:g} Hz" if rate else f"without a tick rate it renders in all {loop:g} updates/s"
            )
            yield (
                "camera-faster-than-real",
                _place(spec.scene, path, "config"),
                f"{path}: {why}, and a {keys['config']} gives {real:g} Hz; write attributes: "
                f"{{omni:sensor:tickRate: {real:g}}}",
            )


def _colours(scene: SceneSpec, path: str, value: Any, key: str) -> Iterator[Note]:
    parts = _numbers(value)
    if parts and max(parts) > 1:
        shown = ", ".join(f"{part / 255:.3g}" for part in parts[:3])
        meant = f": {shown} if 0 to 255 is meant" if max(parts) <= 255 else ""
        yield "color-above-1", _place(scene, path, key), f"{path}: {key} has {max(parts):g}; write 0 to 1{meant}"


def _turns(scene: SceneSpec, path: str, value: Any, key: str) -> Iterator[Note]:
    parts = _numbers(value)
    if parts and any(map(_is_radians, parts)) and all(abs(part) <= 2 * math.pi + NEAR for part in parts):
        shown = ", ".join(f"{round(math.degrees(part)):g}" for part in parts)
        yield (
            "angle-in-radians",
            _place(scene, path, key),
            f"{path}: {key} is in degrees and looks like radians; write {shown}",
        )


def _is_radians(angle: float) -> bool:
    eighths = round(abs(angle) / (math.pi / 4))
    return eighths > 0 and abs(abs(angle) - eighths * math.pi / 4) < NEAR


def _orders(scene: SceneSpec, path: str, value: Any) -> Iterator[Note]:
    """Quaternions that as w, x, y, z turn by 180 degrees and as x, y, z, w by less."""
    parts = _numbers(value)
    if len(parts) == 4 and parts[0] == 0 and parts[3] > 0 and 0 in parts[1:3]:
        x, y, z, w = parts
        yield (
            "orient-order",
            _place(scene, path, "orient"),
            f"{path}: orient is w, x, y, z, so that this turns by 180 degrees; if x, y, z, w is meant, write "
            f"[{w:g}, {x:g}, {y:g}, {z:g}], if not, write it as rotate",
        )


def _numbers(value: Any) -> list[float]:
    """The finite numbers of a key's value; none if it holds anything else."""
    parts = value if isinstance(value, list | tuple) else [value]
    parts = [part for one in parts for part in (one if isinstance(one, list | tuple) else [one])]
    good = all(isinstance(part, int | float) and not isinstance(part, bool) and math.isfinite(part) for part in parts)
    return [float(part) for part in parts] if good else []


def _place(scene: SceneSpec, path: str, key: str) -> str:
    marks: Mapping[tuple[str, ...], Mark] = scene.prim_marks
    mark = marks.get((path, key)) or marks.get((path, "attributes")) or marks.get((path,))
    return str(mark or path)


def scaled_sensors(stage: Usd.Stage, spec: FileSpec, graphs: Sequence[Graph]) -> Iterator[Note]:
    """A warning for each sensor that nodes name below a non-uniform scale, which stretches where it stands."""
    for path in named_sensors(graphs):
        if lost := scaled_place(stage, path):
            mark = spec.scene.prim_marks.get((path, "translate")) or spec.scene.prim_marks.get((path,))
            yield "sensor-scaled", str(mark or path), f"{path}: {lost}"


def idle_actuators(stage: Usd.Stage, graphs: Sequence[Graph]) -> Iterator[Note]:
    """A warning if the stage has explicit actuators, and no graph a node that steps them."""
    from graph.sim.scene.stored_settings import ACTUATOR

    if any(node.type.short_name == "ArticulationActuators" for graph in graphs for node in graph.nodes.values()):
        return
    for prim in stage.Traverse():
        if prim.GetTypeName() == ACTUATOR:
            why = "no node ArticulationActuators steps the actuators, so their joints move by their drives; add one"
            yield "actuators-idle", str(prim.GetPath()), why
            return


def named_sensors(graphs: Sequence[Graph]) -> list[str]:
    """The prims that nodes render, in file order."""
    return list(
        dict.fromkeys(
            str(path)
            for graph in graphs
            for node in graph.nodes.values()
            for name in node.type.inputs_as("sensor")
            for path in node.get(name) or ()
        )
    )


def scaled_place(stage: Usd.Stage, path: str) -> str:
    """The effect of a non-uniform scale above a prim on its place, and the remedy; "" without such a scale."""
    from graph.sim.scene.prim_paths import prim_at
    from graph.sim.usd import EARLIEST, Gf, UsdGeom

    prim = prim_at(stage, path)
    if not prim or not UsdGeom.Xformable(prim):
        return ""
    poses = UsdGeom.XformCache(EARLIEST)
    above = poses.GetParentToWorldTransform(prim)
    lengths = [Gf.Vec3d(*above.GetRow3(row)).GetLength() for row in range(3)]
    if max(lengths) <= 1.01 * min(lengths):
        return ""
    parent = prim.GetParent()
    while parent and not _scales(parent):
        parent = parent.GetParent()
    place = ", ".join(f"{part:.3g}" for part in poses.GetLocalToWorldTransform(prim).ExtractTranslation())
    scale = ", ".join(f"{length:.3g}" for length in lengths)
    name = parent.GetPath() if parent else prim.GetParent().GetPath()
    return (
        f"it stands at ({place}) in the world, since the scale ({scale}) of {name} acts on its place too; "
        f"leave {name} without a scale and scale a shape below it"
    )


def _scales(prim: Any) -> bool:
    from graph.sim.usd import EARLIEST, Gf, UsdGeom

    if not UsdGeom.Xformable(prim):
        return False
    own = UsdGeom.Xformable(prim).GetLocalTransformation(EARLIEST)
    lengths = [Gf.Vec3d(*own.GetRow3(row)).GetLength() for row in range(3)]
    return bool(max(lengths) > 1.01 * min(lengths))
