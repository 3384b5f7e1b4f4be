"""Many worlds of one file on one device: physics by mujoco-warp, lidars by one launch for all worlds that are due."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.base.exact import NANOSECONDS
from graph.sim.devices import HOST, warp
from graph.sim.renderer.schedule import TickSchedule

from .devices import device_of
from .geometry import Geometry
from .scan import WIDTHS, DeviceScan
from .start import Difference, Start, difference, start_of


class WorldsLidar:
    """A lidar in every world.

    `channels` holds arrays (worlds, firings) on the device, overwritten at each scan: distance [m], intensity 0 to 1,
    surface (-1, as distance 0: no return), and, (worlds, firings, 3) in the sensor's frame, point [m], normal and
    velocity [m/s]. `stamp_ns` and `frame_id`: (worlds,) int64 of each world's newest scan, -1 before the first.
    """

    def __init__(
        self, path: str, rate: Fraction, steps_per_second: Fraction, scan: DeviceScan, local: np.ndarray, bodies: Any
    ) -> None:
        self.path, self.rate, self.channels = path, rate, scan.channels
        self.scanner, self.local, self.bodies = scan, local, bodies
        schedule = TickSchedule(rate, accumulates=True)
        schedule.bind(steps_per_second)
        self._first, self._newest, self._state = schedule.first_index, schedule.newest, schedule.state_step
        worlds = scan.geometry.worlds
        self.index = np.full(worlds, self._first - 1, np.int64)
        self.stamp_ns, self.frame_id = np.full(worlds, -1, np.int64), np.full(worlds, -1, np.int64)

    def reset(self, mask: np.ndarray) -> None:
        """Forgets the scans of some worlds (w,) bool; their arrays keep their numbers until the next one."""
        self.index[mask] = self._first - 1
        self.stamp_ns[mask] = self.frame_id[mask] = -1

    def planned(self, steps: np.ndarray) -> dict[int, np.ndarray]:
        """Which worlds scan at which of their step counts in an update that ends at `steps` (w,); exact integers."""
        found: dict[int, list[np.ndarray]] = {}
        for end in np.unique(steps):
            worlds = np.flatnonzero((steps == end) & (self.index < self._newest(int(end))))
            if len(worlds):
                newest = self._newest(int(end))
                self.index[worlds] = newest
                self.frame_id[worlds] += 1
                self.stamp_ns[worlds] = round((newest - 1) / self.rate * NANOSECONDS)
                found.setdefault(int(end) - self._state(newest), []).append(worlds)
        return {before: np.concatenate(each) for before, each in found.items()}


class Worlds:
    """`count` worlds of a graph file, each with its own state: `step()`, then read `lidars[path].channels`.

    World i has what `randomize:` draws with `seed` + i. device: "cuda", "cuda:N" or "warp-cpu". channels: those of
    lidars, see `WorldsLidar`. contacts, rows: room for contacts and constraint rows in a world. options: as for
    `App.from_file`. Graphs, other sensors than lidars, time samples of transforms, and what `graph.sim.physics` adds to
    MuJoCo's steps do not work in worlds: the warnings `graphs-not-in-worlds`, `sensors-not-in-worlds`,
    `animations-not-in-worlds` and `physics-not-in-worlds` name them.
    Raises UserError for what cannot run so: lidars whose turns differ, with noise or sub-rays, drawn values that cannot
    differ between worlds, or a physics rate that is not a multiple of the loop's.
    """

    def __init__(
        self,
        file: str | Path,
        *,
        count: int,
        seed: int = 0,
        device: str = "cuda",
        channels: Iterable[str] = tuple(WIDTHS),
        contacts: int | None = None,
        rows: int | None = None,
        **options: Any,
    ) -> None:
        from graph.isaac.managers.app import App
        from graph.session.by_world import WorldDraws
        from sensors.raycast.shared import cast_world

        if count < 1:
            raise UserError(f"worlds: count {count} is not above 0")
        if device == HOST:
            raise UserError('worlds run on "cuda", "cuda:N" or "warp-cpu"; for one world on the processor use App')
        self.device, self.count = device_of(device), count
        draws = WorldDraws(file, count, seed, options)
        self.drawn: tuple[Mapping[str, Any], ...] = draws.values
        """What `randomize:` of the file drew for each world, by its targets; world i has the seed `seed` + i."""
        self.app = app = App.from_file(file, seed=seed, **options)
        """The App of world 0, whose plan, shapes and lidars all worlds have."""
        app.play()
        ratio = app.simulation.steps_per_second / app.loop_rate
        if ratio.denominator != 1:
            raise UserError(f"worlds: the physics rate must be a multiple of the loop's, not {float(ratio):g} times it")
        self.substeps = int(ratio)
        self.steps = np.zeros(count, np.int64)
        """(w,) physics steps of each world since its start or reset."""
        sensors = _lidars(app)
        for sensor in sensors:
            self._check(sensor)
        start = start_of(app, sensors)
        differences = self._differences(draws, start)
        engine: Any = app.physics
        self.physics: Any = None
        """mujoco-warp's `model` and `data`, see `physics.DevicePhysics`; None where nothing moves."""
        if engine is not None:
            from .physics import DevicePhysics

            differing = {world: each.physics for world, each in differences.items()}
            self.physics = DevicePhysics(engine, count, self.device, contacts, rows, differing)
        paths = () if engine is None else engine.body_paths
        number = {path: index for index, path in enumerate(paths)}
        body_of = np.array([number.get(str(one.body), -1) if one.body else -1 for one in start.surfaces], np.int32)
        moved = sorted({surface for each in differences.values() for surface in each.surfaces} | start.held.keys())
        body_of[moved] = np.arange(len(moved)) + len(paths)  # as if each stood on a body of its own
        places = np.tile(np.eye(4), (count, len(paths) + len(moved), 1, 1))
        for surface, pose in start.held.items():
            places[:, body_of[surface]] = pose
        for index, each in differences.items():
            for surface, pose in each.surfaces.items():
                places[index, body_of[surface]] = pose
        wp = warp()
        self._linear = wp.zeros(places.shape[:2], dtype=wp.vec3d, device=self.device)
        self._angular = wp.zeros(places.shape[:2], dtype=wp.vec3d, device=self.device)
        self.lidars: dict[str, WorldsLidar] = {}
        """The lidars by the paths of their prims."""
        for sensor in sensors:
            geometry = self._geometry(cast_world(app.world), body_of if len(body_of) else np.array([-1]), sensor)
            mount = start.lidars[sensor.path]
            local = np.array([mount.pose])
            if any(sensor.path in each.lidars for each in differences.values()):
                local = np.repeat(local, count, axis=0)
                for index, each in differences.items():
                    local[index] = each.lidars.get(sensor.path, mount.pose)
            carrier = number.get(mount.carrier, -1) if mount.carrier else -1
            scan = DeviceScan(
                geometry, sensor.turns.pattern(0), sensor.config, start.optics, body_of, carrier, channels
            )
            self.lidars[sensor.path] = WorldsLidar(
                sensor.path, sensor.rate, app.simulation.steps_per_second, scan, local, geometry.place(places)
            )
        self._tell_left_out()

    # -- the loop ----------------------------------------------------------------------------------------------------

    def step(self) -> Mapping[str, WorldsLidar]:
        """One update of every world: its physics steps, and the scans that are due; returns `lidars`."""
        self.steps += self.substeps
        plans = [(lidar, lidar.planned(self.steps)) for lidar in self.lidars.values()]
        for left in range(self.substeps - 1, -1, -1):
            if self.physics is not None:
                self.physics.step()
            due = [(lidar, plan[left]) for lidar, plan in plans if left in plan]
            if due:
                self._scan(due)
        return self.lidars

    def reset(self, mask: Any = None) -> None:
        """Puts worlds back to the start: `mask` (w,) bool, NumPy or on the device; None: all."""
        wp = warp()
        host = np.ones(self.count, bool) if mask is None else on_host(mask).astype(bool)
        if host.shape != (self.count,):
            raise UserError(
                f"reset: the mask has the shape {host.shape}; give one value for each of {self.count} worlds"
            )
        if self.physics is not None:
            self.physics.reset(wp.array(host, dtype=wp.bool, device=self.device))
        self.steps[host] = 0
        for lidar in self.lidars.values():
            lidar.reset(host)

    # -- joints ------------------------------------------------------------------------------------------------------

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints with drives, in the order of `drive`'s columns."""
        return () if self.physics is None else self.physics.joints

    @property
    def coordinates(self) -> Any:
        """MuJoCo's generalised coordinates, (worlds, nq) float32 on the device: write to them to place bodies."""
        return self.physics.coordinates

    @property
    def speeds(self) -> Any:
        """MuJoCo's generalised velocities, (worlds, nv) float32 on the device."""
        return self.physics.speeds

    def overflow(self) -> str:
        """What there was no room for in the last step, such as "contacts (64 a world)"; "" if all had room."""
        return "" if self.physics is None else str(self.physics.overflow())

    def drive(self, velocities: Any = None, positions: Any = None) -> None:
        """Targets of the driven joints, (worlds, joints) [rad/s or m/s, rad or m]; None keeps those of before.

        Takes NumPy arrays, and arrays on the device without a copy to the host (Warp, or by DLPack: torch, CuPy, JAX).
        """
        if not self.joints:
            raise UserError("drive: this file has no joints with drives")
        self.physics.drive(*(None if one is None else self._given(one) for one in (positions, velocities)))

    def _given(self, values: Any) -> Any:
        wp, shape = warp(), (self.count, len(self.joints))
        if not hasattr(values, "shape"):
            values = np.asarray(values)
        if tuple(values.shape) != shape:
            raise UserError(f"drive: targets of the shape {tuple(values.shape)}; give {shape}, a row for each world")
        if isinstance(values, np.ndarray):
            return wp.array(np.ascontiguousarray(values, np.float32), device=self.device)
        if not isinstance(values, wp.array):
            values = wp.from_dlpack(getattr(values, "detach", lambda: values)())  # torch: without its gradient
        if values.dtype is not wp.float32:
            raise UserError("drive: targets on a device are float32 arrays; convert them")
        return values if values.device == self.device else values.to(self.device)

    # -- inside ------------------------------------------------------------------------------------------------------

    def _scan(self, due: list[tuple[WorldsLidar, np.ndarray]]) -> None:
        for lidar, worlds in due:
            scan, bodies = lidar.scanner, lidar.bodies
            if self.physics is not None:
                self.physics.carry(scan.geometry.anchor, bodies, self._linear, self._angular)
            scan.geometry.settle(bodies)
            scan.mount(bodies, lidar.local)
            scan.scan(bodies, self._linear, self._angular, None if len(worlds) == self.count else worlds)

    def _differences(self, draws: Any, start: Start) -> dict[int, Difference]:
        """How worlds begin otherwise than world 0. Raises UserError for what is drawn and cannot differ."""
        found: dict[int, Difference] = {}
        without = []
        for name, world in draws.targets.items():
            with draws.playing(world, only=name) as app:
                try:
                    differs = difference(start, start_of(app, _lidars(app)))
                except UserError as error:
                    draws.refuse(name, error.problems[0].message)
            if not differs:
                without.append(name)
        if len(without) < len(draws.targets):
            for world in range(1, self.count):
                with draws.playing(world) as app:
                    found[world] = difference(start, start_of(app, _lidars(app)))
        if without:
            what = "lidars and physics of worlds do not depend on it; its value is that of each world's seed in drawn"
            self.app.warn("randomize-not-in-worlds", ", ".join(without), what)
        return found

    def _geometry(self, world: Any, body_of: np.ndarray, sensor: Any) -> Geometry:
        from sensors.raycast.standing import excluded
        from sensors.raycast.world import anchor_of

        if world.soft:
            raise UserError("worlds: deforming bodies are simulated in single Apps only")
        skip = frozenset(n for n, one in enumerate(world.surfaces) if excluded(str(one.path), sensor.exclude))
        anchor = anchor_of(sensor.pose()[:3, 3])
        return Geometry(self.device, world.surfaces, body_of, anchor, formulas=True, skip=skip, worlds=self.count)

    def _check(self, sensor: Any) -> None:
        from sensors.raycast.shared import cast_world, surface_optics

        fidelity = self.app.fidelity
        reason = ""
        if not sensor.whole:
            reason = "its tick rate is not its scan rate"
        elif sensor.turns.kept != 1:
            reason = "the patterns of its turns differ"
        elif fidelity.lidar_noise or fidelity.lidar_subrays > 1 or fidelity.lidar_motion != "frozen":
            reason = "lidar.noise, lidar.subrays and lidar.motion keep their defaults there"
        elif sensor.config.output_frame_of_reference != "SENSOR":
            reason = f"its frame of reference is {sensor.config.output_frame_of_reference}; set SENSOR"
        elif surface_optics(cast_world(self.app.world)).has_glass:
            reason = "rays pass through glass in single Apps only"
        if reason:
            raise UserError(f"worlds: {sensor.path} cannot be scanned in many worlds: {reason}")

    def _tell_left_out(self) -> None:
        """Names once what the file has and worlds do not do."""
        from sensors.lidar.names import PRIM_TYPE
        from sensors.sensor_types import sensor_types

        from .physics_start import left_out

        app, known = self.app, sensor_types()
        prims = (prim for prim in app.stage.Traverse() if prim.GetTypeName() in known)
        others = [str(prim.GetPath()) for prim in prims if prim.GetTypeName() != PRIM_TYPE]
        physics = [] if app.physics is None else left_out(app.physics)
        for what, names, why in (
            ("graphs", [*app.graphs], "graphs are not evaluated in worlds; set targets with drive()"),
            ("sensors", others, "only lidars measure in worlds; open the file as an App for these"),
            (
                "animations",
                [*app.simulation.animated],
                "time samples do not move prims in worlds: they stand as at the start",
            ),
            ("physics", physics, "worlds do without it: physics there is MuJoCo's own step"),
        ):
            if names:
                app.warn(f"{what}-not-in-worlds", ", ".join(names), why)

    def close(self) -> None:
        """Frees the template App."""
        self.app.close()

    def __enter__(self) -> Worlds:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def on_host(values: Any) -> np.ndarray:
    """Numbers of NumPy, Warp, torch, CuPy or JAX, or a list, as an array of NumPy."""
    for copy in ("cpu", "get", "numpy"):  # of torch; of CuPy; of Warp, and of torch on the host
        if not isinstance(values, np.ndarray) and hasattr(values, copy):
            values = getattr(values, copy)()
    return np.asarray(values)


def _lidars(app: Any) -> list[Any]:
    """The runtimes of all lidars of a stage, by path."""
    from sensors.lidar.names import PRIM_TYPE
    from sensors.lidar.runtime import LidarRuntime

    return [
        LidarRuntime(app.world, str(prim.GetPath())) for prim in app.stage.Traverse() if prim.GetTypeName() == PRIM_TYPE
    ]
