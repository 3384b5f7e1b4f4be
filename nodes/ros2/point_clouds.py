"""`sensor_msgs/PointCloud2` messages: the layout of their fields, and the packing of arrays into points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass

from .messages import header

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

POINT_CLOUD = "sensor_msgs/msg/PointCloud2"

# sensor_msgs/PointField datatypes by NumPy format.
_DATATYPES = {"u1": 2, "<u2": 4, "<u4": 6, "<f4": 7}


@dataclass(frozen=True, slots=True)
class CloudField:
    """One selectable quantity of a cloud: the sensor channel behind it, its message fields, their NumPy format."""

    channel: str
    names: tuple[str, ...]
    format: str


# In the order of the fields in a point. Ring, Time and ClassId are our additions.
CLOUD_FIELDS: Mapping[str, CloudField] = {
    "Intensity": CloudField("scalar", ("intensity",), "<f4"),
    "Timestamp": CloudField("timeOffsetNs", ("timestamp_0", "timestamp_1"), "<u4"),
    "EmitterId": CloudField("emitterId", ("emitter_id",), "<u4"),
    "ChannelId": CloudField("channelId", ("channel_id",), "<u4"),
    "MaterialId": CloudField("matId", ("material_id",), "<u4"),
    "TickId": CloudField("tickId", ("tick_id",), "<u4"),
    "HitNormal": CloudField("hitNormals", ("nx", "ny", "nz"), "<f4"),
    "Velocity": CloudField("velocities", ("vx", "vy", "vz"), "<f4"),
    "ObjectId": CloudField("objId", ("object_id_0", "object_id_1", "object_id_2", "object_id_3"), "<u4"),
    "EchoId": CloudField("echoId", ("echo_id",), "u1"),
    "TickState": CloudField("tickStates", ("tick_state",), "u1"),
    "RadialVelocityMS": CloudField("rv_ms", ("radial_velocity_ms",), "<f4"),
    "Ring": CloudField("ring", ("ring",), "<u2"),
    "Time": CloudField("timeOffsetNs", ("time",), "<f4"),
    "ClassId": CloudField("classId", ("class_id",), "<u4"),
}


@dataclass(frozen=True, slots=True)
class CloudGrid:
    """The shape of an organised cloud, and the cell, row x width + column, of each point, (n,). Of several points of a
    cell the first stays; cells without one are NaN.
    """

    height: int
    width: int
    cells: NDArray[Any]


def point_cloud(
    points: NDArray[np.float32],
    values: Mapping[str, NDArray[Any]],
    nanoseconds: int,
    frame_id: str,
    grid: CloudGrid | None = None,
) -> Any:
    """A cloud with packed little-endian points, unordered (height 1) without a grid; dense if every coordinate is
    finite.

    points: (N, 3) x, y, z [m]. values: by name of `CLOUD_FIELDS`, each with N rows: Timestamp uint64 absolute [ns]
    (low word first in the message), HitNormal and Velocity (N, 3), ObjectId (N, 16) bytes or (N, 4) uint32,
    Time integers [ns] after the header's stamp (seconds in the message); the others (N,).
    A quantity whose array is empty while there are points is left out: the sensor did not deliver it.
    Raises ValueError if an array's length is not N.
    """
    import numpy as np

    count = len(points)
    columns: list[tuple[str, str, NDArray[Any]]] = []
    for name, field in CLOUD_FIELDS.items():
        if name in values and (values[name].size or not count):
            columns += zip(
                field.names, [field.format] * len(field.names), _split(name, field, values[name], count), strict=True
            )
    layout = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), *((name, form) for name, form, _ in columns)])
    if columns:
        packed = np.empty(count, layout)
        packed["x"], packed["y"], packed["z"] = points[:, 0], points[:, 1], points[:, 2]
        for name, _, column in columns:
            packed[name] = column
    else:
        packed = np.ascontiguousarray(points, dtype="<f4").reshape(-1).view(layout)
    return cloud_of(packed, points, nanoseconds, frame_id, grid)


def cloud_of(
    packed: NDArray[Any], points: NDArray[np.float32], nanoseconds: int, frame_id: str, grid: CloudGrid | None = None
) -> Any:
    """The message of points (n,) of a structured type with x, y, z, which are also `points` (n, 3)."""
    import numpy as np

    from graph.sim.messages.ros_types import message_type

    layout, step = packed.dtype, packed.dtype.itemsize
    dense = bool(np.isfinite(points).all())
    height, width = 1, len(packed)
    if grid is not None:
        height, width = grid.height, grid.width
        every = np.zeros(height * width, layout)
        every["x"] = every["y"] = every["z"] = np.nan
        every[grid.cells[::-1]] = packed[::-1]
        packed, dense = every, dense and len(np.unique(grid.cells)) == height * width
    field_type = message_type("sensor_msgs/msg/PointField")
    offsets: Mapping[str, Any] = layout.fields or {}
    fields = [
        field_type(name, offset, _DATATYPES[form], 1)
        for name, form, offset in ((n, _format(kind[0]), int(kind[1])) for n, kind in offsets.items())
    ]
    return message_type(POINT_CLOUD)(
        header(nanoseconds, frame_id),
        height,
        width,
        fields,
        False,
        step,
        step * width,
        packed.view(np.uint8).reshape(-1),
        dense,
    )


def _split(name: str, field: CloudField, array: NDArray[Any], count: int) -> list[NDArray[Any]]:
    """The columns of one quantity, one array per message field."""
    import numpy as np

    if name == "Timestamp":
        array = np.ascontiguousarray(array, dtype="<u8").view("<u4").reshape(-1, 2)
    elif name == "ObjectId":
        array = np.ascontiguousarray(array).view("<u4").reshape(-1, 4)
    elif name == "Time":
        array = np.asarray(array) * 1e-9
    if len(array) != count:
        raise ValueError(f"{name} has {len(array)} values for {count} points")
    return [array] if array.ndim == 1 else [array[:, i] for i in range(len(field.names))]


def _format(kind: Any) -> str:
    return "u1" if kind.itemsize == 1 else f"<{kind.kind}{kind.itemsize}"
