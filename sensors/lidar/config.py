"""A lidar's configuration: its pattern, ranges and optics, as one immutable value."""

from __future__ import annotations

import dataclasses
import math
from fractions import Fraction
from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.base.limits import allowed, most
from graph.base.records import dataclass, field

from .names import camel_case

EMITTER_FLOATS = (
    "azimuth_deg",
    "elevation_deg",
    "vert_offset_m",
    "hor_offset_m",
    "distance_correction_m",
    "focal_dist_m",
    "focal_slope",
    "emitter_peak_power_w",
)
EMITTER_INTEGERS = ("fire_time_ns", "channel_id", "bank", "range_id")
MIN_SCAN_RATE_HZ = Fraction(10**9, 2**31 - 1)
"""Time offsets are int32 nanoseconds, which limits the length of a turn (0.466 Hz)."""

MOST_RETURNS = 255
"""Numbers of returns are uint8."""

STEEPEST_DEG = 90.0

TOKENS = {
    "scan_type": ("ROTARY", "SOLID_STATE"),
    "ray_type": ("IDEALIZED", "UNIFORM_BEAM", "GAUSSIAN_BEAM"),
    "intensity_processing": ("NORMALIZATION", "CORRECTION", "RAW"),
    "intensity_mapping_type": ("LINEAR", "NONLINEAR", "NONLINEAR_ENCODING_ONLY", "NONLINEAR_DECODING_ONLY"),
    "rotation_direction": ("CW", "CCW"),
    "elements_coords_type": ("SPHERICAL", "CARTESIAN"),
    "output_frame_of_reference": ("SENSOR", "WORLD", "CUSTOM"),
    "output_motion_compensation_state": ("NONCOMPENSATED", "COMPENSATED", "NOT_APPLICABLE"),
}
"""The tokens of each field that has some; of rayType and intensityProcessing the first is what is modelled."""


@dataclass(frozen=True, slots=True, eq=False)
class EmitterState:
    """One set of emitter parameters; arrays with one entry per emitter, empty if the profile does not give them.

    Angles [deg] in the sensor frame at rotor azimuth 0, counter-clockwise and up; fire_time_ns after the tick;
    vert_offset_m up and hor_offset_m to the left of the sensor's origin; floats are float32, integers uint32, as USD
    stores them.
    """

    azimuth_deg: np.ndarray
    elevation_deg: np.ndarray
    fire_time_ns: np.ndarray = field(default_factory=lambda: np.zeros(0, np.uint32))
    channel_id: np.ndarray = field(default_factory=lambda: np.zeros(0, np.uint32))
    bank: np.ndarray = field(default_factory=lambda: np.zeros(0, np.uint32))
    range_id: np.ndarray = field(default_factory=lambda: np.zeros(0, np.uint32))
    vert_offset_m: np.ndarray = field(default_factory=lambda: np.zeros(0, np.float32))
    hor_offset_m: np.ndarray = field(default_factory=lambda: np.zeros(0, np.float32))
    distance_correction_m: np.ndarray = field(default_factory=lambda: np.zeros(0, np.float32))
    focal_dist_m: np.ndarray = field(default_factory=lambda: np.zeros(0, np.float32))
    focal_slope: np.ndarray = field(default_factory=lambda: np.zeros(0, np.float32))
    emitter_peak_power_w: np.ndarray = field(default_factory=lambda: np.zeros(0, np.float32))

    def __post_init__(self) -> None:
        for names, dtype in ((EMITTER_FLOATS, np.float32), (EMITTER_INTEGERS, np.uint32)):
            for name in names:
                array = np.array(getattr(self, name), dtype).reshape(-1)
                array.setflags(write=False)
                object.__setattr__(self, name, array)

    def __len__(self) -> int:
        return len(self.elevation_deg)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, EmitterState) and all(
            np.array_equal(getattr(self, name), getattr(other, name)) for name in (*EMITTER_FLOATS, *EMITTER_INTEGERS)
        )

    def __hash__(self) -> int:
        return hash(len(self))


@dataclass(frozen=True, slots=True)
class LidarConfig:
    """Everything that determines which rays a lidar casts, when, and which returns it keeps.

    Field names are the attributes of `omni:sensor:Core:` in snake case; rates [Hz] are exact. Defaults are the
    rotary default profile. Raises UserError, which names the field, for values that are not valid for a lidar.
    """

    name: str = "Generic"
    scan_type: str = "ROTARY"
    scan_rate_base_hz: Fraction = Fraction(10)
    pattern_firing_rate_hz: Fraction = Fraction(36000)
    number_of_channels: int = 0
    max_returns: int = 2
    state_resolution_step: int = 1
    num_lines: int = 0
    num_rays_per_line: tuple[int, ...] = ()
    near_range_m: float = 0.3
    far_range_m: float = 200.0
    valid_start_azimuth_deg: float = 0.0
    valid_end_azimuth_deg: float = 360.0
    start_azimuth_offset_deg: float = 0.0
    min_azimuth_roi: float = 0.0
    max_azimuth_roi: float = 0.0
    ranges_min_m: tuple[float, ...] = ()
    ranges_max_m: tuple[float, ...] = ()
    range_offset_m: float = 0.0
    range_resolution_m: float = 0.004
    range_accuracy_m: float = 0.02
    min_dist_between_echos_m: float = 0.0
    min_reflectance: float = 0.1
    min_reflection_range_m: float = 200.0
    azimuth_error_mean: float = 0.0
    azimuth_error_std: float = 0.0
    elevation_error_mean: float = 0.0
    elevation_error_std: float = 0.0
    origin_error_mean: tuple[float, ...] = (0.0, 0.0, 0.0)
    origin_error_std: tuple[float, ...] = (0.0, 0.0, 0.0)
    avg_power_w: float = 0.002
    wave_length_nm: float = 903.0
    pulse_time_ns: float = 6.0
    divergence_hor_deg: float = 0.0
    divergence_ver_deg: float = 0.0
    focus_dist_m: float = 0.0
    effective_aperture_size_m: float = 0.0
    intensity_processing: str = "NORMALIZATION"
    intensity_mapping_type: str = "LINEAR"
    intensity_mapping_encoding: tuple[float, ...] = ()
    intensity_mapping_decoding: tuple[float, ...] = ()
    intensity_scale_percent: float = 255.0
    ray_type: str = "IDEALIZED"
    rotation_direction: str = "CW"
    skip_dropping_invalid_points: bool = False
    elements_coords_type: str = "SPHERICAL"
    output_frame_of_reference: str = "SENSOR"
    custom_frame_of_reference_trafo: tuple[float, ...] = ()
    output_motion_compensation_state: str = "NONCOMPENSATED"
    accumulate_outputs: bool = True
    emitter_states: tuple[EmitterState, ...] = ()

    @property
    def number_of_emitters(self) -> int:
        """Rays per tick."""
        return len(self.emitter_states[0]) if self.emitter_states else 0

    @property
    def emitter_state_count(self) -> int:
        """How many emitter states the ticks cycle through."""
        return len(self.emitter_states)

    @property
    def is_rotary(self) -> bool:
        """Whether a rotor turns the emitters; otherwise every tick covers the whole field of view."""
        return self.scan_type == "ROTARY"

    @property
    def ticks_per_scan(self) -> int:
        """Firings of the whole emitter pattern in one scan, floor(firing rate / scan rate), at least 1."""
        return max(1, math.floor(self.pattern_firing_rate_hz / self.scan_rate_base_hz))

    @property
    def rays_per_scan(self) -> int:
        """How many rays one scan casts, before any azimuth window."""
        return self.ticks_per_scan * self.number_of_emitters

    @property
    def ticks_per_second(self) -> Fraction:
        """The firing rate, or the scan rate if a solid-state profile fires more slowly than it scans."""
        return max(self.pattern_firing_rate_hz, self.scan_rate_base_hz)

    def __post_init__(self) -> None:
        problems = [*self._bad_scalars(), *self._bad_states()]
        if not problems and self.rays_per_scan > most("lidar.rays"):
            problems.append(
                f"{self.rays_per_scan:,} rays a scan are more than {most('lidar.rays'):,}; lower patternFiringRateHz, "
                f"raise scanRateBaseHz or use fewer emitters; {allowed('lidar.rays')}"
            )
        if problems:
            raise UserError(f"lidar config {self.name}: {'; '.join(problems)}")

    def _bad_scalars(self) -> list[str]:
        problems = [
            f"{camel_case(name)} = {getattr(self, name)!r} is not one of {', '.join(tokens)}"
            for name, tokens in TOKENS.items()
            if getattr(self, name) not in tokens
        ]
        problems += [
            f"{camel_case(f.name)} is not finite"
            for f in dataclasses.fields(self)
            if _not_finite(getattr(self, f.name))
        ]
        if not 0 <= self.pulse_time_ns < 2**32:
            problems.append(f"pulseTimeNs = {self.pulse_time_ns:g} is not a number from 0 that a uint can hold")
        if self.scan_rate_base_hz < MIN_SCAN_RATE_HZ:
            problems.append(f"scanRateBaseHz = {float(self.scan_rate_base_hz):g} Hz; the slowest scan is 0.466 Hz")
        if self.pattern_firing_rate_hz <= 0:
            problems.append("patternFiringRateHz must be above 0")
        elif self.is_rotary and self.pattern_firing_rate_hz < self.scan_rate_base_hz:
            problems.append(
                f"patternFiringRateHz = {float(self.pattern_firing_rate_hz):g} is below scanRateBaseHz = "
                f"{float(self.scan_rate_base_hz):g}: a rotary lidar would not fire once a turn"
            )
        if not 0 <= self.near_range_m < self.far_range_m:
            problems.append(f"the range is {self.near_range_m:g} to {self.far_range_m:g} m; near must be below far")
        if len(self.ranges_min_m) != len(self.ranges_max_m):
            problems.append("rangesMinM and rangesMaxM differ in length")
        problems += [
            f"{camel_case(name)} has {len(getattr(self, name))} entries, not 3"
            for name in ("origin_error_mean", "origin_error_std")
            if len(getattr(self, name)) not in (0, 3)
        ]
        problems += [
            f"{camel_case(name)} is negative" for name in _DEVIATIONS if np.any(np.array(getattr(self, name)) < 0)
        ]
        if any(not 0 <= low < high for low, high in zip(self.ranges_min_m, self.ranges_max_m, strict=False)):
            problems.append("rangesMinM must be at least 0 and below rangesMaxM")
        if not 1 <= self.max_returns <= MOST_RETURNS:
            problems.append(f"maxReturns must be from 1 to {MOST_RETURNS}")
        return problems

    def _bad_states(self) -> list[str]:
        if not self.emitter_states or not self.number_of_emitters:
            return ["it has no emitters: elevationDeg of emitter state s001 is empty"]
        count, problems = self.number_of_emitters, []
        for number, state in enumerate(self.emitter_states, start=1):
            for name in (*EMITTER_FLOATS, *EMITTER_INTEGERS):
                array = getattr(state, name)
                if len(array) != count and (len(array) or name == "azimuth_deg"):
                    problems.append(
                        f"emitter state s{number:03}: {camel_case(name)} has {len(array)} entries for {count} emitters"
                    )
                if array.dtype == np.float32 and not np.all(np.isfinite(array)):
                    problems.append(f"emitter state s{number:03}: {camel_case(name)} holds a value that is not finite")
            if np.any(np.abs(state.elevation_deg) > STEEPEST_DEG):
                problems.append(f"emitter state s{number:03}: elevationDeg holds a value beyond {STEEPEST_DEG:g} deg")
            if self.ranges_min_m and len(state.range_id) and state.range_id.max() >= len(self.ranges_min_m):
                problems.append(f"emitter state s{number:03}: rangeId {state.range_id.max()} has no range")
        if self.num_rays_per_line and sum(self.num_rays_per_line) != count:
            problems.append(f"numRaysPerLine sums to {sum(self.num_rays_per_line)} for {count} emitters")
        return problems


_DEVIATIONS = (
    *("range_resolution_m", "range_accuracy_m", "azimuth_error_std", "elevation_error_std", "origin_error_std"),
    *(
        "divergence_hor_deg",
        "divergence_ver_deg",
        "min_dist_between_echos_m",
        "min_reflectance",
        "min_reflection_range_m",
    ),
)


def _not_finite(value: Any) -> bool:
    if isinstance(value, tuple):
        return any(map(_not_finite, value))
    return isinstance(value, float) and not math.isfinite(value)
