"""Names of lidar attributes: camelCase on prims and in files, snake_case in Python."""

from __future__ import annotations

import re

PRIM_TYPE = "OmniLidar"
MODALITY = "LIDAR"
CORE_API = "OmniSensorGenericLidarCoreAPI"
PREFIX = "omni:sensor:Core:"
STATE_PREFIX = "omni:sensor:Core:emitterState:"
OVRTX = {"partialOutputs": ("accumulateOutputs", False), "includeInvalidPoints": ("skipDroppingInvalidPoints", True)}
"""Words of ovrtx -> ours for the same, and whether true means true."""
EXACT = {name: f"tickgraph:{name}" for name in ("scanRateBaseHz", "patternFiringRateHz", "pulseTimeNs")}
"""Whole numbers in the schema -> the attribute that holds the exact value if it is not whole."""


def snake_case(name: str) -> str:
    """nearRangeM -> near_range_m."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def camel_case(name: str) -> str:
    """near_range_m -> nearRangeM."""
    first, *rest = name.split("_")
    return first + "".join("ROI" if part == "roi" else part.capitalize() for part in rest)
