"""The firing patterns of a lidar: which ray fires at which time of a turn, with exact times.

All turns have one pattern, or several that alternate with its emitter states.
"""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from graph.base.exact import NANOSECONDS
from graph.base.records import dataclass
from graph.base.sharing import Shared

from .config import LidarConfig
from .lines import Lines, lines_of

if TYPE_CHECKING:
    from sensors.raycast.windows import RayGrid


@dataclass(frozen=True, eq=False)
class Pattern:
    """The firings of one turn (rotary) or scan (solid state), sorted by time, then emitter.

    N rows. directions: (N, 3) float32 unit vectors, sensor frame. origins: (N, 3) float32 [m], or None if every ray
    starts at the sensor's origin. azimuth_deg in [-180, 180] and elevation_deg: float32 of the beam. offset_ns: int32,
    0 <= offset < period. keys: the exact times, integers in units of 1/`key_scale` ns, sorted. near_m, far_m: float32
    range gates, scalars if all emitters share them. period: one turn [s].
    """

    directions: np.ndarray
    origins: np.ndarray | None
    azimuth_deg: np.ndarray
    elevation_deg: np.ndarray
    offset_ns: np.ndarray
    emitter_id: np.ndarray
    channel_id: np.ndarray
    tick_id: np.ndarray
    tick_state: np.ndarray
    near_m: np.ndarray
    far_m: np.ndarray
    keys: np.ndarray
    key_scale: int
    period: Fraction
    config: LidarConfig

    def __len__(self) -> int:
        return len(self.offset_ns)

    @cached_property
    def columns(self) -> np.ndarray:
        """(3, N) float32, contiguous: the directions by axis."""
        return np.ascontiguousarray(self.directions.T)

    @cached_property
    def lines(self) -> Lines:
        """The lines of its emitters."""
        return lines_of(self.config)

    @cached_property
    def ring(self) -> np.ndarray:
        """(N,) uint16: the line of each firing, from 0 upwards. Raises UserError if there are too many."""
        self.lines.check(self.config.name)
        return np.asarray(self.lines.ring[self.tick_state, self.emitter_id], np.uint16)

    @cached_property
    def column(self) -> np.ndarray:
        """(N,) uint32: its place along that line, tick by tick."""
        place = self.lines.place[self.tick_state, self.emitter_id]
        return np.asarray(self.tick_id * np.int64(self.lines.longest) + place, np.uint32)

    def grid(self, starts: tuple[int, ...] = (0,)) -> RayGrid:
        """The grid of its directions, cut into spans that begin at `starts`; made at the first call."""
        if starts not in self._grids:
            from sensors.raycast.windows import RayGrid  # only who casts needs it

            self._grids[starts] = RayGrid(self.directions, starts)
        return self._grids[starts]

    @cached_property
    def _grids(self) -> dict[tuple[int, ...], RayGrid]:
        return {}

    def index_at(self, offset: Fraction) -> int:
        """The number of firings before this time [s] after the start of the turn: the start or end index of a slice."""
        scaled = offset * NANOSECONDS * self.key_scale
        return int(np.searchsorted(self.keys, -(-scaled.numerator // scaled.denominator), side="left"))


def firing_pattern(config: LidarConfig, turn: int = 0) -> Pattern:
    """The firing pattern of a turn of a configuration; turns differ only in their emitter states (see `turns`).

    Tick i of a turn fires at i / firing rate after its start, each emitter its fire time later; its azimuth is the
    start azimuth -+ i * 360 * scan rate / firing rate (minus for clockwise) plus the emitter's own azimuth, which is
    never mirrored. A fire time beyond the end of the turn fires in the next turn: its offset wraps. Firings outside the
    valid azimuth window of a rotary lidar are left out. Emitter states alternate, each for `state_resolution_step`
    ticks since play.
    """
    period = 1 / config.scan_rate_base_hz
    ticks, emitters = config.ticks_per_scan, config.number_of_emitters
    tick = np.repeat(np.arange(ticks), emitters)
    emitter = np.tile(np.arange(emitters), ticks)
    state = ((turn * ticks + tick) // max(1, config.state_resolution_step)) % config.emitter_state_count
    keys, key_scale = _firing_keys(config, tick, _per_state(config, "fire_time_ns", state, emitter, 0))
    rotor = _rotor_azimuth(config, tick)
    azimuth = rotor + _per_state(config, "azimuth_deg", state, emitter, 0.0).astype(np.float64)
    elevation = _per_state(config, "elevation_deg", state, emitter, 0.0).astype(np.float64)

    offset_ns = np.minimum(
        _round_half_even(keys, key_scale), -(-period.numerator * NANOSECONDS // period.denominator) - 1
    )
    kept = np.flatnonzero(_in_window(config, azimuth))
    order = kept[np.lexsort((emitter[kept], keys[kept]))]
    tick, emitter, state = tick[order], emitter[order], state[order]
    azimuth, elevation = azimuth[order], elevation[order]
    channel = _per_state(config, "channel_id", state, emitter, -1)
    near, far = _gates(config, state, emitter)
    return Pattern(
        directions=_directions(azimuth, elevation),
        origins=_origins(config, state, emitter, rotor[order]),
        azimuth_deg=((azimuth + 180.0) % 360.0 - 180.0).astype(np.float32),
        elevation_deg=elevation.astype(np.float32),
        offset_ns=offset_ns[order].astype(np.int32),
        emitter_id=emitter.astype(np.uint32),
        channel_id=np.where(channel < 0, emitter, channel).astype(np.uint32),
        tick_id=tick.astype(np.uint32),
        tick_state=state.astype(np.uint8),
        near_m=near,
        far_m=far,
        keys=keys[order],
        key_scale=key_scale,
        period=period,
        config=config,
    )


def _rotor_azimuth(config: LidarConfig, tick: np.ndarray) -> np.ndarray:
    """Azimuth of the rotor at each tick [deg], each the correctly rounded quotient; 0 for solid state."""
    if not config.is_rotary:
        return np.zeros(len(tick))
    step = 360 * config.scan_rate_base_hz / config.ticks_per_second
    turned = tick * step.numerator / step.denominator
    return np.asarray(config.start_azimuth_offset_deg + (-turned if config.rotation_direction == "CW" else turned))


def _per_state(config: LidarConfig, name: str, state: np.ndarray, emitter: np.ndarray, default: float) -> np.ndarray:
    """One emitter parameter for each firing; a state without it has the default."""
    arrays = [getattr(entry, name) for entry in config.emitter_states]
    table = np.array([array if len(array) else np.full(config.number_of_emitters, default) for array in arrays])
    if np.issubdtype(arrays[0].dtype, np.integer):
        table = table.astype(np.int64)
    return np.asarray(table[state, emitter])


def _firing_keys(config: LidarConfig, tick: np.ndarray, fire_ns: np.ndarray) -> tuple[np.ndarray, int]:
    """Exact firing times after the turn's start, modulo the turn, as integers in units of 1/scale ns."""
    rate, period = config.ticks_per_second, 1 / config.scan_rate_base_hz
    scale = rate.numerator * period.denominator
    tick_step = rate.denominator * period.denominator * NANOSECONDS
    turn = period.numerator * rate.numerator * NANOSECONDS
    dtype = np.int64 if turn + int(fire_ns.max(initial=0)) * scale < 2**62 else object
    keys = (tick.astype(dtype) * tick_step + fire_ns.astype(dtype) * scale) % turn
    return keys, scale


def _round_half_even(keys: np.ndarray, scale: int) -> np.ndarray:
    whole, rest = keys // scale, keys % scale
    up = (2 * rest > scale) | ((2 * rest == scale) & (whole % 2 == 1))
    return np.asarray(whole + up, np.int64)


def _in_window(config: LidarConfig, azimuth: np.ndarray) -> np.ndarray:
    """Whether firings are in the valid azimuth window of a rotary lidar, and in the region of interest if it has one.

    The region is minAzimuthROI to maxAzimuthROI, if they differ. Both wrap through 0 if their start is beyond their
    end.
    """
    inside = np.ones(len(azimuth), bool)
    for start, end in _windows(config):
        inside &= (azimuth - start) % 360.0 <= (end - start) % 360.0
    return inside


def windowed(config: LidarConfig) -> bool:
    """Whether a window leaves out firings, perhaps all of them."""
    return bool(_windows(config))


def _windows(config: LidarConfig) -> list[tuple[float, float]]:
    """Begin and end [deg] of each window that is narrower than a turn."""
    windows = []
    if config.min_azimuth_roi != config.max_azimuth_roi:
        windows.append((config.min_azimuth_roi, config.max_azimuth_roi))
    if config.is_rotary:
        windows.append((config.valid_start_azimuth_deg, config.valid_end_azimuth_deg))
    return [(start, end) for start, end in windows if abs(end - start) < 360.0]


def _directions(azimuth_deg: np.ndarray, elevation_deg: np.ndarray) -> np.ndarray:
    azimuth, elevation = np.deg2rad(azimuth_deg), np.deg2rad(elevation_deg)
    level = np.cos(elevation)
    directions = np.empty((len(azimuth), 3), np.float32)
    directions[:, 0] = level * np.cos(azimuth)
    directions[:, 1] = level * np.sin(azimuth)
    directions[:, 2] = np.sin(elevation)
    return directions


def _origins(config: LidarConfig, state: np.ndarray, emitter: np.ndarray, rotor_deg: np.ndarray) -> np.ndarray | None:
    """The origin of each ray: offsets to the left turn with the rotor. None if no emitter has an offset."""
    up = _per_state(config, "vert_offset_m", state, emitter, 0.0)
    left = _per_state(config, "hor_offset_m", state, emitter, 0.0)
    if not up.any() and not left.any():
        return None
    rotor = np.deg2rad(rotor_deg)
    return np.stack([-np.sin(rotor) * left, np.cos(rotor) * left, up], axis=1).astype(np.float32)


def _gates(config: LidarConfig, state: np.ndarray, emitter: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nearest and farthest valid range: the sensor's, narrowed by the emitter's range id if it has one."""
    near, far = np.float32(config.near_range_m), np.float32(config.far_range_m)
    if not config.ranges_min_m:
        return np.array(near), np.array(far)
    range_id = _per_state(config, "range_id", state, emitter, 0)
    gates_near = np.maximum(np.array(config.ranges_min_m, np.float32), near)[range_id]
    gates_far = np.minimum(np.array(config.ranges_max_m, np.float32), far)[range_id]
    if np.all(gates_near == gates_near[:1]) and np.all(gates_far == gates_far[:1]) and len(range_id):
        return gates_near[0:1].reshape(()), gates_far[0:1].reshape(())
    return gates_near, gates_far


MOST_KEPT_RAYS = 8_000_000
"""Most rays of patterns that are kept; a pattern that repeats after more rays is computed again."""

_shared: Shared[LidarConfig, Turns] = Shared()


def turns_of(config: LidarConfig) -> Turns:
    """The turns of a configuration; all lidars of this process that have the same, but for its name, share them."""
    return _shared.of(replace(config, name=""), lambda: Turns(config))


class Turns:
    """The pattern of each turn of a lidar.

    Emitter states continue from turn to turn: if the ticks of a turn are not a whole number of rounds of the states,
    the next turn begins in another state, and the patterns repeat after `count` turns. period: one turn [s].
    """

    def __init__(self, config: LidarConfig) -> None:
        self.period: Fraction = 1 / config.scan_rate_base_hz
        ticks, round_ = config.ticks_per_scan, config.emitter_state_count * max(1, config.state_resolution_step)
        self.count = math.lcm(ticks, round_) // ticks
        self.kept = max(1, min(self.count, MOST_KEPT_RAYS // max(1, config.rays_per_scan)))
        """The number of turns for which data of their patterns is kept."""
        self._pattern = functools.lru_cache(self.kept)(functools.partial(firing_pattern, config))

    def number(self, turn: int) -> int:
        """Turns of the same number have the same pattern."""
        return turn % self.count

    def pattern(self, turn: int) -> Pattern:
        """The firings of a turn."""
        return self._pattern(self.number(turn))

    def slices(self, start: Fraction, end: Fraction, *, whole_turns: int = 0) -> list[tuple[int, slice]]:
        """(turn, rows) of the firings at times in [start, end) [s since play], oldest first.

        Turn t covers [t, t + 1) periods. An interval longer than a turn keeps its last turn; with `whole_turns` = n it
        keeps the last n turns that end in it, and what follows them.
        """
        kept_from = (end // self.period - whole_turns) * self.period if whole_turns else end - self.period
        start = max(start, kept_from)
        if end <= start:
            return []
        first, last = start // self.period, end // self.period
        found = []
        for turn in range(first, last + 1):
            pattern = self.pattern(turn)
            low = pattern.index_at(start - turn * self.period) if turn == first else 0
            high = pattern.index_at(end - turn * self.period) if turn == last else len(pattern)
            if high > low:
                found.append((turn, slice(low, high)))
        return found
