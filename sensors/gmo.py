"""GenericModelOutput: one contiguous buffer with header, element arrays and auxiliary arrays.

The first 28 bytes (magic, version, size, element count) are public and fixed. Everything after them is TickGraph's own
layout, version 1.0.0, declared below as numpy dtypes; what is promised is the properties of `GenericModelOutput`, not
byte compatibility with other products. All little-endian. After the header come, each starting at a multiple of 8
bytes, the arrays of `ELEMENT_ARRAYS`, then those auxiliary arrays of `AUX_ARRAYS` whose bit is set in
`filledAuxMembers`.
"""

from __future__ import annotations

import enum
import warnings
from typing import Any

import numpy as np

from .channels import CHANNELS, AuxLevel
from .frame import Frame, quaternion_of

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
    """What the elements are."""

    POINTCLOUD = 0


class CoordsType(enum.IntEnum):
    """What x, y, z hold."""

    CARTESIAN = 0
    SPHERICAL = 1
    NOT_APPLICABLE = 2


class FrameOfReference(enum.IntEnum):
    """Which axes the elements are given in."""

    SENSOR = 0
    PARENT = 1
    WORLD = 2
    CUSTOM = 3


class MotionCompensationState(enum.IntEnum):
    """Whether each ray keeps the frame of its own firing time, or all were mapped to one frame time."""

    NONCOMPENSATED = 0
    COMPENSATED = 1
    NOT_APPLICABLE = 2


class ElementFlags(enum.IntFlag):
    """Bits of `flags`; VALID marks an element with a return."""

    FLAG_1 = 1
    FLAG_2 = 2
    FLAG_3 = 4
    FLAG_4 = 8
    FLAG_5 = 16
    FLAG_6 = 32
    FLAG_7 = 64
    VALID = 128


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
}

FRAME_AT_TIME = np.dtype([("timestampNs", "<u8"), ("orientation", "<f8", 4), ("posM", "<f8", 3)])
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
    ]
)
_INTEGERS = (
    *("majorVersion", "minorVersion", "patchVersion", "sizeInBytes"),
    *("numElements", "frameId", "timestampNs"),
)
_ENUMS = {
    "modality": Modality,
    "outputType": OutputType,
    "auxType": AuxLevel,
    "frameOfReference": FrameOfReference,
    "motionCompensationState": MotionCompensationState,
    "elementsCoordsType": CoordsType,
    "filledAuxMembers": LidarAuxHas,
}
OTHER_SCALARS: dict[str, type[int] | type[float]] = {
    **dict.fromkeys(("sensorID", "scanIdx", "cycleCnt"), int),
    **dict.fromkeys(("maxRangeM", "minVelMps", "maxVelMps", "minAzRad", "maxAzRad", "minElRad", "maxElRad"), float),
    **dict.fromkeys(("numSgws", "numSamplesPerSgw", "idsFilledAuxMembers", "numCols", "numRows"), int),
    **dict.fromkeys(("originX", "originY", "originZ"), float),
}
"""Fields of radars, acoustic and idealised depth sensors: 0 in a lidar's output."""

OTHER_ARRAYS = {"rv_ms": "<f4", "idsVelocities": "<f4", "materialId": "<u4", "objectId": "<u4"}
"""Arrays of such sensors: empty in a lidar's output."""

BASE_CHANNELS = frozenset({"azimuth", "elevation", "distance", "scalar", "timeOffsetNs", "flags"})
CARTESIAN_CHANNELS = frozenset({"xyz", "scalar", "timeOffsetNs", "flags"})


def channels_for(level: AuxLevel, coords: str) -> frozenset[str]:
    """The channels a buffer of this auxiliary level holds, if all are filled."""
    base = CARTESIAN_CHANNELS if coords == "CARTESIAN" else BASE_CHANNELS
    return base | {name for name in AUX_ARRAYS if CHANNELS[name].level <= level}


def pack(frame: Frame) -> np.ndarray:
    """The frame as a GenericModelOutput buffer, (size,) uint8, written once and not shared with anything."""
    filled = [name for name in AUX_ARRAYS if name in frame.arrays and CHANNELS[name].level <= frame.aux_level]
    filled = [name for name in filled if len(frame.arrays[name]) == frame.count]
    offsets, size = _layout(frame.count, filled)
    buffer = np.zeros(size, np.uint8)
    header = buffer[: HEADER.itemsize].view(HEADER)[0]
    header["magicNumber"] = MAGIC
    header["majorVersion"], header["minorVersion"], header["patchVersion"] = VERSION
    header["sizeInBytes"], header["numElements"] = size, frame.count
    header["modality"], header["outputType"] = Modality[frame.modality], OutputType.POINTCLOUD
    header["auxType"] = frame.aux_level
    header["frameOfReference"] = FrameOfReference[frame.frame_of_reference]
    header["motionCompensationState"] = MotionCompensationState[frame.motion_compensation]
    header["elementsCoordsType"] = CoordsType[frame.coords]
    header["frameId"], header["timestampNs"] = frame.frame_id, frame.timestamp_ns
    for name, pose in (("frameStart", frame.start), ("frameEnd", frame.end)):
        w, x, y, z = quaternion_of(pose.world_sensor[:3, :3])
        header[name] = (pose.timestamp_ns, (x, y, z, w), pose.position_m)
    header["modelToAppTransform"] = np.eye(4)
    if frame.aux_level >= AuxLevel.BASIC:
        header["filledAuxMembers"] = int(sum(AUX_ARRAYS[name] for name in filled))
        header["azimuthOffset"], header["scanComplete"] = frame.azimuth_offset_deg, frame.scan_complete
    for name, source in _sources(frame).items():
        _place(buffer, offsets[name], ELEMENT_DTYPES[name], source)
    for name in filled:
        _place(buffer, offsets[name], CHANNELS[name].dtype, frame.arrays[name])
    return buffer


def _sources(frame: Frame) -> dict[str, np.ndarray]:
    found = {name: frame.arrays[name] for name in ("timeOffsetNs", "scalar", "flags") if name in frame.arrays}
    if frame.coords == "CARTESIAN":
        return found | {name: frame.xyz[:, axis] for axis, name in enumerate("xyz")}
    angles = zip("xyz", ("azimuth", "elevation", "distance"), strict=True)
    return found | {name: frame.arrays[channel] for name, channel in angles if channel in frame.arrays}


def _place(buffer: np.ndarray, offset: int, dtype: np.dtype[Any], source: np.ndarray) -> None:
    target = buffer[offset : offset + source.size * dtype.itemsize].view(dtype)
    target.reshape(source.shape)[...] = source


def _layout(count: int, aux: list[str]) -> tuple[dict[str, int], int]:
    """Byte offset of every array, and the size of the whole buffer."""
    offsets, position = {}, HEADER.itemsize
    sizes = {name: ELEMENT_DTYPES[name].itemsize for name in ELEMENT_ARRAYS}
    sizes |= {name: CHANNELS[name].dtype.itemsize * CHANNELS[name].width for name in aux}
    for name, size in sizes.items():
        position = -(-position // 8) * 8
        offsets[name] = position
        position += size * count
    return offsets, position


class _ReadOnly:
    """Attributes are set once, through `__dict__`."""

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__}.{name} is read-only")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{type(self).__name__}.{name} is read-only")


class FrameAtTime(_ReadOnly):
    """A pose at a moment: timestampNs [ns], orientation quaternion (i, j, k, w), posM position [m] in the world."""

    timestampNs: int
    orientation: np.ndarray
    posM: np.ndarray

    def __init__(self, record: Any) -> None:
        self.__dict__.update(
            timestampNs=int(record["timestampNs"]),
            orientation=_locked(np.array(record["orientation"])),
            posM=_locked(np.array(record["posM"])),
        )

    def __repr__(self) -> str:
        return f"FrameAtTime({self.timestampNs} ns, {self.orientation.tolist()}, {self.posM.tolist()} m)"


class GenericModelOutput(_ReadOnly):
    """Read-only view of a GenericModelOutput buffer; made by `parse_generic_model_output_data`.

    Header fields are attributes: magicNumber, majorVersion, minorVersion, patchVersion, sizeInBytes, numElements,
    modality, outputType, auxType, frameOfReference, motionCompensationState, elementsCoordsType (enums), frameId,
    timestampNs, frameStart, frameEnd, modelToAppTransform, scanComplete, azimuthOffset [deg], filledAuxMembers.
    Per element: timeOffsetNs, x, y, z, scalar, flags, and the auxiliary arrays; an array that the buffer does not hold
    (its level is above auxType, or nobody filled it) is empty. Fields of other kinds of sensors (`OTHER_SCALARS`,
    `OTHER_ARRAYS`: sensorID, rv_ms, numSgws, ...) are there too: 0, and empty.
    """

    magicNumber: int
    majorVersion: int
    minorVersion: int
    patchVersion: int
    sizeInBytes: int
    numElements: int
    frameId: int
    timestampNs: int
    modality: Modality
    outputType: OutputType
    auxType: AuxLevel
    frameOfReference: FrameOfReference
    motionCompensationState: MotionCompensationState
    elementsCoordsType: CoordsType
    filledAuxMembers: LidarAuxHas
    frameStart: FrameAtTime
    frameEnd: FrameAtTime
    modelToAppTransform: np.ndarray
    scanComplete: bool
    azimuthOffset: float

    def __init__(self, buffer: np.ndarray | None = None) -> None:
        record = np.zeros(1, HEADER)[0] if buffer is None else buffer[: HEADER.itemsize].view(HEADER)[0]
        fields: dict[str, Any] = {name: int(record[name]) for name in _INTEGERS}
        fields["magicNumber"] = MAGIC if buffer is None else int(record["magicNumber"])
        fields |= {name: kind(int(record[name])) for name, kind in _ENUMS.items()}
        fields |= {name: FrameAtTime(record[name]) for name in ("frameStart", "frameEnd")}
        fields["modelToAppTransform"] = _locked(np.array(record["modelToAppTransform"]))
        fields["scanComplete"] = bool(record["scanComplete"])
        fields["azimuthOffset"] = float(record["azimuthOffset"])
        self.__dict__.update(fields, _arrays={})
        if buffer is not None:
            self._read_arrays(buffer)

    _arrays: dict[str, np.ndarray]

    def _read_arrays(self, buffer: np.ndarray) -> None:
        buffer = _locked(buffer.view())
        count = self.numElements
        aux = [name for name, bit in AUX_ARRAYS.items() if bit in self.filledAuxMembers]
        offsets, size = _layout(count, aux)
        if size > len(buffer):
            raise ValueError(f"{count} elements need {size} bytes; the buffer holds {len(buffer)}")
        for name in ELEMENT_ARRAYS:
            dtype = ELEMENT_DTYPES[name]
            self._arrays[name] = buffer[offsets[name] : offsets[name] + count * dtype.itemsize].view(dtype)
        for name in aux:
            dtype, width = CHANNELS[name].dtype, CHANNELS[name].width
            view = buffer[offsets[name] : offsets[name] + count * width * dtype.itemsize].view(dtype)
            self._arrays[name] = view.reshape(count, width) if width > 1 else view

    def __getattr__(self, name: str) -> Any:
        if name == "timeOffSetNs":
            name = "timeOffsetNs"
        if name in ELEMENT_DTYPES:
            return self._arrays.get(name, np.empty(0, ELEMENT_DTYPES[name]))
        if name in AUX_ARRAYS:
            return self._arrays.get(name, CHANNELS[name].empty())
        if name in OTHER_ARRAYS:
            return np.empty(0, OTHER_ARRAYS[name])
        if name in OTHER_SCALARS:
            return OTHER_SCALARS[name]()
        raise AttributeError(f"GenericModelOutput has no field {name}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *ELEMENT_ARRAYS, "timeOffSetNs", *AUX_ARRAYS, *OTHER_SCALARS, *OTHER_ARRAYS]


def parse_generic_model_output_data(data: Any) -> GenericModelOutput:
    """Reads a GenericModelOutput buffer: an ndarray (any dtype, taken as bytes), bytes, or a handle of ours.

    None, a buffer that is too short, a wrong magic number (normal while a sensor warms up) and another version of the
    layout give a warning and an empty GenericModelOutput with `numElements` 0, never an exception. Arrays are read-only
    views of the buffer, which may itself be read-only. Integers are opaque handles of this process
    (`sensors.handles`), never addresses: an unknown one gives the same warning.
    """
    if isinstance(data, (int, np.integer)):
        from .handles import resolve

        found = resolve(int(data))
        if isinstance(found, Frame):
            return GenericModelOutput(pack(found))
        if not isinstance(found, np.ndarray):
            return _empty(f"{int(data)} is no buffer handle; pass the array itself (addresses are never read)")
        data = found
    if data is None:
        return _empty("no data yet")
    try:
        buffer = np.frombuffer(data, np.uint8) if isinstance(data, (bytes, bytearray, memoryview)) else _bytes_of(data)
        if len(buffer) < HEADER.itemsize:
            return _empty(f"{len(buffer)} bytes are no GenericModelOutput, whose header has {HEADER.itemsize}")
        magic = int(buffer[:4].view("<u4")[0])
        if magic != MAGIC:
            return _empty(f"the magic number is {magic:#010x}, not {MAGIC:#010x}")
        major = int(buffer[4:8].view("<u4")[0])
        if major != VERSION[0]:
            return _empty(f"it has layout version {major}, this reads {VERSION[0]}")
        return GenericModelOutput(buffer)
    except (ValueError, TypeError) as error:
        return _empty(str(error))


def _locked(array: np.ndarray) -> np.ndarray:
    array.setflags(write=False)
    return array


def _bytes_of(data: Any) -> np.ndarray:
    array = np.ascontiguousarray(data.numpy() if hasattr(data, "numpy") else data)
    return array.reshape(-1).view(np.uint8)


def _empty(reason: str) -> GenericModelOutput:
    warnings.warn(f"empty GenericModelOutput: {reason}", RuntimeWarning, stacklevel=3)
    return GenericModelOutput()


def getMagicNumberGMO() -> int:
    """The number every buffer starts with."""
    return MAGIC
