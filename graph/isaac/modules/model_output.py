"""`generic_model_output` of the RTX sensors' extensions: buffers, and the enums of their fields."""

from __future__ import annotations

from sensors.gmo import (
    AuxType,
    CoordsType,
    ElementFlags,
    FrameOfReference,
    GenericModelOutput,
    Modality,
    MotionCompensationState,
    OutputType,
    getMagicNumberGMO,
    parse_generic_model_output_data,
)

__all__ = [
    "AuxType",
    "CoordsType",
    "ElementFlags",
    "FrameOfReference",
    "GenericModelOutput",
    "Modality",
    "MotionCompensationState",
    "OutputType",
    "getMagicNumberGMO",
    "getModelOutputFromBuffer",
]
getModelOutputFromBuffer = parse_generic_model_output_data  # noqa: N816
