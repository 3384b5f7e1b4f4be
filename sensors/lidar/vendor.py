"""Vendor lidar profiles: the JSON format of the legacy camera-prim sensors, read leniently."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from graph import exact
from graph.errors import UserError

from .config import EmitterState, LidarConfig

MAX_BYTES = 64 << 20
FASTEST_HZ = 10**9
_SCAN_TYPES = {"rotary": "ROTARY", "solidstate": "SOLID_STATE", "solid_state": "SOLID_STATE"}
_NUMBERS = {
    "nearRangeM": "near_range_m",
    "farRangeM": "far_range_m",
    "startAzimuthDeg": "valid_start_azimuth_deg",
    "endAzimuthDeg": "valid_end_azimuth_deg",
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
    "pulseTimeNs": "pulse_time_ns",
    "focusDistM": "focus_dist_m",
    "effectiveApertureSize": "effective_aperture_size_m",
}
_INTEGERS = {
    "maxReturns": "max_returns",
    "numberOfChannels": "number_of_channels",
    "numLines": "num_lines",
    "stateResolutionStep": "state_resolution_step",
}
_EMITTER_ARRAYS = {
    "azimuthDeg": "azimuth_deg",
    "elevationDeg": "elevation_deg",
    "fireTimeNs": "fire_time_ns",
    "channelId": "channel_id",
    "bank": "bank",
    "rangeId": "range_id",
    "vertOffsetM": "vert_offset_m",
    "horOffsetM": "hor_offset_m",
}


def load_profile(path: str | Path) -> LidarConfig:
    """The configuration of a profile file. Raises UserError for files that are no lidar profile."""
    path = Path(path)
    try:
        if path.stat().st_size > MAX_BYTES:
            raise UserError(f"lidar profile {path.name}: larger than 64 MiB")
        document = json.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise UserError(f"lidar profile {path}: cannot be read ({error.strerror})") from error
    except (ValueError, RecursionError) as error:
        place = f"{path}:{error.lineno}:{error.colno}" if isinstance(error, json.JSONDecodeError) else str(path)
        raise UserError(f"lidar profile {place}: this is not valid JSON") from error
    return parse_profile(document, str(path))


def parse_profile(document: Any, name: str) -> LidarConfig:
    """The configuration of a parsed profile.

    Unknown keys and every kind of comment are ignored; what is left out keeps the default profile's value; channels
    are the emitters when no `channelId` is given. Raises UserError naming the field for values of the wrong kind.
    """
    if not isinstance(document, Mapping) or not isinstance(document.get("profile"), Mapping):
        raise UserError(f'lidar profile {name}: not a lidar profile: it has no "profile" object')
    if document.get("type", "lidar") != "lidar":
        raise UserError(f"lidar profile {name}: its type is {document['type']!r}, not lidar")
    reader = _Reader(name)
    profile = document["profile"]
    fields: dict[str, Any] = {"name": str(document.get("name", Path(name).stem))}
    fields["scan_type"] = reader.scan_type(profile.get("scanType", "rotary"))
    fields["scan_rate_base_hz"] = reader.rate("scanRateBaseHz", profile.get("scanRateBaseHz", 10))
    fields["pattern_firing_rate_hz"] = reader.rate("reportRateBaseHz", profile.get("reportRateBaseHz", 36000))
    for key, field in _NUMBERS.items():
        if profile.get(key) is not None:
            fields[field] = reader.number(key, profile[key])
    for key, field in _INTEGERS.items():
        if profile.get(key) is not None:
            fields[field] = reader.integer(key, profile[key])
    for key, field in (
        ("rotationDirection", "rotation_direction"),
        ("intensityProcessing", "intensity_processing"),
        ("intensityMappingType", "intensity_mapping_type"),
        ("rayType", "ray_type"),
    ):
        if isinstance(profile.get(key), str):
            fields[field] = profile[key].upper()
    fields["num_rays_per_line"] = tuple(
        int(n) for n in reader.array("numRaysPerLine", profile.get("numRaysPerLine", ()))
    )
    ranges = [entry for entry in profile.get("ranges") or () if isinstance(entry, Mapping)]
    fields["ranges_min_m"] = tuple(reader.number("ranges.min", entry.get("min", 0.0)) for entry in ranges)
    fields["ranges_max_m"] = tuple(reader.number("ranges.max", entry.get("max", 1e9)) for entry in ranges)
    states = [entry for entry in profile.get("emitterStates") or () if isinstance(entry, Mapping)]
    fields["emitter_states"] = tuple(reader.state(number, entry) for number, entry in enumerate(states, start=1))
    config = LidarConfig(**fields)
    listed = profile.get("numberOfEmitters", config.number_of_emitters)
    if listed != config.number_of_emitters:
        raise UserError(
            f"lidar profile {name}: numberOfEmitters is {listed}, but {config.number_of_emitters} are listed"
        )
    return config


class _Reader:
    """Converts fields, naming the profile and the field in what it raises."""

    def __init__(self, profile: str) -> None:
        self._profile = profile

    def number(self, key: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise self._error(key, "is not a finite number")
        return float(value)

    def integer(self, key: str, value: Any) -> int:
        number = self.number(key, value)
        if number != int(number) or number < 0:
            raise self._error(key, "is not a whole number")
        return int(number)

    def rate(self, key: str, value: Any) -> Any:
        rate = exact.rate(value) if isinstance(value, str) else exact.rate(self.number(key, value))
        if not 0 < rate <= FASTEST_HZ:
            raise self._error(key, f"must be above 0 and at most {FASTEST_HZ:,} Hz")
        return rate

    def scan_type(self, value: Any) -> str:
        if str(value).lower() not in _SCAN_TYPES:
            raise self._error("scanType", f"is {value!r}; it is rotary or solidState")
        return _SCAN_TYPES[str(value).lower()]

    def array(self, key: str, value: Any) -> np.ndarray:
        try:
            array = np.asarray(value, np.float64)
        except (TypeError, ValueError):
            array = np.zeros(())
        if array.ndim != 1:
            raise self._error(key, "is not a list of numbers")
        if not np.all(np.isfinite(array)):
            raise self._error(key, "holds a value that is not finite")
        return array

    def state(self, number: int, entry: Mapping[str, Any]) -> EmitterState:
        arrays = {}
        for key, field in _EMITTER_ARRAYS.items():
            array = self.array(f"emitterStates[{number - 1}].{key}", entry.get(key, ()))
            if field in ("fire_time_ns", "channel_id", "bank", "range_id") and np.any((array < 0) | (array >= 2**32)):
                raise self._error(f"emitterStates[{number - 1}].{key}", "holds a value outside 0 to 2**32 - 1")
            arrays[field] = array
        if not len(arrays["azimuth_deg"]):
            arrays["azimuth_deg"] = np.zeros(len(arrays["elevation_deg"]))
        if not len(arrays["elevation_deg"]):
            arrays["elevation_deg"] = np.zeros(len(arrays["azimuth_deg"]))
        return EmitterState(**arrays)

    def _error(self, key: str, what: str) -> UserError:
        return UserError(f"lidar profile {self._profile}: {key} {what}")
