"""The layout of GenericModelOutput buffers: numbers, enums, dtypes, and the place of each array.

The first 28 bytes (magic, version, size, element count) are public and fixed. Everything after them is TickGraph's own
layout, version 1.0.0, declared here as numpy dtypes. Everything is little-endian. The header is followed by the arrays
of `ELEMENT_ARRAYS`, then by those of `AUX_ARRAYS` whose bit is set in `filledAuxMembers`; each array starts at a
multiple of 8 bytes.
"""

from __future__ import annotations

import enum

import numpy as np

from sensors.channels import CHANNELS, AuxLevel

MAGIC = 0x4E474D4F
VERSION = (1, 0, 0)


class Modality(enum.IntEnum):
    """Kind of sensor that wrote the buffer."""

    UNDEFINED = 0
    LIDAR = 1
    RADAR = 2
    ACOUSTIC = 3
    IDS = 4


class OutputType(enum.IntEnum):
    """The kind of elements."""

    POINTCLOUD = 0


class CoordsType(enum.IntEnum):
    """The meaning of x, y, z."""

    CARTESIAN = 0
    SPHERICAL = 1
    NOT_APPLICABLE = 2


class FrameOfReference(enum.IntEnum):
    """The frame in which the elements are given."""

    SENSOR = 0
    PARENT = 1
    WORLD = 2
    CUSTOM = 3


class MotionCompensationState(enum.IntEnum):
    """Whether each ray keeps the frame of its own firing time, or all are transformed to one time."""

    NONCOMPENSATED = 0
    COMPENSATED = 1
    NOT_APPLICABLE = 2


class ElementFlags(enum.IntFlag):
    """Bits of `flags`; VALID marks an element with a return, by the bit 0x40 that the original documents."""

    FLAG_1 = 1
    FLAG_2 = 2
    FLAG_3 = 4
    FLAG_4 = 8
    FLAG_5 = 16
    FLAG_6 = 32
    VALID = 64
    FLAG_7 = 128


class LidarAuxHas(enum.IntFlag):
    """Bits of `filledAuxMembers`: which auxiliary arrays the buffer holds."""

    NONE = 0
    EMITTER_ID = 1
    CHANNEL_ID = 2
    ECHO_ID = 4
    MAT_ID = 8
    OBJ_ID = 16
    TICK_ID = 32
    TICK_STATES = 64
    HIT_NORMALS = 128
    VELOCITIES = 256
    RADIAL_VELOCITY = 512
    """A radar's rv_ms; ours."""


class IDSAuxHas(enum.IntFlag):
    """Bits of `idsFilledAuxMembers`."""

    NONE = 0
    VELOCITIES = 1


AuxType = AuxLevel

ELEMENT_ARRAYS = ("timeOffsetNs", "x", "y", "z", "scalar", "flags")
ELEMENT_DTYPES = {name: CHANNELS[name].dtype for name in ("timeOffsetNs", "scalar", "flags")} | dict.fromkeys(
    "xyz", np.dtype("<f4")
)
AUX_ARRAYS = {
    "emitterId": LidarAuxHas.EMITTER_ID,
    "channelId": LidarAuxHas.CHANNEL_ID,
    "echoId": LidarAuxHas.ECHO_ID,
    "matId": LidarAuxHas.MAT_ID,
    "objId": LidarAuxHas.OBJ_ID,
    "tickId": LidarAuxHas.TICK_ID,
    "tickStates": LidarAuxHas.TICK_STATES,
    "hitNormals": LidarAuxHas.HIT_NORMALS,
    "velocities": LidarAuxHas.VELOCITIES,
    "rv_ms": LidarAuxHas.RADIAL_VELOCITY,
}

FRAME_AT_TIME = np.dtype([("timestampNs", "<u8"), ("orientation", "<f8", 4), ("posM", "<f8", 3)])
OTHER_SCALARS: dict[str, str] = {
    **dict.fromkeys(("cycleCnt",), "<u8"),
    **dict.fromkeys(("sensorID", "scanIdx"), "<u4"),
    **dict.fromkeys(("maxRangeM", "minVelMps", "maxVelMps", "minAzRad", "maxAzRad", "minElRad", "maxElRad"), "<f4"),
    **dict.fromkeys(("numSgws", "numSamplesPerSgw", "idsFilledAuxMembers", "numCols", "numRows"), "<u4"),
    **dict.fromkeys(("originX", "originY", "originZ"), "<f4"),
}
"""Fields of radars, acoustic and idealised depth sensors, with their dtypes: 0 in a lidar's output."""

OTHER_ARRAYS = {"idsVelocities": "<f4", "materialId": "<u4", "objectId": "<u4"}
"""Arrays of such sensors: empty in a lidar's output."""

HEADER = np.dtype(
    [
        ("magicNumber", "<u4"),
        ("majorVersion", "<u4"),
        ("minorVersion", "<u4"),
        ("patchVersion", "<u4"),
        ("sizeInBytes", "<u8"),
        ("numElements", "<u4"),
        ("modality", "<u4"),
        ("outputType", "<u4"),
        ("auxType", "<u4"),
        ("frameOfReference", "<u4"),
        ("motionCompensationState", "<u4"),
        ("elementsCoordsType", "<u4"),
        ("filledAuxMembers", "<u4"),
        ("frameId", "<u8"),
        ("timestampNs", "<u8"),
        ("frameStart", FRAME_AT_TIME),
        ("frameEnd", FRAME_AT_TIME),
        ("modelToAppTransform", "<f8", (4, 4)),
        ("azimuthOffset", "<f4"),
        ("scanComplete", "u1"),
        ("reserved", "u1", 3),
        *OTHER_SCALARS.items(),
    ]
)
INTEGER_FIELDS = (
    *("majorVersion", "minorVersion", "patchVersion", "sizeInBytes"),
    *("numElements", "frameId", "timestampNs"),
)
ENUM_FIELDS = {
    "modality": Modality,
    "outputType": OutputType,
    "auxType": AuxLevel,
    "frameOfReference": FrameOfReference,
    "motionCompensationState": MotionCompensationState,
    "elementsCoordsType": CoordsType,
    "filledAuxMembers": LidarAuxHas,
}
XYZ_CHANNELS = {
    "SPHERICAL": ("azimuth", "elevation", "distance"),
    "CARTESIAN": ("xyz",),
    "NOT_APPLICABLE": ("txMount", "rxMount", "wayChannel"),
}
"""Kind of coordinates -> the channels in x, y and z; NOT_APPLICABLE: those of an acoustic sensor."""


def channels_for(level: AuxLevel, coords: str) -> frozenset[str]:
    """The channels in a buffer of this auxiliary level, if all are filled."""
    base = frozenset({*XYZ_CHANNELS[coords], "scalar", "timeOffsetNs", "flags"})
    return base | {name for name in AUX_ARRAYS if CHANNELS[name].level <= level}


def layout_of(count: int, aux: list[str]) -> tuple[dict[str, int], int]:
    """Byte offset of every array, and the size of the whole buffer."""
    offsets, position = {}, HEADER.itemsize
    sizes = {name: ELEMENT_DTYPES[name].itemsize for name in ELEMENT_ARRAYS}
    sizes |= {name: CHANNELS[name].dtype.itemsize * CHANNELS[name].width for name in aux}
    for name, size in sizes.items():
        position = -(-position // 8) * 8
        offsets[name] = position
        position += size * count
    return offsets, position
