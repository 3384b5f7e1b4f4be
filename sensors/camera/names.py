"""Names of camera prims and of their attributes."""

from __future__ import annotations

PRIM_TYPE = "Camera"
MODALITY = "CAMERA"
AUX_LEVELS = ("NONE",)
LENS = "omni:lensdistortion:"
LENS_MODEL = "omni:lensdistortion:model"
SHUTTER = "omni:rtx:rollingShutter:"
CROSS_CAMERA = "crossCameraReferenceName"
