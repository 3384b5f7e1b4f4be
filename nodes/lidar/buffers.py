"""The output attributes that scan buffers and point clouds share: one buffer per quantity, passed on as a handle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graph.base.records import dataclass
from graph.node import UNSET, Attribute, Database

IDENTITY = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]


@dataclass(frozen=True, slots=True)
class Buffer:
    """One quantity: the type and default of its DataType attribute, and a description."""

    doc: str
    data_type: str
    default: Any
    pointer: Any = 0
    size: Any = UNSET


# Defaults are those of the original node, even where they have no meaning.
BUFFERS: Mapping[str, Buffer] = {
    "azimuth": Buffer("azimuths [deg], float32", "float", 4, UNSET),
    "elevation": Buffer("elevations [deg], float32", "float", 4, UNSET),
    "distance": Buffer("distances, float32", "float", 4, UNSET),
    "intensity": Buffer("normalised intensities, float32", "float", 0, 0, 0),
    "timestamp": Buffer("absolute times [ns], uint64", "uint64", 0),
    "emitterId": Buffer("emitter indices, uint32", "uint", 0),
    "channelId": Buffer("channels, uint32", "uint", 0),
    "materialId": Buffer("encoded non-visual materials, uint32", "uint", 0),
    "tickId": Buffer("tick indices, uint32", "uint", 0),
    "hitNormal": Buffer("unit surface normals, float32 x 3", "float[3]", [0, 0, 0]),
    "velocity": Buffer("velocities of the hit points [m/s], float32 x 3", "float[3]", [0, 0, 0]),
    "objectId": Buffer("128-bit object ids, uint8 x 16", "uint[]", [0, 0, 0, 0]),
    "echoId": Buffer("numbers of the return, uint8", "uchar", 0),
    "tickState": Buffer("emitter state indices, uint8", "uchar", 0),
    "radialVelocityMS": Buffer("radial velocities [m/s], float32; a radar's only", "float", 0),
}


def buffer_attributes(distance_unit: str) -> dict[str, Attribute]:
    """The Ptr, DataType and BufferSize attributes of every buffer; distance_unit: for their descriptions."""
    attributes: dict[str, Attribute] = {}
    for name, buffer in BUFFERS.items():
        doc = f"distances [{distance_unit}], float32" if name == "distance" else buffer.doc
        attributes[f"{name}Ptr"] = Attribute("uint64", f"handle of the {doc}; 0 means none", default=buffer.pointer)
        attributes[f"{name}DataType"] = Attribute(
            buffer.data_type,
            f"stands for the element type of {name}Ptr; its value means nothing",
            default=buffer.default,
        )
        attributes[f"{name}BufferSize"] = Attribute("uint64", f"size of {name}Ptr", default=buffer.size, unit="bytes")
    return attributes


def cloud_attributes(length_unit: str) -> dict[str, Attribute]:
    """The outputs of a cloud: points, transform, and every buffer. length_unit: of points and distances."""
    return {
        "exec": Attribute("execution", "follows when there is a cloud"),
        "dataPtr": Attribute("uint64", f"handle of the points [{length_unit}], float32 x 3; 0 means none"),
        "cudaDeviceIndex": Attribute("int", "always -1: the buffers are in host memory", default=-1),
        "bufferSize": Attribute("uint64", "size of dataPtr", unit="bytes"),
        "transform": Attribute("matrixd[4]", "sensor to world at the end of the frame, row vectors"),
        "width": Attribute("uint", "number of points", default=0),
        "height": Attribute("uint", "always 1", default=1),
        **buffer_attributes(length_unit),
    }


def write_buffers(db: Database, arrays: Mapping[str, Any]) -> None:
    """Puts arrays on `dataPtr` ("data") and `<name>Ptr`, with their sizes, and "transform" on its output.

    A missing array gives pointer 0 and size 0, a missing transform the identity.

    The handles of the previous frame are released, so that a node holds at most one frame.
    """
    from sensors.handles import handle

    drop_handles(db)
    outputs, handles = db.outputs, db.memory.handles
    for name in ("data", *BUFFERS):
        array = arrays.get(name)
        number, size = 0, 0
        if array is not None and array.size:
            number, size = handle(array), array.nbytes
            handles.append(number)
        setattr(outputs, f"{name}Ptr", number)
        setattr(outputs, "bufferSize" if name == "data" else f"{name}BufferSize", size)
    outputs.width, outputs.height = (len(arrays["data"]) if "data" in arrays else 0), 1
    outputs.cudaDeviceIndex, outputs.transform = -1, arrays.get("transform", IDENTITY)


def drop_handles(db: Database) -> None:
    """Releases the handles on the node's outputs."""
    from sensors.handles import forget

    while db.memory.handles:
        forget(db.memory.handles.pop())
