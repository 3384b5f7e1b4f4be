"""Reads vendor lidar profiles: the JSON format of the legacy camera-prim sensors, leniently."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from graph.base import exact
from graph.base.errors import Mark, Problem, UserError
from graph.base.inputs import start_of

from .config import EMITTER_INTEGERS, MIN_SCAN_RATE_HZ, MOST_RETURNS, STEEPEST_DEG, TOKENS, EmitterState, LidarConfig
from .names import camel_case

_SPACE = re.compile(r"[ \t\n\r,:]*")
_DECODER = json.JSONDecoder()


def line_and_column(text: str, location: Sequence[str | int]) -> tuple[int, int]:
    """Line and column, from 1, of the value at a location (keys and indices) of a valid JSON text.

    If a part is missing, those of the innermost existing value; of repeated keys the last counts.
    """
    at = _skip(text, 0)
    for part in location:
        found = _member(text, at, part)
        if found is None:
            break
        at = found
    return text.count("\n", 0, at) + 1, at - text.rfind("\n", 0, at)


def _member(text: str, at: int, part: str | int) -> int | None:
    """The offset of the member `part` in the container at `at`."""
    opening, at = text[at : at + 1], _skip(text, at + 1)
    if opening not in "{[" or (opening == "{") != isinstance(part, str):
        return None
    found, number = None, 0
    while text[at : at + 1] not in ("}", "]", ""):
        key: str | int = number
        if opening == "{":
            key, at = _DECODER.raw_decode(text, at)
            at = _skip(text, at)
        if key == part:
            found = at
            if opening == "[":
                break
        _, at = _DECODER.raw_decode(text, at)
        at, number = _skip(text, at), number + 1
    return found


def _skip(text: str, at: int) -> int:
    match = _SPACE.match(text, at)
    return match.end() if match else at


Location = tuple[str | int, ...]
FASTEST_HZ = 10**9
HUGE = 1e300
"""Whole numbers in JSON have no limit; from this value on they count as infinite."""

_SCAN_TYPES = {"rotary": "ROTARY", "solidstate": "SOLID_STATE", "solid_state": "SOLID_STATE"}
_NOT_NEGATIVE = (
    *("rangeResolutionM", "rangeAccuracyM", "azimuthErrorStd", "elevationErrorStd"),
    *("minDistBetweenEchos", "minReflectance", "minReflectanceRange"),
)
_EMITTER_ARRAYS = {
    camel_case(one.name): one.name for one in dataclasses.fields(EmitterState) if one.name != "emitter_peak_power_w"
}
"""Key of an emitter state in a profile -> field."""


def firing_rate_key(profile: Mapping[str, Any]) -> str:
    """The key of a profile's tick rate: the name since Isaac Sim 6.0, which is preferred, or the older one."""
    return "patternFiringRateHz" if "patternFiringRateHz" in profile else "reportRateBaseHz"


class ProfileReader:
    """Converts the fields of a profile and collects their mistakes, each with its place in `text`."""

    def __init__(self, profile: str, text: str) -> None:
        self._profile, self._text = profile, text
        self._states: list[Location] = []
        self.problems: list[Problem] = []

    def failure(self, location: Location, what: str) -> UserError:
        """An error after which nothing else can be checked."""
        return UserError(self._problem(location, what))

    def number(self, key: str, value: Any, inside: Location = (), wrong: float = 0.0) -> float:
        """A finite number, or `wrong`; `inside`: the location of the key's object in the profile."""
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < HUGE:
            self._wrong((*inside, key), f"is {value!r}, not a finite number")
            return wrong
        return float(value)

    def integer(self, key: str, value: Any) -> int:
        """A whole number of at least 0."""
        number = self.number(key, value)
        if number != int(number) or number < 0:
            self._wrong((key,), f"is {value!r}, not a whole number")
        elif key == "maxReturns" and not 1 <= number <= MOST_RETURNS:
            self._wrong((key,), f"is {value!r}; it is from 1 to {MOST_RETURNS}")
        return max(int(number), 0)

    def rate(self, key: str, value: Any, least: Fraction = Fraction(0)) -> Fraction:
        """A rate [Hz] above 0."""
        try:
            rate = exact.rate(value) if isinstance(value, str) else exact.rate(self.number(key, value))
        except ValueError:
            self._wrong((key,), f"is {value!r}, not a rate in Hz")
            return Fraction(1)
        if not 0 < rate <= FASTEST_HZ:
            self._wrong((key,), f"is {value!r}: it must be above 0 and at most {FASTEST_HZ:,} Hz")
        elif rate < least:
            self._wrong((key,), f"is {value!r} Hz; the slowest scan is 0.466 Hz")
        return rate

    def scan_type(self, value: Any) -> str:
        """ROTARY or SOLID_STATE."""
        if str(value).lower() not in _SCAN_TYPES:
            self._wrong(("scanType",), f"is {value!r}; it is rotary or solidState")
        return _SCAN_TYPES.get(str(value).lower(), "ROTARY")

    def token(self, key: str, value: Any, known: tuple[str, ...]) -> str:
        """A word in capitals, one of `known`."""
        word = str(value).upper()
        if word not in known:
            self._wrong((key,), f"is {value!r}, not one of {', '.join(known)}")
        return word

    def objects(self, key: str, value: Any) -> list[Mapping[str, Any]]:
        """A list of objects; some profiles wrap each in a list of its own."""
        if value is None:
            return []
        if not isinstance(value, list):
            self._wrong((key,), "is not a list")
            return []
        entries = [entry[0] if isinstance(entry, list) and entry else entry for entry in value]
        for number, entry in enumerate(entries):
            if not isinstance(entry, Mapping):
                self._wrong((key, number), "is not an object")
        return [entry for entry in entries if isinstance(entry, Mapping)]

    def array(self, location: Location, value: Any, *, whole: bool = False) -> np.ndarray:
        """A list of numbers as float64 (n,); a mistake is reported at the first wrong number."""
        if not isinstance(value, (list, tuple)):
            self._wrong(location, f"is {value!r}, not a list of numbers")
            return np.zeros(0)
        if set(map(type, value)) <= {int, float}:
            array = np.array([one if abs(one) < HUGE else np.inf for one in value], np.float64)
            bad = np.flatnonzero(~np.isfinite(array) | (whole & ((array < 0) | (array >= 2**32))))
        else:
            bad = np.array([next(at for at, one in enumerate(value) if type(one) not in (int, float))])
        if len(bad):
            span = ", from 0 to 2**32 - 1" if whole else ""
            self._wrong((*location, int(bad[0])), f"is {value[bad[0]]!r}, not a finite number{span}")
            return np.zeros(len(value))
        return array

    def states(self, profile: Mapping[str, Any]) -> tuple[EmitterState, ...]:
        """The emitter states; older profiles have one, an object `emitters`."""
        only = profile.get("emitters")
        if isinstance(only, Mapping) and not profile.get("emitterStates"):
            self._states = [("emitters",)]
            return (self._state(("emitters",), only),)
        entries = self.objects("emitterStates", profile.get("emitterStates"))
        self._states = [("emitterStates", number) for number in range(len(entries))]
        return tuple(map(self._state, self._states, entries))

    def _state(self, location: Location, entry: Mapping[str, Any]) -> EmitterState:
        arrays = {
            field: self.array((*location, key), entry.get(key, ()), whole=field in EMITTER_INTEGERS)
            for key, field in _EMITTER_ARRAYS.items()
        }
        count = len(arrays["elevation_deg"]) or len(arrays["azimuth_deg"])
        for name in ("azimuth_deg", "elevation_deg"):
            if not len(arrays[name]):
                arrays[name] = np.zeros(count)
        for key, field in _EMITTER_ARRAYS.items():
            if len(arrays[field]) not in (0, count):
                self._wrong((*location, key), f"has {len(arrays[field])} entries for {count} emitters")
        return EmitterState(**arrays)

    def check(self, profile: Mapping[str, Any], fields: dict[str, Any]) -> None:
        """Checks that fields fit together. Raises UserError with all problems, if any."""
        states = fields["emitter_states"]
        count = len(states[0]) if states else 0
        if not count and isinstance(profile.get("emitterStates", []), list):
            self._wrong((*self._states, ("emitterStates",))[0][:1], "holds no emitters")
        for number, (low, high) in enumerate(zip(fields["ranges_min_m"], fields["ranges_max_m"], strict=True)):
            if low < 0 or low >= high:
                self._wrong(("ranges", number), f"is {low:g} to {high:g} m; min must be at least 0 and below max")
        for location, state in zip(self._states, states, strict=True):
            steep = np.flatnonzero(np.abs(state.elevation_deg) > STEEPEST_DEG)
            if len(steep):
                what = f"is {state.elevation_deg[steep[0]]:g} deg; elevations are from -90 to 90"
                self._wrong((*location, "elevationDeg", int(steep[0])), what)
            if len(state) != count:
                self._wrong(location, f"has {len(state)} emitters, the first state {count}")
            if len(fields["ranges_min_m"]) and state.range_id.max(initial=0) >= len(fields["ranges_min_m"]):
                worst = int(np.argmax(state.range_id))
                self._wrong((*location, "rangeId", worst), f"is {state.range_id[worst]}: no such range")
        if count and profile.get("numberOfEmitters") not in (None, count):
            listed = profile["numberOfEmitters"]
            self._wrong(("numberOfEmitters",), f"is {listed}, but {count} are listed")
        if count and profile.get("emitterStateCount") not in (None, len(states)):
            self._wrong(("emitterStateCount",), f"is {profile['emitterStateCount']}, but {len(states)} are listed")
        firing, scan = fields["pattern_firing_rate_hz"], fields["scan_rate_base_hz"]
        if not self.problems and fields["scan_type"] == "ROTARY" and firing < scan:
            key = firing_rate_key(profile)
            self._wrong((key,), f"is {float(firing):g}, below scanRateBaseHz = {float(scan):g}: no tick in a turn")
        lines = fields["num_rays_per_line"]
        if count and lines and sum(lines) != count:
            self._wrong(("numRaysPerLine",), f"sums to {sum(lines)} for {count} emitters")
        near, far = fields.get("near_range_m", 0.3), fields.get("far_range_m", 200.0)
        if not self.problems and not 0 <= near < far:
            key = "farRangeM" if "farRangeM" in profile else "nearRangeM"
            self._wrong((key,), f"makes a range of {near:g} to {far:g} m; near must be at least 0 and below far")
        for key in _NOT_NEGATIVE:
            if isinstance(profile.get(key), (int, float)) and profile[key] < 0:
                self._wrong((key,), "is negative")
        if self.problems:
            raise UserError(self.problems)

    def _wrong(self, location: Location, what: str) -> None:
        dotted = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in location)
        self.problems.append(self._problem(("profile", *location), f"{dotted.lstrip('.')} {what}"))

    def _problem(self, location: Location, message: str) -> Problem:
        if not self._text:
            return Problem(f"lidar profile {self._profile}: {message}")
        return Problem(f"lidar profile: {message}", Mark(self._profile, *line_and_column(self._text, location)))


MAX_BYTES = 64 << 20
_NUMBERS = {
    "nearRangeM": "near_range_m",
    "farRangeM": "far_range_m",
    "startAzimuthDeg": "valid_start_azimuth_deg",
    "endAzimuthDeg": "valid_end_azimuth_deg",
    "startAzimuthOffsetDeg": "start_azimuth_offset_deg",
    "rangeOffset": "range_offset_m",
    "rangeResolutionM": "range_resolution_m",
    "rangeAccuracyM": "range_accuracy_m",
    "minDistBetweenEchos": "min_dist_between_echos_m",
    "minReflectance": "min_reflectance",
    "minReflectanceRange": "min_reflection_range_m",
    "azimuthErrorMean": "azimuth_error_mean",
    "azimuthErrorStd": "azimuth_error_std",
    "elevationErrorMean": "elevation_error_mean",
    "elevationErrorStd": "elevation_error_std",
    "avgPowerW": "avg_power_w",
    "wavelengthNm": "wave_length_nm",
    "waveLengthNm": "wave_length_nm",
    "pulseTimeNs": "pulse_time_ns",
    "intensityScalePercent": "intensity_scale_percent",
    "focusDistM": "focus_dist_m",
    "effectiveApertureSize": "effective_aperture_size_m",
}
_INTEGERS = {
    "maxReturns": "max_returns",
    "numberOfChannels": "number_of_channels",
    "numLines": "num_lines",
    "stateResolutionStep": "state_resolution_step",
}
_TOKENS = ("rotation_direction", "intensity_processing", "intensity_mapping_type", "ray_type")


def load_profile(path: str | Path) -> LidarConfig:
    """The configuration of a profile file.

    Raises UserError for a file that is not a lidar profile, with every problem at its line and column.
    """
    path = Path(path)
    try:
        data = start_of(path, MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise UserError(f"lidar profile {path.name}: larger than 64 MiB")
        text = data.decode("utf-8-sig")
        document = json.loads(text)
    except OSError as error:
        raise UserError(f"lidar profile {path}: cannot be read ({error.strerror})") from error
    except json.JSONDecodeError as error:
        mark = Mark(str(path), error.lineno, error.colno)
        raise UserError(Problem(f"lidar profile: this is not valid JSON: {error.msg.lower()}", mark)) from error
    except (ValueError, RecursionError) as error:
        raise UserError(f"lidar profile {path}: this is not valid JSON") from error
    return parse_profile(document, str(path), text)


def parse_profile(document: Any, name: str, text: str = "") -> LidarConfig:
    """The configuration of a parsed profile; `text`: its source, for the places of problems.

    Unknown keys and every kind of comment are ignored; a missing key, or null, keeps the default profile's value;
    channels are the emitters if no `channelId` is given. Raises UserError, which names each wrong field.
    """
    reader = ProfileReader(name, text)
    if not isinstance(document, Mapping) or not isinstance(document.get("profile"), Mapping):
        raise reader.failure((), 'not a lidar profile: it has no "profile" object')
    if document.get("type", "lidar") != "lidar":
        raise reader.failure(("type",), f"its type is {document['type']!r}, not lidar")
    profile = {key: value for key, value in document["profile"].items() if value is not None}
    fields: dict[str, Any] = {"name": str(document.get("name", Path(name).stem))}
    fields["scan_type"] = reader.scan_type(profile.get("scanType", "rotary"))
    fields["scan_rate_base_hz"] = reader.rate("scanRateBaseHz", profile.get("scanRateBaseHz", 10), MIN_SCAN_RATE_HZ)
    rate = firing_rate_key(profile)
    fields["pattern_firing_rate_hz"] = reader.rate(rate, profile.get(rate, 36000))
    for key, field in _NUMBERS.items():
        if key in profile:
            fields[field] = reader.number(key, profile[key])
    for key, field in _INTEGERS.items():
        if key in profile:
            fields[field] = reader.integer(key, profile[key])
    for field in _TOKENS:
        if (key := camel_case(field)) in profile:
            fields[field] = reader.token(key, profile[key], TOKENS[field])
    lines = reader.array(("numRaysPerLine",), profile.get("numRaysPerLine", ()))
    fields["num_rays_per_line"] = tuple(int(n) for n in lines)
    ranges = reader.objects("ranges", profile.get("ranges"))
    for key, field, missing in (("min", "ranges_min_m", 0.0), ("max", "ranges_max_m", 1e9)):
        fields[field] = tuple(
            reader.number(key, entry.get(key, missing), ("ranges", number), math.nan)
            for number, entry in enumerate(ranges)
        )
    fields["emitter_states"] = reader.states(profile)
    reader.check(profile, fields)
    try:
        return LidarConfig(**fields)
    except UserError as error:
        raise reader.failure(("profile",), str(error)) from error
