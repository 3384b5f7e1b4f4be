"""GenericModelOutput: one contiguous buffer with header, element arrays and auxiliary arrays.

The properties of `GenericModelOutput` are guaranteed, but not byte compatibility with other products; see `layout`.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

import numpy as np

from graph.base.suggesting import Suggesting, UnknownAttributeError
from graph.sim.transforms import quaternion
from sensors.channels import CHANNELS, AuxLevel
from sensors.frame import Frame

from .layout import (
    AUX_ARRAYS,
    ELEMENT_ARRAYS,
    ELEMENT_DTYPES,
    ENUM_FIELDS,
    HEADER,
    INTEGER_FIELDS,
    MAGIC,
    OTHER_ARRAYS,
    OTHER_SCALARS,
    VERSION,
    XYZ_CHANNELS,
    CoordsType,
    FrameOfReference,
    LidarAuxHas,
    Modality,
    MotionCompensationState,
    OutputType,
    layout_of,
)


def pack(frame: Frame) -> np.ndarray:
    """The frame as a GenericModelOutput buffer, (size,) uint8, not shared with any other object."""
    filled = _filled(frame)
    offsets, size = layout_of(frame.count, filled)
    made = frame.arrays.packed(offsets, size, frame.coords) if hasattr(frame.arrays, "packed") else None
    buffer = np.zeros(size, np.uint8) if made is None else made
    _write_header(buffer, frame, filled, size)
    if made is None:
        for name, source in _sources(frame).items():
            _place(buffer, offsets[name], ELEMENT_DTYPES[name], source)
        for name in filled:
            _place(buffer, offsets[name], CHANNELS[name].dtype, frame.arrays[name])
    return buffer


def on_device(frame: Frame) -> GenericModelOutput:
    """The GenericModelOutput of a frame on a device (`graph.sim.devices.plugin_of`), whose arrays stay there."""
    arrays: Any = frame.arrays
    filled = _filled(frame)
    buffer = np.zeros(HEADER.itemsize, np.uint8)
    _write_header(buffer, frame, filled, layout_of(frame.count, filled)[1])
    found = {name: arrays.on_device(name) for name in ("timeOffsetNs", "scalar", "flags", *filled) if name in arrays}
    if frame.coords == "CARTESIAN":
        points = arrays.on_device("xyz")
        found |= {name: points[:, axis] for axis, name in enumerate("xyz")}
    else:
        parts = zip("xyz", XYZ_CHANNELS[frame.coords], strict=True)
        found |= {name: arrays.on_device(channel) for name, channel in parts}
    return GenericModelOutput(buffer, found)


def _filled(frame: Frame) -> list[str]:
    """The auxiliary arrays of a frame's buffer."""
    filled = [name for name in AUX_ARRAYS if name in frame.arrays and CHANNELS[name].level <= frame.aux_level]
    if hasattr(frame.arrays, "packed"):  # on a device all channels have the rows of the frame
        return filled
    return [name for name in filled if len(frame.arrays[name]) == frame.count]


def _write_header(buffer: np.ndarray, frame: Frame, filled: Sequence[str], size: int) -> None:
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
        w, x, y, z = quaternion(pose.world_sensor[:3, :3])
        header[name] = (pose.timestamp_ns, (x, y, z, w), pose.position_m)
    header["modelToAppTransform"] = np.eye(4)
    if frame.aux_level >= AuxLevel.BASIC:
        header["filledAuxMembers"] = int(sum(AUX_ARRAYS[name] for name in filled))
        header["azimuthOffset"], header["scanComplete"] = frame.azimuth_offset_deg, frame.scan_complete
        for name in OTHER_SCALARS:
            header[name] = frame.facts.get(name, 0)


def _sources(frame: Frame) -> dict[str, np.ndarray]:
    found = {name: frame.arrays[name] for name in ("timeOffsetNs", "scalar", "flags") if name in frame.arrays}
    if frame.coords == "CARTESIAN":
        return found | {name: frame.xyz[:, axis] for axis, name in enumerate("xyz")}
    parts = zip("xyz", XYZ_CHANNELS[frame.coords], strict=True)
    return found | {name: frame.arrays[channel] for name, channel in parts if channel in frame.arrays}


def _place(buffer: np.ndarray, offset: int, dtype: np.dtype[Any], source: np.ndarray) -> None:
    target = buffer[offset : offset + source.size * dtype.itemsize].view(dtype)
    target.reshape(source.shape)[...] = source


class _ReadOnly(Suggesting):
    """Attributes are set only once, through `__dict__`."""

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__}.{name} is read-only")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{type(self).__name__}.{name} is read-only")


class FrameAtTime(_ReadOnly):
    """A pose and its time: timestampNs [ns], orientation quaternion (i, j, k, w), posM position [m] in the world."""

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
    timestampNs, frameStart, frameEnd, modelToAppTransform, scanComplete, azimuthOffset [deg], filledAuxMembers. Per
    element: timeOffsetNs, x, y, z, scalar, flags, and the auxiliary arrays; an array that the buffer does not hold (its
    level is above auxType, or it was not filled) is empty. Fields of other kinds of sensors (`OTHER_SCALARS`,
    `OTHER_ARRAYS`: sensorID, numSgws, materialId, ...) exist too, as 0 and empty.
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

    def __init__(self, buffer: np.ndarray | None = None, arrays: Mapping[str, Any] | None = None) -> None:
        """arrays: those of the elements, where the buffer is a header only."""
        record = np.zeros(1, HEADER)[0] if buffer is None else buffer[: HEADER.itemsize].view(HEADER)[0]
        fields: dict[str, Any] = {name: int(record[name]) for name in INTEGER_FIELDS}
        fields["magicNumber"] = MAGIC if buffer is None else int(record["magicNumber"])
        fields |= {name: kind(int(record[name])) for name, kind in ENUM_FIELDS.items()}
        fields |= {name: FrameAtTime(record[name]) for name in ("frameStart", "frameEnd")}
        fields["modelToAppTransform"] = _locked(np.array(record["modelToAppTransform"]))
        fields["scanComplete"] = bool(record["scanComplete"])
        fields["azimuthOffset"] = float(record["azimuthOffset"])
        fields |= {name: record[name].item() for name in OTHER_SCALARS}
        self.__dict__.update(fields, _arrays=dict(arrays or {}))
        if buffer is not None and arrays is None:
            self._read_arrays(buffer)

    _arrays: dict[str, Any]

    def _read_arrays(self, buffer: np.ndarray) -> None:
        buffer = _locked(buffer.view())
        count = self.numElements
        aux = [name for name, bit in AUX_ARRAYS.items() if bit in self.filledAuxMembers]
        offsets, size = layout_of(count, aux)
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
        raise UnknownAttributeError(name, self)

    def __repr__(self) -> str:
        kind, frame = self.modality.name, self.frameOfReference.name
        return (
            f"<GenericModelOutput {kind} frame {self.frameId} at {self.timestampNs} ns: {self.numElements} elements, "
            f"{self.elementsCoordsType.name} in {frame}>"
        )

    def _repr_html_(self) -> str:
        html: str = import_module("sensors.writers.showing").model_output_html(self)
        return html

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *ELEMENT_ARRAYS, "timeOffSetNs", *AUX_ARRAYS, *OTHER_ARRAYS]


def parse_generic_model_output_data(data: Any) -> GenericModelOutput:
    """Reads a GenericModelOutput buffer: an ndarray (any dtype, read as bytes), bytes, or one of our handles. What was
    read already, such as `get_data(device="cuda")` of it, is returned as it is.

    None, a buffer that is too short, a wrong magic number (normal before a sensor's first frame) or another layout
    version gives a warning and an empty GenericModelOutput with `numElements` 0, never an exception. Arrays are
    read-only views of the buffer, which may itself be read-only. Integers are opaque handles of this process
    (`sensors.handles`), never addresses: an unknown one gives the same warning.
    """
    if isinstance(data, GenericModelOutput):
        return data
    if isinstance(data, (int, np.integer)):
        from sensors.handles import resolve

        found = resolve(int(data))
        if isinstance(found, Frame):
            return GenericModelOutput(pack(found))
        if not isinstance(found, np.ndarray):
            return _empty(f"{int(data)} is not a buffer handle; pass the array itself (addresses are never read)")
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
    if array.dtype.hasobject:
        raise ValueError(f"a {type(data).__name__} holds no bytes")
    return array.reshape(-1).view(np.uint8)


def _empty(reason: str) -> GenericModelOutput:
    warnings.warn(f"empty GenericModelOutput: {reason}", RuntimeWarning, stacklevel=3)
    return GenericModelOutput()


def getMagicNumberGMO() -> int:
    """The number every buffer starts with."""
    return MAGIC
