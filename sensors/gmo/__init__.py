"""GenericModelOutput: a frame as one contiguous buffer, packed and parsed."""

from .buffer import GenericModelOutput, getMagicNumberGMO, pack, parse_generic_model_output_data
from .layout import (
    AUX_ARRAYS,
    ELEMENT_ARRAYS,
    HEADER,
    AuxType,
    CoordsType,
    ElementFlags,
    FrameOfReference,
    LidarAuxHas,
    Modality,
    MotionCompensationState,
    OutputType,
    channels_for,
)

__all__ = [
    "AUX_ARRAYS",
    "ELEMENT_ARRAYS",
    "HEADER",
    "AuxType",
    "CoordsType",
    "ElementFlags",
    "FrameOfReference",
    "GenericModelOutput",
    "LidarAuxHas",
    "Modality",
    "MotionCompensationState",
    "OutputType",
    "channels_for",
    "getMagicNumberGMO",
    "pack",
    "parse_generic_model_output_data",
]
