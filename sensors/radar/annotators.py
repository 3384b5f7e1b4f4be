"""The annotator that reads radars alone."""

from __future__ import annotations

from typing import Any

from sensors.annotators.outputs import extract_point_cloud
from sensors.annotators.types import AnnotatorType, Reading, with_info
from sensors.channels import CHANNELS

from .names import MODALITY


def _point_cloud(reading: Reading) -> dict[str, Any]:
    frame = reading.frame
    if frame is None:
        return with_info({"data": CHANNELS["xyz"].empty()}, reading)
    found = extract_point_cloud(frame)
    found["rcs"] = found.pop("intensity")
    told = with_info(found, reading)
    told["info"] |= {**frame.facts, "numDetections": frame.count}
    return told


ANNOTATORS = (
    AnnotatorType(
        "IsaacCreateRTXRadarPointCloud",
        _point_cloud,
        lambda reading: ("xyz", "azimuth", "elevation", "distance", "scalar", "timeOffsetNs"),
        optional=True,
        modality=MODALITY,
    ),
)
"""Points [m] as "data", "rcs" [dBsm], "radialVelocityMS" at level BASIC, angles, distances and times; "info" also has
the scan, its cycle and its limits.
"""
