"""Names of camera prims and of their attributes, and values that a file may have given any type."""

from __future__ import annotations

from typing import Any

import numpy as np

PRIM_TYPE = "Camera"
MODALITY = "CAMERA"
AUX_LEVELS = ("NONE",)
LENS = "omni:lensdistortion:"
LENS_MODEL = "omni:lensdistortion:model"
SHUTTER = "omni:rtx:rollingShutter:"
CROSS_CAMERA = "crossCameraReferenceName"


def numbers_of(value: Any, count: int) -> tuple[float, ...] | None:
    """The value as so many finite numbers; None for any other."""
    try:
        found = np.array(value, np.float64).reshape(-1)
    except (TypeError, ValueError):
        return None
    return tuple(found.tolist()) if found.shape == (count,) and np.isfinite(found).all() else None


def text_of(attribute: Any) -> str:
    """The text of a token or the path of an asset; empty where nothing is said."""
    value = attribute.Get() if attribute else None
    return str(getattr(value, "path", value) or "")
