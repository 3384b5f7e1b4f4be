"""GenericModelOutput: a frame as one contiguous buffer, packed and parsed."""

from .buffer import GenericModelOutput as GenericModelOutput
from .buffer import getMagicNumberGMO as getMagicNumberGMO
from .buffer import pack as pack
from .buffer import parse_generic_model_output_data as parse_generic_model_output_data
from .layout import AUX_ARRAYS as AUX_ARRAYS
from .layout import ELEMENT_ARRAYS as ELEMENT_ARRAYS
from .layout import HEADER as HEADER
from .layout import AuxType as AuxType
from .layout import CoordsType as CoordsType
from .layout import ElementFlags as ElementFlags
from .layout import FrameOfReference as FrameOfReference
from .layout import LidarAuxHas as LidarAuxHas
from .layout import Modality as Modality
from .layout import MotionCompensationState as MotionCompensationState
from .layout import OutputType as OutputType
from .layout import channels_for as channels_for
