"""The scans of a radar: one a frame, from rays to detections."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from threading import Lock
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.sharing import Shared
from graph.sim.geometry.surfaces import Mesh
from graph.sim.renderer.schedule import Tick
from graph.sim.transforms import apply, transformed
from sensors.frame import cartesian, spherical
from sensors.gmo import ElementFlags
from sensors.motion.velocities import twists_at
from sensors.output_frame import custom_frame
from sensors.raycast.rays import RayBundle, RayMemory, turn
from sensors.raycast.shared import cast_world, surface_materials
from sensors.raycast.standing import excluded
from sensors.raycast.windows import RayGrid
from sensors.raycast.world import CastWorld, once_a_world
from sensors.runtime import Measurement

from .antenna import Antenna
from .config import ScanConfig
from .cube import Cube, Grid, as_chirps_give, merged
from .detector import MOST_DETECTIONS, Detections, detections, limits
from .images import Twists
from .lit import Beam
from .noise import Noise
from .rays import Sampling, Tubes, fill, finer, windows
from .setting import Scenery, Setting
from .sight import Steps
from .tracing import Tracer

if TYPE_CHECKING:
    from graph.sim.state.prim_poses import PrimPoses

    from .runtime import RadarRuntime


KEPT_CUBES = 4
"""Cycles, by their unambiguous velocities, whose cubes are kept of each scan while nothing moves."""


class FanRays:
    """The rays of a scan in the sensor frame, for all radars of this process that have it.

    count: how many. tubes: theirs, and room after them for finer ones, which each frame fills while it holds the lock.
    steps: of the directions.
    """

    def __init__(self, scan: ScanConfig, sampling: Sampling, antenna: Antenna) -> None:
        across, up = scan.grid(sampling.rays)
        limit, (low, high), self.count = scan.azimuth_limit, scan.elevations, across * up
        self.tubes = Tubes.room(self.count + self.count // sampling.share)
        tubes = self.tubes.part(0, self.count)
        fill(tubes, (-limit, limit), scan.elevations, across, antenna, stride=sampling.stride)
        tubes.angle[:] = Grid.of(scan, 0).angles(tubes.azimuth, tubes.elevation)
        self.grid = RayGrid(tubes.directions.T)
        self.steps = Steps(across, up, -limit, 2 * limit / across, low, (high - low) / up)
        self.lock = Lock()


_shared: Shared[Hashable, FanRays] = Shared()


class _Fan:
    """The n rays of a scan, ready to cast.

    rays: theirs in the sensor frame. table: (n, 6) float32 and columns: (3, n), as those of a `RayBundle`, in the
    world's axes. cubes: what they brought back while nothing moved since the state `standing`.
    """

    def __init__(self, rays: FanRays) -> None:
        self.rays, self.grid, self.memory = rays, rays.grid, RayMemory()
        self.table, self.columns = np.zeros((rays.count, 6), np.float32), np.zeros((3, rays.count), np.float32)
        self.turned_by = b""
        self.standing: tuple[Any, ...] | None = None
        self.cubes: dict[Grid, Cube] = {}

    def turn(self, rotation: np.ndarray) -> None:
        """Points the rays as the sensor is turned."""
        key = rotation.tobytes()
        if key != self.turned_by:
            turn(self.rays.tubes.directions[:, : self.rays.count], rotation, self.columns, self.table)
            self.turned_by = key
            self.grid = self.grid.turned(rotation)
            self.memory.forget()


class Scans:
    """The scans of one radar as it is configured now: their rays, and what these brought back while nothing moved.

    sampling: how many rays; None for the knob's.
    """

    def __init__(self, radar: RadarRuntime, sampling: Sampling | None = None) -> None:
        self._path, self._exclude, self._bounces = radar.path, radar.exclude, radar.bounces
        self._sampling = sampling or Sampling(radar.scene.fidelity.radar_rays)
        self._config = config = radar.config
        self._custom = custom_frame(config.output_frame_of_reference, config.custom_frame_of_reference_trafo)
        self._fans: dict[int, _Fan] = {}

    def measure(self, radar: RadarRuntime, tick: Tick, frame: int) -> Measurement:
        """The detections of the scan whose turn it is in a frame of this number."""
        cycle, number = divmod(frame, len(self._config.scans))
        scan = self._config.scans[number]
        facts = {"sensorID": 0, "scanIdx": number, "cycleCnt": cycle, **limits(Grid.of(scan, cycle))}
        wanted = radar.channels()
        if not wanted:
            return Measurement({}, 0, facts=facts)
        pose = radar.pose(tick.poses)
        cube = self.cube(tick, pose, number, cycle)
        noise = Noise(tick.scene.seed, self._path, frame)
        found = detections(
            as_chirps_give(cube) if scan.waveform else cube,
            scan,
            self._antenna(scan),
            noise,
            four=self._config.cfar_mode == "4D",
            peaks=scan.waveform,
        )
        if len(found.rcs) == MOST_DETECTIONS:
            tick.scene.warn(
                "radar-frame-full",
                self._path,
                f"a frame holds the {MOST_DETECTIONS:,} strongest detections, the others are lost; raise cfarOffset, "
                "cfarMinVal or the first of rcsTuningCoefficients",
            )
        return Measurement(self._arrays(found, scan, wanted, pose), len(found.rcs), facts=facts)

    def cube(self, tick: Tick, pose: np.ndarray, number: int, cycle: int) -> Cube:
        """What a scan receives from a pose in one of its cycles, in cells, before it is detected."""
        scan = self._config.scans[number]
        grid = Grid.of(scan, cycle)
        setting, fan = self._setting(tick, pose, scan), self._fan(number)
        standing = self._standing(tick.scene.fabric, setting)
        if standing is None or standing != fan.standing or len(fan.cubes) >= KEPT_CUBES:
            fan.standing = standing
            fan.cubes.clear()
        if grid not in fan.cubes:
            with fan.rays.lock:
                fan.cubes[grid] = self._received(setting, scan, fan, grid)
        return fan.cubes[grid]

    def _received(self, setting: Setting, scan: ScanConfig, fan: _Fan, grid: Grid) -> Cube:
        rotation, origin = setting.pose[:3, :3], setting.pose[:3, 3]
        fan.turn(rotation)
        owner, small = self._close_looks(setting, scan, fan)
        bundle = RayBundle(
            *(origin, fan.table, None, self._exclude, setting.seen, fan.grid),
            columns=fan.columns,
            memory=fan.memory,
        )
        tracer = Tracer(setting, grid, fan.rays.steps if self._sampling.neighbours else None)

        def beams() -> Iterator[Beam]:  # a second thread works on one while the next is cast
            yield tracer.beam(0, bundle, skip=small)
            if owner is not None:
                first = len(fan.table)
                close = fan.rays.tubes.part(first, first + len(owner))
                close.angle[:] = grid.angles(close.azimuth, close.elevation)
                columns, table = np.empty((3, len(owner)), np.float32), np.empty((len(owner), 6), np.float32)
                turn(close.directions, rotation, columns, table)
                finer = RayBundle(origin, table, exclude=self._exclude, reach=setting.seen, columns=columns)
                yield tracer.beam(first, finer, skip=np.zeros_like(small), owner=owner)

        return merged(grid, tracer.parts(fan.rays.tubes, beams()))

    def _standing(self, fabric: PrimPoses, setting: Setting) -> tuple[Any, ...] | None:
        """What decides what comes back: equal where nothing moved; None where surfaces deform."""
        world = setting.world
        if world.soft:
            return None
        carrier = fabric.body_of(self._path)
        bodies = (*world.bodies, carrier) if carrier else world.bodies
        twists = np.array((setting.poses or fabric.capture()).velocities(bodies)) if bodies else np.zeros(0)
        return world, self._exclude, *(each.tobytes() for each in (setting.pose, setting.bodies, twists))

    def _antenna(self, scan: ScanConfig) -> Antenna:
        falls = self._config.antenna_gain_mode != "CONSTANT"
        return Antenna(scan.wavelength, scan.power_factor, falls, scan.pattern("tx"), scan.pattern("rx"))

    def _setting(self, tick: Tick, pose: np.ndarray, scan: ScanConfig) -> Setting:
        whole = cast_world(tick.scene)
        world = whole.facets
        bodies = world.body_poses(tick.poses)
        return Setting(
            world=world,
            scenery=_scenery(whole, scan.wavelength),
            bodies=np.zeros((0, 4, 4)) if bodies is None else bodies,
            twists=self._twists(tick, world, pose[:3, 3]),
            antenna=self._antenna(scan),
            reach=scan.max_range_m,
            bounces=self._bounces,
            pose=pose,
            poses=tick.poses,
            exclude=self._exclude,
        )

    def _twists(self, tick: Tick, world: CastWorld, place: np.ndarray) -> Twists:
        fabric = tick.scene.fabric
        carrier, state = fabric.body_of(self._path), tick.poses or fabric.capture()
        bodies = twists_at(fabric, (*world.bodies, *((carrier,) if carrier else ())), place, state).T.astype(np.float64)
        return Twists.of(bodies[: len(world.bodies)], bodies[-1] if carrier else None)

    def _fan(self, number: int) -> _Fan:
        if number not in self._fans:
            scan, sampling = self._config.scans[number], self._sampling
            key = scan, sampling, self._config.antenna_gain_mode
            self._fans[number] = _Fan(_shared.of(key, lambda: FanRays(scan, sampling, self._antenna(scan))))
        return self._fans[number]

    def _close_looks(self, setting: Setting, scan: ScanConfig, fan: _Fan) -> tuple[np.ndarray | None, np.ndarray]:
        """Finer rays for surfaces that few rays of the fan meet: the surface (n,) of each, or None; and which surfaces
        have them, (s + 1,) bool.
        """
        world = setting.world
        small = np.zeros(len(world.surfaces) + 1, bool)  # one more, for a miss
        boxes = _boxes(world, self._exclude)
        body, local = world.body_of[: len(boxes)], boxes
        if len(world.surfaces) == 0:
            return None, small
        bodies = setting.bodies
        moving = np.flatnonzero(body >= 0)
        if len(moving):
            local = boxes.copy()
            pose = bodies[body[moving]]
            local[moving] = np.einsum("sij,scj->sci", pose[:, :3, :3], boxes[moving]) + pose[:, None, :3, 3]
        corners = apply(setting.pose[:3, :3].T, local - setting.pose[:3, 3])
        found = windows(corners, scan.azimuth_limit, scan.elevations, fan.rays.steps.wide, setting.reach)
        owner = finer(found, fan.rays.tubes, len(fan.table), setting.antenna, self._sampling.share)
        if owner is not None:
            small[owner] = True
        return owner, small

    def _arrays(
        self, found: Detections, scan: ScanConfig, wanted: frozenset[str], pose: np.ndarray
    ) -> dict[str, np.ndarray]:
        """The requested channels, from a pose."""
        count = len(found.rcs)
        azimuth = np.rad2deg(found.azimuth).astype(np.float32)
        elevation = np.rad2deg(found.elevation).astype(np.float32)
        distance = found.range_m.astype(np.float32)
        arrays = {
            "azimuth": azimuth,
            "elevation": elevation,
            "distance": distance,
            "scalar": found.rcs.astype(np.float32),
            "timeOffsetNs": np.full(count, round(scan.time_offset_usec * 1000), np.int32),
            "flags": np.full(count, int(ElementFlags.VALID), np.uint8),
            "rv_ms": found.velocity.astype(np.float32),
            "bounces": found.bounces,
        }
        turned = pose if self._config.output_frame_of_reference == "WORLD" else self._custom
        if "xyz" in wanted or turned is not None:
            points = cartesian(azimuth, elevation, distance)
            if turned is not None:
                points = transformed(turned, points).astype(np.float32)
                arrays |= dict(zip(("azimuth", "elevation", "distance"), spherical(points), strict=True))
            arrays["xyz"] = points
        return {name: array for name, array in arrays.items() if name in wanted}


@once_a_world
def _scenery(world: CastWorld, wavelength: float) -> Scenery:
    return Scenery(world.facets, surface_materials(world), wavelength)


@once_a_world
def _boxes(world: CastWorld, exclude: frozenset[str]) -> np.ndarray:
    """Corners (s, 8, 3) [m] of the boxes around rigid meshes, in the frames of their bodies; NaN for all else."""
    found = np.full((len(world.surfaces), 8, 3), np.nan)
    for number, surface in enumerate(world.surfaces):
        if not isinstance(surface, Mesh) or not len(surface.vertices) or surface.source in world.soft:
            continue
        if not excluded(surface.path, exclude):
            ends = np.stack((surface.vertices.min(axis=0), surface.vertices.max(axis=0)))
            found[number] = [[ends[i, 0], ends[j, 1], ends[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    return found
