"""The annotator that reads radars alone."""

from __future__ import annotations

from typing import Any

from sensors.annotators.outputs import empty_outputs, extract_point_cloud
from sensors.annotators.types import AnnotatorType, Reading, with_info

from .names import MODALITY

NAMES = ("data", "azimuth", "elevation", "distance", "intensity", "timestamp", "radialVelocityMS")


def _point_cloud(reading: Reading) -> dict[str, Any]:
    frame, found = reading.frame, empty_outputs(NAMES)
    if frame is not None:
        found |= extract_point_cloud(frame)
    found["rcs"] = found["intensity"] if reading.options["outputIntensity"] else found.pop("intensity")
    told = with_info(found, reading)
    if frame is not None:
        told["info"] |= {**frame.facts, "numDetections": frame.count}
    return told


ANNOTATORS = (
    AnnotatorType(
        "IsaacCreateRTXRadarPointCloud",
        _point_cloud,
        lambda reading: ("xyz", "azimuth", "elevation", "distance", "scalar", "timeOffsetNs"),
        options=dict.fromkeys(("outputIntensity", "outputTimestamp", "outputRadialVelocityMS"), False),
        optional=True,
        modality=MODALITY,
    ),
)
"""Points [m] as "data", "rcs" [dBsm], "radialVelocityMS" at level BASIC, angles, distances and times, whatever the
options; with outputIntensity "rcs" as "intensity", too. "info" also has the scan, its cycle and its limits.
"""
