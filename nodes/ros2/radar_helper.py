"""Publishes a radar's frames: attaches a writer to a render product once, then the frames publish themselves."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, NodeAtLoad, node_type
from nodes.fitting_sensors import check_fit, misfit

from .debug_view import debug_view
from .lidar_frames import cloud_channels, frame_cloud
from .lidar_writers import FrameWriter, add_writer, stamps
from .point_clouds import POINT_CLOUD
from .publishing import check_names, publisher_inputs, topic_name

if TYPE_CHECKING:
    from graph.sim.renderer.products import RenderProduct

_FIELDS = {
    "outputIntensity": "Intensity",
    "outputTimestamp": "Timestamp",
    "outputRadialVelocityMS": "RadialVelocityMS",
}
"""Input -> the quantity of `CLOUD_FIELDS` that it adds."""


@dataclass(slots=True)
class _Attached:
    """What the node holds on to between attaching and stop."""

    product: RenderProduct | None = None
    writer: FrameWriter | None = None
    channels: frozenset[str] = frozenset()
    demanding: bool = False
    view: Any = None
    """The writer that draws the debug view."""


def _detach(db: Database) -> None:
    memory = db.memory
    if memory.product is None:
        return
    _demand(db, False)
    memory.product.writers[:] = [one for one in memory.product.writers if one is not memory.writer]
    if memory.view is not None:
        memory.view.detach()
    memory.product = memory.writer = memory.view = None


def _check(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    from sensors.radar.names import PRIM_TYPE

    yield from check_names(node)
    yield from check_fit(node, PRIM_TYPE)


@node_type(
    "isaacsim.ros2.bridge.ROS2RtxRadarHelper",
    check=_check,
    inputs={
        "execIn": Attribute("execution", "attaches the publisher to the product; later activations find it attached"),
        "enabled": Attribute("bool", "if not, nothing is attached; what is attached goes on", default=True),
        **publisher_inputs("radar_point_cloud", frame_id="sim_radar"),
        "renderProductPath": Attribute("token", "path of the radar's render product", role="product"),
        "resetSimulationTimeOnStop": Attribute(
            "bool", "stamp with the time since play; if not, with the time that no stop resets", default=True
        ),
        "showDebugView": Attribute(
            "bool", "draw each cloud into a PNG file, in the folder debug_view of the run's --out", default=False
        ),
        "useSystemTime": Attribute("bool", "stamp with the wall time of the last physics step", default=False),
        "outputRadialVelocityMS": Attribute(
            "bool", "add radial_velocity_ms [m/s], positive where a detection recedes; needs level BASIC", default=False
        ),
        "outputIntensity": Attribute("bool", "add intensity, the radar cross section [dBsm]", default=False),
        "outputTimestamp": Attribute(
            "bool", "add the absolute time of each detection [ns], in two words", default=False
        ),
    },
    memory=_Attached,
    release=_detach,
    message_type=lambda db: POINT_CLOUD,
)
def rtx_radar_helper(db: Database) -> bool:
    """Publish the detections of every frame of a radar's render product as PointCloud2.

    The settings are read when the publisher is attached, once until stop; a new product path attaches it again. The
    stamp is the time of the update that rendered the frame, to which its pose belongs.
    """
    inputs, memory = db.inputs, db.memory
    if not inputs.enabled:
        return False
    path = inputs.renderProductPath
    if not path:
        db.warn("render-product-missing", "renderProductPath is empty; connect it to a render product")
        return False
    product = memory.product
    if product is None or product.path != path or db.app.rendering.products.get(path) is not product:
        _detach(db)
        if not _attach(db, path):
            return False
    subscribed = db.app.bus.has_subscribers(memory.writer.topic)
    if subscribed != memory.demanding:
        _demand(db, subscribed)
    return True


def _attach(db: Database, path: str) -> bool:
    from graph.sim.scene.prim_paths import prim_at
    from sensors.radar.names import PRIM_TYPE

    app, inputs, memory = db.app, db.inputs, db.memory
    product = app.rendering.products.get(path)
    if product is None:
        db.fail(f"there is no render product {path}; connect renderProductPath to one")
    if problem := misfit(prim_at(app.stage, product.camera_path), product.camera_path, PRIM_TYPE):
        db.warn("not-a-radar", f"{problem}; nothing is published")
        return False
    if inputs.useSystemTime and inputs.resetSimulationTimeOnStop:
        db.warn(
            "system-time-never-resets",
            "useSystemTime stamps with wall time, which resetSimulationTimeOnStop cannot reset",
        )
    fields = tuple(name for option, name in _FIELDS.items() if getattr(inputs, option))
    stamp = stamps(app, system_time=inputs.useSystemTime, reset_on_stop=inputs.resetSimulationTimeOnStop)
    frame_id = inputs.frameId
    memory.product, memory.channels, memory.demanding = product, cloud_channels(fields), False
    memory.writer = FrameWriter(
        app.bus,
        topic_name(db, product.camera_path),
        POINT_CLOUD,
        stamp,
        lambda frame, at: frame_cloud(frame, fields, at, frame_id),
    )
    add_writer(db, product, memory.writer)
    memory.view = debug_view(db, product, "RtxRadarDebugDrawPointCloud", "omni:sensor:WpmDmat:outputFrameOfReference")
    return True


def _demand(db: Database, wanted: bool) -> None:
    """Requests the channels that the messages need, or withdraws the request."""
    memory = db.memory
    if wanted:
        memory.product.sensor.require(db.path, memory.channels)
    elif memory.demanding:
        memory.product.sensor.release(db.path)
    memory.demanding = wanted
