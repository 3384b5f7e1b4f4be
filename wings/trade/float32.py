"""Physics in float32 on a device against MuJoCo's own, over time: the same world with the same steps and controls."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from graph.base.errors import UserError
from graph.sim.transforms import quaternions

from .bodies import BodyPair
from .states import Floats, Trajectory

if TYPE_CHECKING:
    from graph.sim.app import App

LAST, FIRST = 2**60, -(2**60)
POINTS = 100
"""Times at which the growth of the difference is kept for files and diagrams."""

KINDS = {"position": "m", "orientation": "rad", "joint": "rad"}
"""What is compared, each with its unit; slides in m."""


@dataclass(slots=True)
class Float32:
    """The difference of one run: times (n,) [s], and the largest of all bodies or joints at each, (n,) by kind.

    ended: why it stops before the run does, or could not begin; without: what the device's physics leaves out.
    """

    times: Floats = field(default_factory=lambda: np.zeros(1))
    apart: dict[str, Floats] = field(default_factory=lambda: dict.fromkeys(KINDS, np.zeros(1)))
    ended: str = ""
    without: tuple[str, ...] = ()

    def errors(self, horizon: float) -> dict[str, float | None]:
        """The metrics up to a time [s]; none where nothing was compared."""
        count = int(np.searchsorted(self.times, horizon + 1e-9, side="right"))
        if not count:
            return {}
        found: dict[str, float | None] = {
            f"float32.{kind}_max": float(apart[:count].max()) for kind, apart in self.apart.items() if len(apart)
        }
        return found | {"float32.position_final": float(self.apart["position"][count - 1])}

    def growth(self, count: int) -> tuple[Floats, dict[str, Floats]]:
        """At most `count` times, evenly spread up to the last, and the largest difference until each."""
        last = max(len(self.times) - 1, 0)
        rows = np.unique(np.linspace(0, last, count + 1).round().astype(int))[1:]
        until = {kind: np.maximum.accumulate(apart)[rows] for kind, apart in self.apart.items() if len(apart)}
        return self.times[rows], until


class Float32Log:
    """Runs the world of an App that has begun to play on a device too; `take` notes its state."""

    def __init__(self, app: App, device: str) -> None:
        from graph.sim.devices import plugin_of

        self._app, self._engine = app, app.physics
        plugin = plugin_of(device)
        self._twin = plugin.DeviceTwin(app.physics, plugin.device_of(device))
        self._poses: list[Floats] = []
        self._joints: list[float] = []
        self._ends = [
            app.on("physics_pre_step", self._begin, LAST),
            app.on("physics_post_step", self._twin.step, FIRST),
        ]

    def _begin(self) -> None:
        if self._app.physics is not self._engine:
            for end in self._ends:
                end()
        else:
            self._twin.begin()

    def take(self) -> None:
        """Notes where the bodies are, unless the device's world has stopped following the other."""
        if not self._twin.stopped:
            self._poses.append(self._twin.bodies())
            there, here = self._twin.joints()
            self._joints += [float(np.abs(there - here).max())] if len(here) else []

    def compared(self, reference: Trajectory) -> Float32:
        """The difference from the recorded trajectory of the App."""
        count, twin = len(self._poses), self._twin
        poses = np.stack(self._poses)
        run = replace(
            reference,
            times=reference.times[:count],
            positions=poses[:, :, :3, 3],
            orientations=quaternions(poses[:, :, :3, :3]),
            velocities=reference.velocities[:count],
            depths=reference.depths[:count],
            touching=reference.touching[:count],
        )
        both = BodyPair(run, reference, np.inf)
        apart = {
            "position": both.distance.max(axis=1),
            "orientation": both.angle.max(axis=1),
            "joint": np.array(self._joints),
        }
        finite = {kind: np.nan_to_num(each, nan=np.inf) for kind, each in apart.items()}
        return Float32(both.times, finite, twin.stopped, twin.without)


def float32_log(app: App, device: str | None) -> Float32Log | Float32 | None:
    """The log of an App on a device; no difference on the processor; None without a device to compare, or bodies.

    Where the device cannot simulate this world, the difference is empty and says why.
    """
    if device is None or app.physics is None or not app.physics.body_paths:
        return None
    if device == "cpu":
        return Float32()
    try:
        return Float32Log(app, device)
    except UserError as error:
        return Float32(np.zeros(0), dict.fromkeys(KINDS, np.zeros(0)), error.problems[0].message)
