"""Reads vendor lidar profiles: the JSON format of the legacy camera-prim sensors, leniently."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from graph.base.errors import Mark, Problem, UserError
from graph.base.inputs import start_of

from .config import INTENSITY_PROCESSINGS, MIN_SCAN_RATE_HZ, RAY_TYPES, LidarConfig
from .profile_values import ProfileReader, firing_rate_key

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
_TOKENS = {
    "rotationDirection": ("rotation_direction", ("CW", "CCW")),
    "intensityProcessing": ("intensity_processing", INTENSITY_PROCESSINGS),
    "intensityMappingType": (
        "intensity_mapping_type",
        ("LINEAR", "NONLINEAR", "NONLINEAR_ENCODING_ONLY", "NONLINEAR_DECODING_ONLY"),
    ),
    "rayType": ("ray_type", RAY_TYPES),
}


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
    for key, (field, known) in _TOKENS.items():
        if key in profile:
            fields[field] = reader.token(key, profile[key], known)
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
