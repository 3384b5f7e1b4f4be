"""The cases at the extremes that need no tests: what is measured, the bound that it must meet, and why that bound.

A checkout has more of them in `tests/stability`.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from graph.base.errors import RunError, UserError
from graph.isaac.managers.app import App
from graph.sim.renderer.products import RenderProduct
from graph.sim.scene.stage import open_stage
from sensors.frame import Frame
from sensors.lidar.config import EmitterState, LidarConfig
from sensors.lidar.prim import write_config
from sensors.prim import write_aux_level
from sensors.products import render_product

Prims = Mapping[str, Mapping[str, Any]]

GRAVITY = 9.81
WEIGHTLESS: Prims = {"/Scene": {"type": "PhysicsScene", "attributes": {"physics:gravityMagnitude": 0.0}}}
GROUND: Prims = {"/Ground": {"type": "Plane"}}
OFFSETS = (0.0, 1e3, 1e6, 1e8)
"""Distances from the origin along each axis [m]."""
SENSOR = "/Sensor"
NORMALS = "/app/sensors/nv/lidar/publishNormals"
REST = 2e-5
"""A box at rest sinks 10 micrometres into the ground, whatever its mass; twice that is allowed [m]."""
FAN = np.linspace(-60.0, 60.0, 25)
"""Azimuths [deg]."""
MASSES = tuple(10.0**power for power in (-6, -3, 0, 3, 6, 9))


@dataclass(frozen=True, slots=True)
class Case:
    """One row of the table.

    area, name: what is at the extreme. bound: the largest error allowed [unit], or a text: the line in which the value
    must be refused or reported contains it. why: where the bound comes from. measure: by one value of `over`, its error
    or the line. slow: needs minutes or gigabytes; it runs only on request.
    """

    area: str
    name: str
    bound: float | str
    unit: str
    why: str
    measure: Callable[[Any], float | str]
    over: tuple[Any, ...] = (None,)
    slow: bool = False

    @property
    def limit(self) -> str:
        """The bound as the table shows it."""
        return f'"{self.bound}"' if isinstance(self.bound, str) else shown(self.bound, self.unit)

    @property
    def line(self) -> str:
        """What `--only` looks at."""
        return f"{self.area} {self.name} {self.why}"

    def run(self) -> Outcome:
        """Measures it at every value; the outcome is that of the worst."""
        return max((self._at(value) for value in self.over), key=lambda one: (not one.ok, one.error))

    def _at(self, value: Any) -> Outcome:
        where = "" if value is None else f" at {value:g}" if isinstance(value, float) else f" at {value}"
        try:
            found = self.measure(value)
        except Exception as error:  # one defect must not end the table
            return Outcome(self, f"{type(error).__name__}: {' '.join(str(error).split())}{where}", False, math.inf)
        if isinstance(found, str):
            ok = isinstance(self.bound, str) and self.bound in found and "\n" not in found
            return Outcome(self, "reported" if ok else f"{found or 'taken without a word'}{where}", ok, 0.0)
        ok = not isinstance(self.bound, str) and found <= self.bound
        told = shown(found, self.unit) + (where if len(self.over) > 1 and found else "")
        return Outcome(self, told, ok, math.inf if math.isnan(found) else found)


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a case gave: the measured value as text, whether it meets the bound, and the size of its error."""

    case: Case
    measured: str
    ok: bool
    error: float


def shown(value: float, unit: str) -> str:
    """A value with its unit."""
    return f"{value:.2g} {unit}".rstrip()


def refusal(act: Callable[[], Any]) -> str:
    """The message with which an action is refused; empty if it is not."""
    try:
        act()
    except (UserError, RunError, ValueError) as error:
        return str(error)
    return ""


def outcomes(cases: Iterable[Case]) -> Iterator[Outcome]:
    """Runs cases, one after the other; what they warn of is not shown."""
    log = logging.getLogger("tickgraph")
    before = log.level
    log.setLevel(logging.CRITICAL)
    try:
        for case in cases:
            yield case.run()
    finally:
        log.setLevel(before)


def row(outcome: Outcome) -> tuple[str, str, str, str, str]:
    """The cells of an outcome, as the table has them."""
    case = outcome.case
    return case.area, case.name, case.limit, outcome.measured, case.why


@contextmanager
def playing(prims: Prims, hz: Any = 240, loop: Any = 60, stage: Any = None, **knobs: Any) -> Iterator[App]:
    """An App that plays these prims; knobs: of fidelity, with "_" for the first "."."""
    fidelity = {name.replace("_", ".", 1): value for name, value in knobs.items()}
    with App(stage, physics_hz=hz, loop_hz=loop, fidelity=fidelity, settings={NORMALS: True}) as app:
        app.add_prims(prims)
        app.play()
        yield app


def cube(size: float, place: Any, **keys: Any) -> dict[str, Any]:
    """A cube at a place [stage units]."""
    return {"type": "Cube", "size": size, "translate": [float(one) for one in place], **keys}


def body(size: float, place: Any, **keys: Any) -> dict[str, Any]:
    """A cube that is a rigid body."""
    return cube(size, place, rigid_body=True, **keys)


def beams(azimuth: Any, elevation: Any = 0.0, **fields: Any) -> LidarConfig:
    """A lidar that sends all these beams [deg] at once, 10 times a second, from 0 to 10 km, without dropping a miss."""
    azimuth, elevation = np.broadcast_arrays(np.asarray(azimuth, float), np.asarray(elevation, float))
    fields = {"near_range_m": 0.0, "far_range_m": 1e4, "min_reflection_range_m": 1e4, "min_reflectance": 0.0, **fields}
    return LidarConfig(
        scan_type="SOLID_STATE",
        pattern_firing_rate_hz=Fraction(10),
        emitter_states=(EmitterState(azimuth_deg=azimuth, elevation_deg=elevation),),
        skip_dropping_invalid_points=True,
        **fields,
    )


def seen(kind: str, prims: Prims, channels: str, place: Any = (0, 0, 0), *, metre: float = 1.0, **keys: Any) -> Frame:
    """The newest frame, after a few updates, of a sensor of this type at a place [stage units].

    metre: in stage units. keys: `stage`, `config` of a lidar, `updates`; others are of the prim.
    """
    config, stage = keys.pop("config", None), keys.pop("stage", None) or open_stage()
    updates = keys.pop("updates", 6)
    stage.SetMetadata("metersPerUnit", 1 / metre)
    with App(stage, physics_hz=60, loop_hz=60, settings={NORMALS: True}) as app:
        app.add_prims({**prims, SENSOR: {"type": kind, "translate": [float(one) for one in place], **keys}})
        prim = app.stage.GetPrimAtPath(SENSOR)
        if config is not None:
            write_config(prim, config)
        write_aux_level(prim, "FULL")
        product = render_product(app, SENSOR, (16, 16))
        product.sensor.require("stability", set(channels.split()), ignore_aux=True)
        app.play()
        app.update(updates)
        if product.frame is None:
            raise RunError(f"no frame in {updates} updates")
        frame: Frame = product.frame
        return frame


def ranges(prims: Prims, azimuth: Any, elevation: Any = 0.0, place: Any = (0, 0, 0), **fields: Any) -> Any:
    """The ranges [m] of a lidar's beams."""
    return channel(seen("OmniLidar", prims, "distance", place, config=beams(azimuth, elevation, **fields)), "distance")


def channel(frame: Frame, name: str) -> Any:
    """A channel as float64."""
    return frame.channel(name).astype(np.float64)


def worst(found: Any, wanted: Any) -> float:
    """The largest difference; NaN if any is missing."""
    return float(np.abs(np.asarray(found) - wanted).max())


def fall(hz: int, start: Any, metre: float = 1.0, steps: int = 0) -> float:
    """How far a fall of 1 s, or of so many steps, is from g dt^2 n (n + 1) / 2, that of the method [m]."""
    steps, stage = steps or hz, open_stage()
    stage.SetMetadata("metersPerUnit", 1 / metre)
    with playing({"/Box": body(0.5 * metre, np.asarray(start) * metre)}, hz, stage=stage) as app:
        assert app.physics is not None
        before = float(app.physics.positions[0, 2])
        app.physics.step(steps)
        fallen = before - float(app.physics.positions[0, 2])
        return abs(fallen - GRAVITY * steps * (steps + 1) / 2 / hz**2)


def rest(prims: Any, tops: Any, hz: int = 240, seconds: float = 2.0, **knobs: Any) -> float:
    """How far boxes that stand on each other are from where they were put, (n, 3) [m]."""
    with playing(prims, hz, **knobs) as app:
        assert app.physics is not None
        app.physics.step(max(20, int(seconds * hz)))
        return worst(app.physics.positions, tops)


def at_rest(offset: float) -> float:
    """A box on a block of 10 m, both at an offset."""
    place = np.array([offset, offset, offset + 0.25])
    return rest({"/Block": cube(10, place - [0, 0, 5.25]), "/Box": body(0.5, place)}, place)


def alone(mass: float = 1.0, hz: int = 240, seconds: float = 2.0, size: float = 0.5) -> float:
    """A box on the ground."""
    return rest({**GROUND, "/Box": body(size, (0, 0, size / 2), mass=mass)}, (0, 0, size / 2), hz, seconds)


def camera_at(app: App, rate: Fraction) -> RenderProduct:
    """The product of a camera of this tick rate [Hz]."""
    rated = {"schemas": "OmniSensorAPI", "attributes": {"omni:sensor:tickRate": float(rate)}}
    app.add_prims({SENSOR: {"type": "Camera", **rated}})
    product = render_product(app, SENSOR, (2, 2))
    product.sensor.require("stability", {"distance_to_camera"})
    return product


def ticks(rate: str) -> float:
    """A sensor's first four stamps, of states at its ticks: how far from k / rate [ns]; a missing one is a second."""
    exact, found = Fraction(rate), list[int]()
    per_tick = max(1, math.ceil(1 / exact))
    with App(physics_hz=exact * per_tick, loop_hz=exact * per_tick) as app:
        product = camera_at(app, exact)
        app.play()
        for _ in range(4 * per_tick):
            app.update()
            if product.new_frame:
                found.append(product.frame.timestamp_ns)
    if len(found) != 4:
        return 1e9
    return max(abs(stamp - float((k + 1) / exact * 10**9)) for k, stamp in enumerate(found))


def steps(pair: tuple[int, int]) -> float:
    """Physics at one rate, updates at another, for 1000 updates: how many steps too many or too few."""
    hz, loop = pair
    with App(physics_hz=hz, loop_hz=loop) as app:
        app.play()
        app.update(1000)
        return abs(app.simulation.get_num_physics_steps() - 1000 * hz // loop)


def no_rate(value: Any) -> str:
    """The line about an invalid rate."""
    return refusal(lambda: App(physics_hz=value)) and refusal(lambda: App(loop_hz=value))


def wall(distance: float, half: float = 1.0) -> dict[str, Any]:
    """A square ahead, of this half width."""
    corners = [[distance, y, z] for y, z in ((-half, -half), (-half, half), (half, half), (half, -half))]
    return {"type": "Mesh", "points": corners, "faces": [[0, 1, 2, 3]]}


def along_x(found: Any, azimuth: Any) -> Any:
    """The x of what rays of these azimuths [deg] meet."""
    return found * np.cos(np.radians(azimuth))


def at_wall(gap: float) -> float:
    """Ranges to a wall: relative error."""
    return worst(along_x(ranges({"/Wall": wall(gap, 2 * gap)}, FAN, far_range_m=1e8), FAN) / gap, 1.0)


def far_out(offset: float) -> float:
    """Ranges from 5 to 10 m, sensor and wall at an offset [m]."""
    place = np.full(3, offset)
    return worst(along_x(ranges({"/Wall": cube(100, [*(place + np.array([55, 0, 0]))])}, FAN, place=place), FAN), 5)


CASES = (
    Case("bodies", "a fall 0 to 1e8 m from the origin", 2e-6, "m", "240 roundings of float64 at 1e8 m, 7.5e-9 m each",
         lambda offset: fall(240, [offset, offset, offset + 100]), OFFSETS),
    Case("bodies", "a box at rest 0 to 1e8 m from the origin", REST, "m", "10 um of sinking, as at the origin",
         at_rest, OFFSETS),
    Case("bodies", "a box of 1e-6 to 1e9 kg at rest", REST, "m", "contact is scaled by the mass", alone, MASSES),
    Case("rays", "a wall at 1e-6 to 1e6 m", 3e-7, "of the range", "float32: 2^-24 in range and in direction", at_wall,
         (1e-6, 1e-3, 1.0, 1e3, 1e6)),
    Case("rays", "a wall in 5 m, 0 to 1e8 m from the origin", 1e-3, "m", "rays are float32 around the sensor", far_out,
         OFFSETS),
    Case("clocks", "a sensor's ticks at 1e-3 to 1e5 Hz", 0.5, "ns", "stamps are rounded from k / rate", ticks,
         ("1/1000", "466/1000", "1", "2997/100", "1000", "100000")),
    Case("clocks", "physics of 1 Hz to 1 MHz in a loop of 1 Hz to 10 kHz", 0.0, "steps", "the carry is a fraction",
         steps, ((1, 60), (1, 10_000), (240, 60), (100_000, 24), (1_000_000, 1))),
    Case("clocks", "rates of 0, below, 1e10, NaN, Inf", "rate", "", "a rate is finite and above 0", no_rate,
         (0, -60, 1e10, math.nan, math.inf)),
)  # fmt: skip
