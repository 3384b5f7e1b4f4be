"""Publishes a radar's frames: attaches a writer to a render product once, then the frames publish themselves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from graph.node import Attribute, Database, NodeAtLoad, node_type
from nodes.fitting_sensors import check_fit

from .debug_view import debug_view
from .frame_ids import frame_ids
from .frame_publisher import STAMP_INPUTS, PointPublisher, detach, product_of, publish_with, stamp_notes, warn_of_inputs
from .frame_writers import FrameWriter, stamps
from .lidar_frames import cloud_channels, frame_cloud
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


def _check(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    from sensors.radar.names import PRIM_TYPE

    yield from check_names(node)
    yield from check_fit(node, PRIM_TYPE)


@node_type(
    "isaacsim.ros2.bridge.ROS2RtxRadarHelper",
    check=_check,
    notes=stamp_notes,
    inputs={
        "execIn": Attribute("execution", "attaches the publisher to the product; later activations find it attached"),
        "enabled": Attribute("bool", "if not, nothing is attached; what is attached goes on", default=True),
        **publisher_inputs("radar_point_cloud", frame_id="sim_radar"),
        "renderProductPath": Attribute("token", "path of the radar's render product", role="product"),
        "showDebugView": Attribute(
            "bool", "draw each cloud into a PNG file, in the folder debug_view of the run's --out", default=False
        ),
        **STAMP_INPUTS,
        "outputRadialVelocityMS": Attribute(
            "bool", "add radial_velocity_ms [m/s], positive where a detection recedes; needs level BASIC", default=False
        ),
        "outputIntensity": Attribute("bool", "add intensity, the radar cross section [dBsm]", default=False),
        "outputTimestamp": Attribute(
            "bool", "add the absolute time of each detection [ns], in two words", default=False
        ),
    },
    memory=PointPublisher,
    release=detach,
    message_type=lambda db: POINT_CLOUD,
)
def rtx_radar_helper(db: Database) -> bool:
    """Publish the detections of every frame of a radar's render product as PointCloud2.

    The settings are read when the publisher is attached, once until stop; a new product path attaches it again. The
    stamp is the time of the update that rendered the frame, to which its pose belongs.
    """
    from sensors.radar.names import PRIM_TYPE

    if not db.inputs.enabled:
        return False
    product = product_of(db, PRIM_TYPE, "not-a-radar")
    if product is None:
        return False
    if product is not db.memory.product:
        detach(db)
        _attach(db, product)
    db.memory.listen(db.app.bus)
    return True


def _attach(db: Database, product: RenderProduct) -> None:
    app, inputs, memory = db.app, db.inputs, db.memory
    warn_of_inputs(db, stamp_notes(db))
    fields = tuple(name for option, name in _FIELDS.items() if getattr(inputs, option))
    stamp = stamps(app, system_time=inputs.useSystemTime, reset_on_stop=inputs.resetSimulationTimeOnStop)
    ids = frame_ids(db, product, "sim_radar")
    memory.product, memory.demand = product, {db.path: (cloud_channels(fields), False)}
    topic = topic_name(db, product.camera_path)
    writer = FrameWriter(
        app.bus, topic, POINT_CLOUD, stamp, lambda frame, at: frame_cloud(frame, fields, at, ids.of(frame))
    )
    publish_with(db, product, writer)
    memory.view = debug_view(db, product, "RtxRadarDebugDrawPointCloud", "omni:sensor:WpmDmat:outputFrameOfReference")
