"""The proximity sensor of PhysX: what is in the box of a prim, how long, and how far its origin is."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from graph.base.paths import at_or_below
from graph.base.suggesting import Suggesting
from graph.sim import entered
from graph.sim.transforms import Floats, rigid_part
from sensors.errors import SensorValueError

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.app import App
    from graph.sim.renderer.view import WorldView

Told = Callable[["ProximitySensor"], object]
"""A user's callback; it gets the sensor."""

REGISTERED = "proximity sensors"
"""The key in `WorldView.shared` of those that are updated, each with the functions that end it."""

_NOBODY: tuple[Told | None, ...] = (None, None, None)


class ProximitySensor(Suggesting):
    """Watches the box of a prim: its bounds along its own axes, with all that is below it.

    A rigid body with a collider in the box is reported by the body's path, a static collider by its own; the prim's own
    body is not, nor what only touches the box, triggers, deformables, and anything while the App has no physics.

    parent: the prim, or its path. callback_fns: called with the sensor in each update with something inside, in which
    something enters, and in which something leaves; None for none. exclusions: paths of prims that are not reported,
    nor what is below them. app: None is the App entered last. Raises SensorValueError for a prim without bounds.
    """

    def __init__(
        self,
        parent: Usd.Prim | str,
        callback_fns: Sequence[Told | None] = _NOBODY,
        exclusions: Iterable[str] = (),
        *,
        app: App | None = None,
    ) -> None:
        self.scene: WorldView = (entered.current() if app is None else app).world
        self.path = parent if isinstance(parent, str) else str(parent.GetPath())
        if len(callback_fns) != len(_NOBODY):
            raise SensorValueError(
                f"{self.path}: callback_fns has {len(callback_fns)} items; give 3: inside, enter, exit"
            )
        self.exclusions = tuple(exclusions)
        self._on_inside, self._on_enter, self._on_exit = callback_fns
        self.reset()

    def reset(self) -> None:
        """Forgets what is inside, as a stop does, and takes the present size of the prim."""
        self._middle, self._half = bounds_of(self.scene, self.path)
        self._since: dict[str, Fraction] = {}
        self._distances: dict[str, float] = {}
        self.entered: tuple[str, ...] = ()
        """What entered in the last update."""
        self.exited: tuple[str, ...] = ()
        """What left in the last update."""

    def update(self) -> None:
        """Looks into the box now, and calls the callbacks. A registered sensor does so after each physics step."""
        inside = self._inside()
        self.entered = tuple(path for path in inside if path not in self._since)
        self.exited = tuple(path for path in self._since if path not in inside)
        now = self.scene.times.time
        self._since = {path: self._since.get(path, now) for path in inside}
        origins = self.scene.fabric.rigid_matrices((self.path, *inside))[:, :3, 3]
        self._distances = dict(zip(inside, np.linalg.norm(origins[1:] - origins[0], axis=1).tolist(), strict=True))
        for happened, callback in (
            (self.entered, self._on_enter),
            (inside, self._on_inside),
            (self.exited, self._on_exit),
        ):
            if happened and callback is not None:
                callback(self)

    @property
    def is_overlapping(self) -> bool:
        """Whether anything was inside at the last update."""
        return bool(self._since)

    def get_active_zones(self) -> list[str]:
        """The paths of what was inside at the last update."""
        return list(self._since)

    def get_data(self) -> dict[str, dict[str, float]]:
        """By the path of what is inside, `duration` and `distance`.

        duration: simulation time since the update in which it entered [s]; distance: from the origin of the sensor's
        prim to that of the other one [m], at the last update.
        """
        now = self.scene.times.time
        return {
            path: {"duration": float(now - since), "distance": self._distances[path]}
            for path, since in self._since.items()
        }

    def status(self) -> tuple[bool, dict[str, dict[str, float]]]:
        """`is_overlapping` and `get_data()`."""
        return self.is_overlapping, self.get_data()

    def to_string(self) -> str:
        """A line for each prim that is inside."""
        return "\n".join(
            f"{path}: {one['distance']:.6g} m, for {one['duration']:.6g} s" for path, one in self.get_data().items()
        )

    def _inside(self) -> list[str]:
        scene, physics = self.scene, self.scene.physics
        if physics is None:
            return []
        matrix = scene.fabric.world_matrix(self.path).copy()
        matrix[:3] *= scene.meters_per_unit
        pose, half = rigid_part(matrix), self._half * np.linalg.norm(matrix[:3, :3], axis=0)
        pose[:3, 3] += matrix[:3, :3] @ self._middle
        own = scene.fabric.body_of(self.path)
        found: dict[str, None] = {}
        for collider, body in physics.overlapping(pose, half):
            mine = body == own if body else own is None and at_or_below(collider, self.path)
            out = any(at_or_below(path, one) for path in (collider, body) for one in self.exclusions)
            if not mine and not out:
                found[body or collider] = None
        return list(found)


def register_sensor(sensor: ProximitySensor) -> None:
    """Updates a sensor after each physics step, until `clear_sensors`; a stop resets it. Twice is as once."""
    scene = sensor.scene
    sensors = scene.shared.setdefault(REGISTERED, {})
    if sensor not in sensors:
        sensors[sensor] = scene.on("physics_post_step", sensor.update), scene.on("stop", sensor.reset)


def clear_sensors(app: App | None = None) -> None:
    """Ends the updates of all registered sensors of an App; None is the App entered last."""
    scene: WorldView = (entered.current() if app is None else app).world
    for ends in scene.shared.pop(REGISTERED, {}).values():
        for end in ends:
            end()


def bounds_of(scene: WorldView, path: str) -> tuple[Floats, Floats]:
    """(3,) middle and (3,) half lengths of a prim's bounds along its axes, before its transform [stage units].

    Raises SensorValueError for a prim that is missing or has no size.
    """
    from graph.sim.usd import Usd, UsdGeom

    prim = scene.stage.GetPrimAtPath(path)
    if not prim:
        raise SensorValueError(f"{path}: no such prim on the stage; a proximity sensor watches the box of a prim")
    purposes = [UsdGeom.Tokens.default_, UsdGeom.Tokens.render, UsdGeom.Tokens.proxy, UsdGeom.Tokens.guide]
    cache = UsdGeom.BBoxCache(Usd.TimeCode.EarliestTime(), purposes)
    bounds = cache.ComputeUntransformedBound(prim).ComputeAlignedRange()
    if bounds.IsEmpty():
        raise SensorValueError(f"{path}: it has no size; give the prim of a shape, such as a Cube")
    return np.array(bounds.GetMidpoint()), np.array(bounds.GetSize()) / 2
