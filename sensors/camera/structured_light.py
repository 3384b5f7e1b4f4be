"""StructuredLightCamera: a camera with a projector that shows one pattern after another."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.extras import install_command
from graph.base.records import dataclass
from graph.sim import entered
from sensors.errors import SensorValueError
from sensors.prim import write
from sensors.xform import Vector, place, world_pose

from .authoring import RtxCamera
from .light_images import DIRECTIONS, PATTERN

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.app import App


Rational = tuple[int, int]
"""Numerator and denominator of a time [s]."""


@dataclass(frozen=True)
class PatternSchedule:
    """starts: when each pattern begins, the first at 0, rising [s]; period: after which the first begins again [s]."""

    starts: tuple[Fraction, ...]
    period: Fraction

    def active(self, time: Fraction) -> int:
        """The number of the pattern that is on at a time [s]."""
        return bisect_right(self.starts, time % self.period) - 1

    @property
    def shortest(self) -> Fraction:
        """The shortest time for which a pattern is on [s]."""
        return min(after - before for before, after in pairwise((*self.starts, self.period)))


def pattern_schedule(
    timestamps: Sequence[Rational] | None, period: Rational | None, count: int, where: str
) -> PatternSchedule:
    """The schedule of `count` patterns.

    timestamps: numerator and denominator of each start [s]; None: 30 patterns a second. period: None: the last start
    and the first interval; 1/30 s for one pattern. Raises SensorValueError, naming `where`.
    """
    given = [(number, 30) for number in range(count)] if timestamps is None else timestamps
    if not isinstance(given, (list, tuple)) or len(given) != count:
        raise SensorValueError(f"{where}: projector_timestamps {given!r}: give {count} (numerator, denominator) [s]")
    starts = tuple(_fraction(each, f"{where}: projector_timestamps[{place}]") for place, each in enumerate(given))
    if starts[0] != 0:
        raise SensorValueError(f"{where}: projector_timestamps[0] is {starts[0]} s; the first pattern begins at (0, 1)")
    for number, (before, after) in enumerate(pairwise(starts), start=1):
        if after <= before:
            raise SensorValueError(f"{where}: projector_timestamps[{number}] is {after} s, not after {before} s")
    if period is None:
        return PatternSchedule(starts, starts[-1] + starts[1] if count > 1 else Fraction(1, 30))
    found = _fraction(period, f"{where}: projector_cycle_period")
    if found <= starts[-1]:
        raise SensorValueError(f"{where}: projector_cycle_period is {found}; the last pattern begins at {starts[-1]} s")
    return PatternSchedule(starts, found)


def _fraction(value: object, where: str) -> Fraction:
    if isinstance(value, (list, tuple)) and len(value) == 2 and all(type(part) is int for part in value) and value[1]:
        return Fraction(value[0], value[1])
    raise SensorValueError(f"{where} is {value!r}; give two whole numbers, (numerator, denominator) [s]")


BEFORE_RENDERING = -1000
"""Order in the phase render: before any frame is made."""


class StructuredLightCamera(RtxCamera):
    """An `RtxCamera` with a cluster of RectLights, one for each pattern, of which one is visible at a time.

    projector_light_patterns: the files of the patterns. projector_direction_texture: an OpenEXR file with the direction
    in which each place of a pattern goes: unit, x right, y up, along -z (`write_directions` makes one of a pinhole).
    projector_prim_path: the Xform of the lights, by default <path>/projectors; one that exists keeps its pose.
    projector_position (3,) [stage units] and projector_orientation (4,) w, x, y, z: below its parent; by default the
    camera's. projector_timestamps: (numerator, denominator) of the simulation time [s] at which each pattern begins,
    the first 0, rising; by default 30 a second. projector_cycle_period: after which the first begins again [s]; by
    default the last start and the first interval, or 1/30 s. projector_intensity [nit], projector_width and
    projector_height [stage units]: of the light's rectangle, the projector's lens. Other options as of `RtxCamera`.

    Every update shows the pattern whose start is the last one not after the timeline's time modulo the period; warnings
    say when updates are too far apart for it. Raises SensorValueError (a UserError and a ValueError).
    """

    def __init__(
        self,
        path: str,
        projector_light_patterns: Sequence[str | Path],
        projector_direction_texture: str | Path,
        *,
        projector_prim_path: str | None = None,
        projector_position: Vector = None,
        projector_orientation: Vector = None,
        projector_timestamps: Sequence[Rational] | None = None,
        projector_cycle_period: Rational | None = None,
        projector_intensity: float = 150_000.0,
        projector_width: float = 1.0,
        projector_height: float = 1.0,
        app: App | None = None,
        **options: Any,
    ) -> None:
        if isinstance(projector_light_patterns, (str, Path)) or not len(projector_light_patterns):
            raise SensorValueError(f"{path}: projector_light_patterns: give a list of at least one image file")
        if projector_direction_texture is None:
            raise SensorValueError(f"{path}: projector_direction_texture: give an OpenEXR file of directions")
        sizes = {"intensity": projector_intensity, "width": projector_width, "height": projector_height}
        for name, size in sizes.items():
            if not (np.isfinite(size) and size >= 0):
                raise SensorValueError(f"{path}: projector_{name} is {size}; give a finite number from 0")
        self._patterns = list(projector_light_patterns)
        self._directions = projector_direction_texture
        self._period = projector_cycle_period
        self._schedule = pattern_schedule(projector_timestamps, self._period, len(self._patterns), path)
        super().__init__(path, app=app, **options)
        self._timeline = (entered.current() if app is None else app).timeline
        self._projector = projector_prim_path or f"{self.path}/projectors"
        self._define_projector(projector_position, projector_orientation, sizes)
        self._last: Fraction | None = None
        self._show(0)
        self._unsubscribe = [
            self.scene.on("render", self._follow_time, BEFORE_RENDERING),
            self.scene.on("stop", self.post_reset),
        ]

    def destroy(self) -> None:
        """Ends the change of patterns; may be called again."""
        while self._unsubscribe:
            self._unsubscribe.pop()()

    def post_reset(self) -> None:
        """Begins again with the first pattern."""
        self._last = None
        self._show(0)

    def get_active_pattern_index(self) -> int:
        """The number of the pattern that is shown, from 0."""
        return self._active

    def set_active_pattern_manual(self, pattern_index: int) -> None:
        """Shows a pattern until the next update. Raises IndexError for a number without a pattern."""
        if not 0 <= pattern_index < len(self._patterns):
            raise IndexError(f"{self.path}: pattern {pattern_index}: there are 0 to {len(self._patterns) - 1}")
        self._show(pattern_index)

    def get_num_patterns(self) -> int:
        """How many patterns there are."""
        return len(self._patterns)

    def get_projector_prim_path(self) -> str:
        """The path of the Xform that holds the lights."""
        return self._projector

    def get_rect_light_prims(self) -> list[Usd.Prim]:
        """The lights, one for each pattern."""
        return [self.scene.stage.GetPrimAtPath(path) for path in self._lights]

    def get_projector_direction_texture(self) -> str | Path:
        """The file of directions, as it was given."""
        return self._directions

    def get_projector_timestamps(self) -> list[Rational]:
        """Numerator and denominator of each pattern's start [s], in lowest terms."""
        return [start.as_integer_ratio() for start in self._schedule.starts]

    def set_projector_timestamps(self, timestamps: Sequence[Rational]) -> None:
        """Replaces the starts; a period that was given stays, any other follows from them. Raises SensorValueError."""
        self._schedule = pattern_schedule(timestamps, self._period, len(self._patterns), self.path)
        self.post_reset()

    def get_projector_cycle_period(self) -> Rational:
        """Numerator and denominator of the period [s], in lowest terms."""
        return self._schedule.period.as_integer_ratio()

    def set_projector_cycle_period(self, period: Rational | None) -> None:
        """Sets the period [s]; None: it follows from the starts. Raises SensorValueError."""
        self._schedule = pattern_schedule(self.get_projector_timestamps(), period, len(self._patterns), self.path)
        self._period, self._last = period, None

    @property
    def _lights(self) -> list[str]:
        return [f"{self._projector}/RectLight_{number:02d}" for number in range(len(self._patterns))]

    def _define_projector(self, position: Vector, orientation: Vector, sizes: dict[str, float]) -> None:
        from graph.sim.usd import Sdf, UsdGeom, UsdLux

        stage = self.scene.stage
        for light in self._lights:
            prim = stage.GetPrimAtPath(light)
            if prim and not prim.IsA(UsdLux.RectLight):
                raise SensorValueError(f"{light} is a {prim.GetTypeName() or 'typeless prim'}, not a RectLight")
        if not stage.GetPrimAtPath(self._projector):
            inside = self._projector.startswith(f"{self.path}/")
            own = (np.zeros(3), np.array([1.0, 0, 0, 0])) if inside else world_pose(self.prim)
            UsdGeom.Xform.Define(stage, self._projector)
            place(
                stage.GetPrimAtPath(self._projector),
                translations=own[0] if position is None else position,
                orientations=own[1] if orientation is None else orientation,
            )
        for light, pattern in zip(self._lights, self._patterns, strict=True):
            prim = UsdLux.RectLight.Define(stage, light).GetPrim()
            UsdLux.ShapingAPI.Apply(prim)
            for name, size in sizes.items():
                write(prim, f"inputs:{name}", "float", float(size))
            write(prim, PATTERN, "asset", Sdf.AssetPath(str(pattern)))
            write(prim, DIRECTIONS, "asset", Sdf.AssetPath(str(self._directions)))
            write(prim, "isProjector", "bool", True)
            write(prim, "visibleInPrimaryRay", "bool", False)

    def _follow_time(self) -> None:
        """Shows the pattern of the timeline's time."""
        time, schedule, count = self._timeline.current_time, self._schedule, len(self._patterns)
        number = schedule.active(time)
        if self._last is not None and time > self._last and count > 1:
            passed = time - self._last
            if passed > schedule.shortest:
                said = f"updates are {float(passed):g} s apart, a pattern is on for {float(schedule.shortest):g} s"
                self.scene.warn(
                    "projector-too-fast", self.path, f"{said}: raise the loop rate, or space the timestamps"
                )
            if (skipped := (number - self._active) % count - 1) > 0:
                said = f"{skipped} of {count} patterns were passed over at {float(time):g} s; raise the loop rate"
                self.scene.warn("pattern-skipped", self.path, said)
        self._last = time
        if number != self._active:
            self._show(number)

    def _show(self, number: int) -> None:
        from graph.sim.usd import UsdGeom

        for which, light in enumerate(self.get_rect_light_prims()):
            if light:
                imageable = UsdGeom.Imageable(light)
                (imageable.MakeVisible if which == number else imageable.MakeInvisible)()
        self._active = number


def write_directions(
    file: str | Path,
    size: tuple[int, int],
    fx: float,
    fy: float | None = None,
    centre: tuple[float, float] | None = None,
) -> None:
    """Writes the direction texture of a projector that is a pinhole.

    size: width and height [px]; fx, fy: focal lengths [px], fy as fx by default; centre: where the axis meets the
    pattern [px], in the middle by default. Needs OpenEXR (the extra `exr`); raises SensorValueError.
    """
    try:
        import OpenEXR
    except ImportError:
        raise SensorValueError(f"{file} would be an OpenEXR file. Run: {install_command('exr')}") from None
    width, height = size
    across, down = centre or (width / 2, height / 2)
    x, y = np.meshgrid((np.arange(width) + 0.5 - across) / fx, (np.arange(height) + 0.5 - down) / (fy or fx))
    rays = np.stack([x, -y, -np.ones_like(x)])
    planes = dict(zip("RGB", (rays / np.linalg.norm(rays, axis=0)).astype(np.float32), strict=True))
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, planes) as image:
        image.write(str(file))
