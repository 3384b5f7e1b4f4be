"""Transforms with time samples: while playing, their prims follow the timeline's time code.

A prim with an animated transform is a kinematic body of the scan (see `scan`). In a world with physics it is a
kinematic body too, placed after every step; in a world without, it is a frame of Fabric. Below a body that forces move,
it is a frame that moves with that body.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from graph.sim import transforms
from graph.sim.scene.scan import Scan, scan_stage
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats
from graph.sim.usd import Usd, UsdGeom

if TYPE_CHECKING:
    from graph.sim.phases import Phases
    from graph.sim.state.playing_world import PlayingWorld
    from graph.sim.timing.clocks import PhysicsClock
    from graph.sim.timing.timeline import Timeline

BEFORE_OTHERS = -100
"""Order among the subscribers of a physics step: early, because the others read the prims' new poses."""

SPAN = 1e-3
"""Time [s] over which velocities are computed: USD interpolates linearly between samples, which are often float32."""


class Stepping(Protocol):
    """The interface that steps physics."""

    clock: PhysicsClock

    @property
    def carry(self) -> Fraction:
        """Time that waits for its physics step [s]."""

    @property
    def enabled(self) -> bool:
        """Whether updates step physics."""


def animate(world: PlayingWorld, timeline: Timeline, stepping: Stepping, phases: Phases) -> Animation | None:
    """The animation of a world that starts to play; None if nothing in it is animated."""
    scan = scan_stage(world.stage, world.fabric.promoted)
    paths = [path for path in (*scan.driven, *scan.riders) if path in scan.moving or path in scan.riders]
    _warn_of_idle_samples(world.warn, scan)
    return Animation(world, timeline, stepping, phases, scan, paths) if paths else None


class Animation:
    """Places animated prims by their time samples.

    After a physics step at simulation time s they are placed for the timeline time at that moment, so steps within an
    update see them move. Without physics steps they follow the timeline itself.
    """

    def __init__(
        self,
        world: PlayingWorld,
        timeline: Timeline,
        stepping: Stepping,
        phases: Phases,
        scan: Scan,
        paths: list[str],
    ) -> None:
        self._world, self._timeline, self._stepping, self._phases = world, timeline, stepping, phases
        self._stage = scan.stage
        self._unit = scan.meters_per_unit
        self._prims = {path: scan.stage.GetPrimAtPath(path) for path in paths}
        self._bases: dict[str, tuple[str, Any]] = {}
        for path in scan.riders:
            above = scan.body_of(path)
            if above is not None and above in scan.moving:
                self._bases[path] = above, scan.stage.GetPrimAtPath(above)
        self._last: dict[str, Floats] = {}
        self._ahead = 0.0
        self._steps = 0
        self._time: float | None = None
        self._ends: list[Callable[[], None]] = [
            phases.on("physics", self._before_physics, -1),
            phases.on("physics_post_step", self._after_step, BEFORE_OTHERS),
            phases.on("physics", self._after_physics, 0),
        ]
        self.set_time(float(timeline.current_time))

    @property
    def paths(self) -> tuple[str, ...]:
        """The prims that it places."""
        return tuple(self._prims)

    def close(self) -> None:
        """Stops following the timeline."""
        while self._ends:
            self._ends.pop()()

    def set_time(self, time: float, moving: bool = True) -> None:
        """Places everything for a time of the timeline [s]; moving: whether that time advances."""
        rate = self._stage.GetTimeCodesPerSecond()
        prims = {path: prim for path, prim in self._prims.items() if prim}
        if not prims:
            return
        now, before = self._poses(prims, time * rate), self._poses(prims, (time - SPAN) * rate)
        self._hold_broken(list(prims), now, before)
        speeds = np.zeros((len(now), 6))
        speeds[:, :3] = (now[:, :3, 3] - before[:, :3, 3]) / SPAN
        turn = now[:, :3, :3] @ np.swapaxes(before[:, :3, :3], 1, 2)
        speeds[:, 3:] = transforms.rotation_vectors(turn) / SPAN
        self._carry(list(prims), now, speeds)
        self._give(list(prims), now, speeds, moving)
        self._time = time

    def _poses(self, prims: dict[str, Any], code: float) -> Floats:
        """(n, 4, 4) rigid poses [m] at a time code: in the world, or relative to the body that a prim rides on."""
        cache = UsdGeom.XformCache(Usd.TimeCode(code))
        world = np.array([np.array(cache.GetLocalToWorldTransform(prim)).T for prim in prims.values()])
        out = np.full_like(world, np.nan)
        good = transforms.all_usable(world)
        out[good] = transforms.rigid_parts(world[good])
        out[:, :3, 3] *= self._unit
        for number, path in enumerate(prims):
            if path in self._bases:
                base = transforms.rigid_part(transforms.from_usd(cache.GetLocalToWorldTransform(self._bases[path][1])))
                base[:3, 3] *= self._unit
                out[number] = transforms.inverse_rigid(base) @ out[number]
        return out

    def _hold_broken(self, paths: list[str], now: Floats, before: Floats) -> None:
        """A prim without a valid pose at this time keeps its last one, or the first authored one."""
        broken = np.flatnonzero(~np.isfinite(now).all(axis=(1, 2)))
        for number in broken.tolist():
            path = paths[number]
            text = "its time samples make its transform flat or not finite; it stays where it was"
            self._world.warn("bad-transform", path, text)
            now[number] = self._last.get(path, np.eye(4))
        lost = np.asarray(~np.isfinite(before).all(axis=(1, 2)))
        lost[broken] = True
        before[lost] = now[lost]
        self._last = dict(zip(paths, now.copy(), strict=True))

    def _carry(self, paths: list[str], poses: Floats, speeds: Floats) -> None:
        """Moves prims that ride on bodies to the bodies' present poses."""
        riding = [number for number, path in enumerate(paths) if path in self._bases]
        if not riding:
            return
        bodies = [self._bases[paths[number]][0] for number in riding]
        fabric = self._world.fabric
        base, motion = fabric.rigid_matrices(bodies), fabric.velocities(bodies)
        for number, frame, twist in zip(riding, base, motion, strict=True):
            arm = frame[:3, :3] @ poses[number, :3, 3]
            speeds[number, :3] = frame[:3, :3] @ speeds[number, :3] + twist[:3] + np.cross(twist[3:], arm)
            speeds[number, 3:] = frame[:3, :3] @ speeds[number, 3:] + twist[3:]
            poses[number] = frame @ poses[number]

    def _give(self, paths: list[str], poses: Floats, speeds: Floats, moving: bool) -> None:
        physics, fabric = self._world.physics, self._world.fabric
        known = frozenset(physics.body_paths) if physics is not None else frozenset[str]()
        if physics is not None:
            inside = [number for number, path in enumerate(paths) if path in known]
            motion = speeds[inside] if moving else None
            physics.set_poses([paths[number] for number in inside], poses[inside], motion)
        frames = {path: pose for path, pose in zip(paths, poses, strict=True) if path not in known}
        fabric.set_frames(frames, dict(zip(paths, speeds, strict=True)))

    def _before_physics(self) -> None:
        stepping, timeline = self._stepping, self._timeline
        due = stepping.clock.time + stepping.carry + timeline.delta
        self._ahead = float(timeline.current_time - due)
        self._steps = stepping.clock.count

    def _after_step(self) -> None:
        timeline = self._timeline
        if not self._phases.running:  # an extra step moves physics, not the timeline
            self.set_time(float(timeline.current_time), moving=False)
            return
        clock = self._stepping.clock
        time, start = float(clock.time + 1 / clock.rate) + self._ahead, timeline.get_start_time()
        if time < start and timeline.is_looping():
            time += timeline.get_end_time() - start
        self.set_time(time)

    def _after_physics(self) -> None:
        """Handles updates without a due physics step in which the timeline moved."""
        if self._stepping.clock.count != self._steps:
            return
        timeline = self._timeline
        time = float(timeline.current_time)
        if time != self._time and not (timeline.is_playing() and self._stepping.enabled):
            self.set_time(time)


def _warn_of_idle_samples(warn: Warn, scan: Scan) -> None:
    """Warns of time samples that are not played."""
    for path in sorted(scan.animated):
        body = scan.bodies.get(path)
        if body is not None and not body.kinematic:
            warn(
                "animated-body",
                path,
                "its transform has time samples, but forces move it; it starts at the first. Make it kinematic "
                "(physics:kinematicEnabled) to have it follow them",
            )
        elif body is not None or path in scan.riders:
            _warn_of_scale(warn, path, (body or scan.riders[path]).prim)


def _warn_of_scale(warn: Warn, path: str, prim: Any) -> None:
    for op in UsdGeom.Xformable(prim).GetOrderedXformOps():
        if op.GetOpType() not in (UsdGeom.XformOp.TypeScale, UsdGeom.XformOp.TypeTransform):
            continue
        codes = op.GetTimeSamples()
        if len(codes) < 2:
            continue
        linear = np.array([np.array(op.GetOpTransform(code))[:3, :3] for code in codes])
        # A rotation does not change the lengths of the rows and the angles between them.
        grams = linear @ np.swapaxes(linear, 1, 2)
        if np.abs(grams - grams[0]).max() > 1e-5 * np.abs(grams[0]).max():
            warn("animated-scale", path, "its scale has time samples; rays see it in the size of the first")
            return
