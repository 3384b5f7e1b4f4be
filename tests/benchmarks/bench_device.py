"""What the device costs beside its floors: raw Warp kernels over the same rays, and mujoco-warp's own steps.

Needs a CUDA device and the extra gpu; without them it has no rows. Times are medians by the device's events.
"""

from __future__ import annotations

import gc
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from measure import Row, ratio

from graph.base.errors import UserError
from graph.sim import App
from graph.sim.devices import warp
from graph.sim.geometry import tessellation
from graph.sim.geometry.closed_forms import closed_form
from graph.sim.geometry.surfaces import Mesh, Solid
from graph.sim.messages.bus import MemorySink
from sensors.lidar.config import EmitterState, LidarConfig
from sensors.lidar.pattern import firing_pattern
from sensors.surfaces.optics import optics_of
from wings.device import device_of

TITLE = "Device: 199,712 triangles of hills on a card; floors are raw Warp kernels and mujoco-warp's own steps"
BOXES = 20
GRAPHS = Path(__file__).parents[2] / "graphs"


def measure(quick: bool) -> Iterator[Row]:
    """The rows, on the first card."""
    try:
        device = device_of("cuda")
    except UserError:
        return
    rounds = 1 if quick else 30
    yield from one_world(device, rounds)
    yield from yard_memory(device, 256 if quick else 4096)
    yield from many_worlds(device, rounds, 256 if quick else 4096)
    yield from steps(device, rounds, 256 if quick else 4096)
    yield from whole_updates("cuda", rounds)


def whole_updates(device: str, rounds: int) -> Iterator[Row]:
    """How much faster whole updates of example files are with their rays on a device than on the processor."""
    for what, file, off, bound in (
        ("the yard without radar", "yard", {"radar_product.enabled": False}, 5.0),
        ("a camera's colours, depth and labels", "camera", {}, None),
        ("a radar", "radar", {}, None),
    ):
        apps = [App.from_file(GRAPHS / f"{file}.yaml", device=name, overrides=off) for name in ("cpu", device)]
        for app in apps:
            app.bus.subscribe(MemorySink())
            app.play()
        here, there = (partial(app.update, steps=6) for app in apps)
        yield Row(f"updates of {what}: processor / {device}", ratio(here, there, rounds), bound, best="most")
        for app in apps:
            app.close()


def lidar(emitters: int, columns: int) -> LidarConfig:
    """A rotary lidar of 10 Hz with so many emitters and columns."""
    state = EmitterState(np.zeros(emitters), np.linspace(-16, 15, emitters))
    rate = Fraction(10 * columns)
    return LidarConfig(pattern_firing_rate_hz=rate, far_range_m=200.0, near_range_m=0.3, emitter_states=(state,))


def hills(side: int = 317) -> Mesh:
    """200 m x 200 m of hills."""
    axis = np.linspace(-100, 100, side)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    corner = np.arange(side * side).reshape(side, side)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    height = 1.5 * np.sin(x / 4) * np.cos(y / 5) - 2.0
    return Mesh("/World/Hills", None, np.stack([x, y, height], -1).reshape(-1, 3), faces.astype(np.uint32))


def cube(number: int) -> Solid:
    """A box of 1 m on a body of its own."""
    form = closed_form("Cube", {"size": 1.0}, "Z")
    assert form is not None
    return Solid(f"/World/Box{number}", f"/World/Box{number}", form, lambda: tessellation.cube(1.0))


def scanner(device: Any, surfaces: list[Any], body_of: list[int], config: LidarConfig, worlds: int) -> tuple[Any, Any]:
    """A scan of some surfaces, and the pattern."""
    from wings.device.geometry import Geometry
    from wings.device.scan import DeviceScan

    pattern = firing_pattern(config)
    geometry = Geometry(device, surfaces, np.array(body_of), np.zeros(3), formulas=True, worlds=worlds)
    optics = optics_of(np.zeros(len(surfaces), np.int64))
    return DeviceScan(geometry, pattern, config, optics, np.array(body_of), -1), pattern


def one_world(device: Any, rounds: int) -> Iterator[Row]:
    """One lidar over the hills: left on the device, as arrays of NumPy, as a GenericModelOutput."""
    from sensors.channels import AuxLevel
    from sensors.frame import Frame, FramePose
    from sensors.gmo import channels_for, pack
    from wings.device.frames import DeviceFrames

    wp, config = warp(), lidar(32, 1800)
    scan, pattern = scanner(device, [hills()], [-1], config, 1)
    bodies = scan.geometry.place(None)
    still = wp.zeros((1, 0), dtype=wp.vec3d, device=device)
    scan.mount(bodies, np.eye(4))
    tables: dict[str, Callable[[], np.ndarray]] = {
        "matId": lambda: np.zeros(1, np.uint32),
        "objId": lambda: np.zeros((1, 16), np.uint8),
    }
    frames, channels = DeviceFrames(scan, pattern, tables), channels_for(AuxLevel.FULL, "SPHERICAL")

    def ours() -> None:
        scan.scan(bodies, still, still)

    def raw() -> None:
        floor.cast(len(pattern))

    floor = Floor(device, scan, 1)
    yield from pair("one world, 57,600 rays, all channels, left on the device", device, ours, raw, rounds, 0.40)

    def gmo() -> None:
        scan.scan(bodies, still, still)
        frames.find()
        arrays, count = frames.frame(channels)
        pose = FramePose(0, np.eye(4))
        pack(Frame(0, 0, pose, pose, count, arrays, config, aux_level=AuxLevel.FULL))

    def copied() -> None:
        floor.cast(len(pattern))
        floor.read()

    yield Row("the same as a GenericModelOutput, wall time", wall(gmo, rounds), 1.5, "ms")
    yield Row("the same, floor: the raw kernel and its arrays in NumPy", wall(copied, rounds), None, "ms")


def many_worlds(device: Any, rounds: int, worlds: int) -> Iterator[Row]:
    """A small lidar in each of many worlds with boxes of their own."""
    wp = warp()
    surfaces, owners = [hills(), *(cube(n) for n in range(BOXES))], [-1, *range(BOXES)]
    scan, pattern = scanner(device, surfaces, owners, lidar(16, 360), worlds)
    rng = np.random.default_rng(0)
    poses = np.tile(np.eye(4), (worlds, BOXES, 1, 1))
    poses[:, :, :2, 3] = rng.uniform(-30, 30, (worlds, BOXES, 2))
    bodies = scan.geometry.place(poses)
    speeds = wp.zeros((worlds, BOXES), dtype=wp.vec3d, device=device)
    places = np.tile(np.eye(4), (worlds, 1, 1))
    places[:, :2, 3] = rng.uniform(-20, 20, (worlds, 2))
    scan.rays.frames.assign(places)
    floor = Floor(device, scan, worlds, poses[:, :, :3, 3], places[:, :3, 3])

    def ours() -> None:
        scan.geometry.settle(bodies)
        scan.scan(bodies, speeds, speeds)

    what = f"{worlds:,} worlds x {len(pattern):,} rays, {BOXES} boxes, all channels"
    yield from pair(what, device, ours, lambda: floor.cast(len(pattern)), rounds, 58.0)


def yard_memory(device: Any, worlds: int) -> Iterator[Row]:
    """What worlds of the yard take: its robot's physics, and scans of 16 x 360 rays with all channels."""
    from sensors.raycast.shared import cast_world, surface_optics
    from wings.device.geometry import Geometry
    from wings.device.physics import DevicePhysics
    from wings.device.scan import DeviceScan

    wp = warp()
    with App.from_file(GRAPHS / "yard.yaml") as app:
        app.play()
        world, engine = cast_world(app.world), app.physics
        assert engine is not None
        gc.collect()
        wp.synchronize_device(device)
        before = device.free_memory
        physics = DevicePhysics(engine, worlds, device)
        number = {path: index for index, path in enumerate(engine.body_paths)}
        owners = np.array([number.get(str(one.body), -1) for one in world.surfaces])
        geometry = Geometry(device, world.surfaces, owners, np.zeros(3), formulas=True, worlds=worlds)
        config = lidar(16, 360)
        scan = DeviceScan(geometry, firing_pattern(config), config, surface_optics(cast_world(app.world)), owners, 0)
        bodies = geometry.place(np.tile(np.eye(4), (worlds, len(number), 1, 1)))
        speeds = [wp.zeros((worlds, len(number)), dtype=wp.vec3d, device=device) for _ in range(2)]
        for _ in range(3):
            physics.step()
            physics.carry(geometry.anchor, bodies, *speeds)
            geometry.settle(bodies)
            scan.mount(bodies, np.eye(4)[None])
            scan.scan(bodies, *speeds)
        wp.synchronize_device(device)
        used = (before - device.free_memory) / worlds / 2**20
    yield Row("memory of a world: the yard's robot, a lidar of 16 x 360 rays", used, 40e9 / 4096 / 2**20, "MiB")


def steps(device: Any, rounds: int, worlds: int) -> Iterator[Row]:
    """Physics: boxes in contact in many worlds."""
    from wings.device.physics import DevicePhysics

    wp = warp()
    boxes = "".join(
        f'<body pos="{n % 5} {n // 5} 0.2"><freejoint/><geom type="box" size="0.2 0.2 0.2"/></body>'
        for n in range(BOXES)
    )
    plane = '<geom type="plane" size="20 20 1"/>'
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "boxes.xml")
        file.write_text(f'<mujoco><option timestep="0.005"/><worldbody>{plane}{boxes}</worldbody></mujoco>')
        app = App(mjcf=file)
    with app:
        app.play()
        ours = DevicePhysics(app.physics, worlds, device, contacts=200, rows=800)
        raw = DevicePhysics(app.physics, worlds, device, contacts=200, rows=800)
        import mujoco_warp

        with wp.ScopedDevice(device):
            mujoco_warp.step(raw.model, raw.data)
            with wp.ScopedCapture(device=device) as capture:
                mujoco_warp.step(raw.model, raw.data)
        for _ in range(3):
            ours.step()
        what = f"a physics step of {worlds:,} worlds, {BOXES} boxes"
        yield from pair(what, device, ours.step, lambda: wp.capture_launch(capture.graph), rounds, 2.7)


def pair(
    what: str, device: Any, ours: Callable[[], None], raw: Callable[[], None], rounds: int, bound: float
) -> Iterator[Row]:
    """Our time [ms] and the floor's, one after the other in each round."""
    for call in (ours, raw):
        call()
    times = [(events(device, ours), events(device, raw)) for _ in range(rounds)]
    mine, floor = (statistics.median(each) for each in zip(*times, strict=True))
    yield Row(what, mine, bound, "ms")
    yield Row(f"{what}: floor", floor, None, "ms")


def events(device: Any, call: Callable[[], None]) -> float:
    """Time of a call on the device [ms]."""
    wp = warp()
    with wp.ScopedDevice(device):
        start, end = wp.Event(enable_timing=True), wp.Event(enable_timing=True)
        wp.record_event(start)
        call()
        wp.record_event(end)
        return float(wp.get_event_elapsed_time(start, end))


def wall(call: Callable[[], None], rounds: int) -> float:
    """Median time of a call [ms], until its results are on the host."""
    call()
    found = []
    for _ in range(rounds):
        start = time.perf_counter()
        call()
        found.append(1e3 * (time.perf_counter() - start))
    return statistics.median(found)


class Floor:
    """The same rays by a kernel without options: mesh and boxes in float32, all channels of a hit."""

    def __init__(self, device: Any, scan: Any, worlds: int, boxes: Any = None, places: Any = None) -> None:
        from floor_kernels import raw_scan

        wp = warp()
        self._kernel, self._device, self._worlds = raw_scan, device, worlds
        rays = scan.firings
        boxes = np.zeros((worlds, 0, 3)) if boxes is None else boxes
        places = np.zeros((worlds, 3)) if places is None else places
        self._inputs = [
            scan.geometry.ground.mesh,
            scan.rays.ways,
            wp.array(places.astype(np.float32), dtype=wp.vec3, device=device),
            wp.array(boxes.astype(np.float32), dtype=wp.vec3, device=device),
        ]
        kinds = wp.float32, wp.vec3, wp.vec3, wp.float32, wp.vec3, wp.int32
        self._outputs = [wp.zeros((worlds, rays), dtype=kind, device=device) for kind in kinds]

    def cast(self, rays: int) -> None:
        """One launch."""
        warp().launch(
            self._kernel, dim=(self._worlds, rays), inputs=self._inputs, outputs=self._outputs, device=self._device
        )

    def read(self) -> None:
        """Copies all to the host."""
        for array in self._outputs:
            array.numpy()
