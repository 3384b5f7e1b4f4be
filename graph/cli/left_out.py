"""What a run does without, and why: the parts that nothing in a file requires."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from graph.base.exact import shortest

if TYPE_CHECKING:
    from graph.session.open import Session
    from graph.sim.app import App

    from .explain_run import Observed

Part = tuple[str, str, Sequence[str], str]
"""Part of the run, where, the names of what is left out there (none: all of it), why."""


def left_out(
    session: Session, seen: Observed, sensors: Sequence[Mapping[str, Any]], topics: Sequence[Mapping[str, Any]]
) -> list[dict[str, Any]]:
    """Everything that is left out, as JSON data, of an App that plays its first updates."""
    app = session.app
    parts = [*_physics(app), *_casts(app, seen, sensors), *_channels(sensors), *_poses(app), *_messages(topics)]
    return [{"part": part, "where": where, "names": [*names], "why": why} for part, where, names, why in parts]


def _physics(app: App) -> Iterator[Part]:
    from graph.sim.geometry.collect import visible_prims

    if app.physics is None:
        yield "physics", "/", (), "nothing on the stage can move: no model, no steps"
        return
    colliders = {collider.path.partition("[")[0] for collider in app.physics.world.colliders}
    names = [path for _, path in visible_prims(app.stage) if path not in colliders]
    if names and app.mjcf is None:
        yield "physics", "/", names, "no colliders"


def _casts(app: App, seen: Observed, sensors: Sequence[Mapping[str, Any]]) -> Iterator[Part]:
    from graph.sim.renderer.wrapper import unwrapped
    from sensors.raycast.shared import cast_world

    if not seen.products and not app.rendering.polled:
        yield "casts", "/", (), "no sensor is rendered or polled: no structure for rays, no cast"
    for sensor in sensors:
        if sensor.get("product") is None or not sensor["channels"]:
            continue
        runtime: Any = unwrapped(seen.products[sensor["product"]].sensor)
        if math.isfinite(runtime.reach):
            world = cast_world(app.world)
            names = [
                world.surfaces[number].path for number in world.standing.beyond(runtime.pose()[:3, 3], runtime.reach)
            ]
            if names:
                yield "casts", sensor["path"], names, f"beyond its range of {shortest(runtime.reach)} m"


def _channels(sensors: Sequence[Mapping[str, Any]]) -> Iterator[Part]:
    from sensors.sensor_types import sensor_type

    for sensor in sensors:
        kind = sensor_type(sensor["type"])
        if kind is None or kind.read_by:
            continue
        if not sensor["product"]:
            yield "sensors", sensor["path"], (), "no render product: no cast, no frame"
        elif not sensor["channels"]:
            yield "channels", sensor["path"], (), "nothing reads it: its frames are empty"
        elif names := [one.name for one in kind.channels if one.name not in sensor["channels"]]:
            yield "channels", sensor["path"], names, "nothing reads them"


def _poses(app: App) -> Iterator[Part]:
    if app.physics is not None and not app.phases["physics_post_step"]:
        yield "poses", "/", (), "copied only for a sensor that is due: nothing reads them after every physics step"


def _messages(topics: Sequence[Mapping[str, Any]]) -> Iterator[Part]:
    names = [topic["topic"] for topic in topics if not topic["heard_in_file"]]
    if not topics:
        yield "messages", "/", (), "nothing publishes"
    elif names:
        yield "messages", "/", names, "made only for a recording or a live transport: nothing in the file subscribes"
