"""The Cartesian points of a sensor's frame, with all quantities of the frame."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type

from .buffers import BUFFERS, cloud_attributes, write_buffers
from .frames import CUDA_DEVICE, DATA_PTR, EXEC, RENDER_PRODUCT, Reader, attach, cloud_channels, read_frame, release


def _wanted(db: Database) -> frozenset[str]:
    """The channels of the outputs that something reads."""
    consumed = [name for name in BUFFERS if db.consumed(f"{name}Ptr") or db.consumed(f"{name}BufferSize")]
    return cloud_channels(db, consumed)


def _prepare(db: Database) -> None:
    attach(db, _wanted)


@node_type(
    "isaacsim.sensors.rtx.nodes.OgnIsaacExtractRTXSensorPointCloud",
    version=1,
    needs=(("renderProductPath", "dataPtr"),),
    inputs={
        "exec": EXEC,
        "dataPtr": Attribute("uint64", DATA_PTR),
        "cudaDeviceIndex": CUDA_DEVICE,
        "renderProductPath": RENDER_PRODUCT,
    },
    outputs=cloud_attributes("m"),
    memory=Reader,
    release=release,
    prepare=_prepare,
)
def extract_point_cloud(db: Database) -> bool:
    """Give a frame's points in metres; without points every output is reset.

    `azimuthPtr`, `elevationPtr`, `distancePtr` are the frame's spherical coordinates [deg, deg, m].
    """

    from sensors.annotators import outputs

    frame = read_frame(db, _wanted)
    if frame is None or frame.count == 0:
        write_buffers(db, {})
        return False
    cloud = outputs.extract_point_cloud(frame)
    write_buffers(db, cloud)
    db.fire("exec")
    return True
