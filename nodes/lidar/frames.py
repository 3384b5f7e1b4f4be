"""How an annotator node finds its frame and declares the channels that it reads."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass, field
from graph.node import Attribute, Database

from .buffers import drop_handles

if TYPE_CHECKING:
    from graph.sim.renderer.products import RenderProduct

EXEC = Attribute("execution", "computes; in a post_render graph every new frame of the product fires it")
DATA_PTR = "handle of a frame; unset or 0 means the newest frame of renderProductPath"
RENDER_PRODUCT = Attribute("token", "path of the render product whose frames are read", role="product")
CUDA_DEVICE = Attribute("int", "must stay -1: frames are in host memory", default=-1)


@dataclass(slots=True)
class Reader:
    """Memory of an annotator node: its product, the handles on its outputs, the warnings already given."""

    product: RenderProduct | None = None
    requested: bool = False
    handles: list[int] = field(default_factory=list)
    told: bool = False
    not_flat: bool = False


def attach(db: Database, channels: Callable[[Any], Iterable[str]]) -> RenderProduct | None:
    """The product of renderProductPath, None for an unknown one; the node's channels are requested of it while the
    node's outputs are read.
    """
    memory = db.memory
    path = db.inputs.renderProductPath
    product: RenderProduct | None = db.app.rendering.products.get(path) if path else None
    wanted = product is not None and db.is_read()
    if product is not memory.product or not wanted:
        detach(db)
        memory.product = product
    if wanted and product is not None and not memory.requested:
        product.sensor.require(db.path, channels(db))
        memory.requested = True
    return product


def cloud_channels(db: Database, names: Iterable[str]) -> frozenset[str]:
    """The channels for some outputs of a cloud, of the sensor that `attach` has found, as far as it measures them."""
    from sensors.annotators.outputs import channels_of
    from sensors.sensor_types import measures_of

    sensor = db.app.rendering.products[db.inputs.renderProductPath].sensor
    return channels_of(names, measures_of(sensor.type_name))


def detach(db: Database) -> None:
    """Withdraws the node's request."""
    memory = db.memory
    if memory.requested and memory.product is not None:
        memory.product.sensor.release(db.path)
    memory.product, memory.requested = None, False


def release(db: Database) -> None:
    """Withdraws the request and releases the handles, at a stop."""
    detach(db)
    drop_handles(db)


def read_frame(db: Database, channels: Callable[[Any], Iterable[str]]) -> Any:
    """The frame to work on: dataPtr's, else the product's newest, or None.

    Fails the node if neither is given, the product is unknown, or the frame is not in host memory.
    """
    inputs = db.inputs
    if inputs.cudaDeviceIndex != -1:
        db.fail(f"input cudaDeviceIndex is {inputs.cudaDeviceIndex}; frames are in host memory, leave it at -1")
    product = attach(db, channels)
    if inputs.dataPtr:
        return frame_of_handle(db, inputs.dataPtr)
    if product is not None:
        return product.frame
    what = f"there is no render product {inputs.renderProductPath}" if inputs.renderProductPath else "no frame to read"
    db.lack(f"{what}; connect renderProductPath to a render product")


def frame_of_handle(db: Database, handle: int) -> Any:
    """The frame that a handle refers to. Fails the node if the handle refers to something else."""
    from sensors.frame import Frame
    from sensors.handles import resolve

    frame = resolve(handle)
    if not isinstance(frame, Frame):
        db.lack("input dataPtr is not a handle of a frame; connect it to what makes one, or leave it unset")
    return frame


def read_lidar_frame(db: Database, channels: Callable[[Any], Iterable[str]]) -> Any:
    """As `read_frame`, for a node that reads only lidars: fails for any other sensor and names its prim."""
    from sensors.lidar.names import MODALITY
    from sensors.sensor_types import prim_types_of

    frame = read_frame(db, channels)
    product = db.memory.product
    path = frame.sensor_path if frame is not None else product.camera_path
    prim = db.app.stage.GetPrimAtPath(path) if path else None
    kind = str(prim.GetTypeName()) if prim else ""
    lidars = prim_types_of(MODALITY)
    if (frame is not None and frame.modality != MODALITY) or (kind and kind not in lidars):
        db.fail(
            f"{path} is {kind or 'no lidar'}; it reads {' or '.join(lidars)} only, IsaacExtractRTXSensorPointCloud "
            "reads both"
        )
    return frame


def say_deprecated(db: Database, instead: str) -> None:
    """Warns, once in each play, that the node type is deprecated."""
    if not db.memory.told:
        db.memory.told = True
        db.warn("node-deprecated", f"this node type is deprecated; use {instead}")
