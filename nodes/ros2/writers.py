"""The writers of Replicator that publish ROS 2 messages, by the product's names: what the helper nodes attach.

    writer = rep.writers.get("RtxLidarROS2PublishPointCloud")
    writer.initialize(topicName="points", frameId="lidar", outputIntensity=True)
    writer.attach([product])

Options are the inputs of the helper node; a cloud also takes output<Quantity> flags, and a scan the columns
that the product's helper reads from the prim. A writer requests what it publishes as long as it is attached, with or
without subscribers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

from graph.base.records import dataclass, field
from graph.sim import entered
from sensors.errors import SensorValueError
from sensors.writers import AnnotatedWriter, WriterSpec

if TYPE_CHECKING:
    from collections.abc import Sequence

    from graph.node import Database
    from graph.sim.app import App
    from graph.sim.renderer.products import RenderProduct

BRIDGE = "isaacsim.ros2.bridge"
LIDAR, RADAR = f"{BRIDGE}.ROS2RtxLidarHelper", f"{BRIDGE}.ROS2RtxRadarHelper"
CAMERA, INFO = f"{BRIDGE}.ROS2CameraHelper", f"{BRIDGE}.ROS2CameraInfoHelper"
OWN = ("execIn", "enabled", "renderProductPath", "type", "useSystemTime", "showDebugView", "srtxCompressionType")
"""Inputs of helpers that writers do not take."""


@dataclass(frozen=True, slots=True)
class _Kind:
    """One writer: its helper node, the default topic, fixed inputs, further options with their defaults, and what
    attaches it: (db, options) -> None.
    """

    helper: str
    topic: str
    fixed: Mapping[str, Any] = field(default_factory=dict)
    more: Mapping[str, Any] = field(default_factory=dict)
    attach: Callable[[Database, Mapping[str, Any]], None] | None = None


class _Hand:
    """What a helper node's compute uses of its `Database`, without a graph."""

    def __init__(self, name: str, kind: _Kind, options: Mapping[str, Any]) -> None:
        from graph.node import UNSET, registry

        self.path, self.node = name, SimpleNamespace(type=registry.get(kind.helper))
        inputs = self.node.type.inputs
        known = [one for one in inputs if one not in OWN] + list(kind.more)
        for option in options:
            if option not in known:
                from graph.base.suggest import did_you_mean

                hint = did_you_mean(option, known, f"it has {', '.join(known)}")
                raise ValueError(f"it has no option {option!r}{hint}")
        values = {one: "" if attribute.default is UNSET else attribute.default for one, attribute in inputs.items()}
        self.options = {**kind.more, **options}
        self.inputs = SimpleNamespace(**{**values, "topicName": kind.topic, **kind.fixed, **options})
        self.memory = self.node.type.memory()
        self.app: App = cast("App", None)

    def connected(self, name: str) -> bool:
        return False

    def warn(self, code: str, message: str) -> None:
        self.app.warn(code, self.path, message)

    def fail(self, message: str) -> None:
        raise SensorValueError(f"writer {self.path}: {message}")

    lack = fail


class Ros2Writer(AnnotatedWriter):
    """Publishes each frame of the product that it is attached to."""

    def __init__(self, name: str, kind: _Kind, **options: Any) -> None:
        """Raises ValueError for unknown options."""
        self._kind, self._hand = kind, _Hand(name, kind, options)

    def attach_to(self, product: RenderProduct) -> None:
        """Attaches the publisher to a product. Raises SensorValueError for another kind of sensor, and wrong values."""
        hand, kind = self._hand, self._kind
        hand.app = entered.of_world(product.scene)
        hand.inputs.renderProductPath = product.path
        db = cast("Database", hand)
        try:
            (kind.attach or _compute)(db, hand.options)
        except BaseException:
            hand.memory.detach()
            raise
        if hand.memory.product is not product:
            raise SensorValueError(f"writer {hand.path} cannot publish {product.camera_path}: it is of another type")
        hand.memory.request(True)

    def release(self) -> None:
        """Ends publishing."""
        self._hand.memory.detach()

    def __call__(self, frame: Any) -> None:
        """Nothing: the publisher is attached itself."""


def _compute(db: Database, options: Mapping[str, Any]) -> None:
    db.node.type.compute(db)


def _cloud(db: Database, options: Mapping[str, Any]) -> None:
    """A lidar's cloud, with the quantities of its flags after those of selectedMetadata."""
    flagged = [name.removeprefix("output") for name in _FLAGS if options[name]]
    db.inputs.selectedMetadata = [*dict.fromkeys([*db.inputs.selectedMetadata, *flagged])]
    _compute(db, options)


def _scan(db: Database, options: Mapping[str, Any]) -> None:
    """A lidar's scan of its own beams; or, with a `horizontalResolution`, of the columns that the options give."""
    _compute(db, options)
    if not any(options[name] for name in ("horizontalFov", "horizontalResolution")):
        return
    from sensors.lidar.flat_scan import Columns

    columns = Columns(
        float(options["horizontalFov"]),
        float(options["horizontalResolution"]),
        _pair(db, "depthRange", options),
        float(options["rotationRate"]),
        _pair(db, "azimuthRange", options),
    )
    for problem in columns.problems():
        db.fail(problem)
    for _, writer in db.memory.writers:
        writer.make.columns = columns


def _pair(db: Database, name: str, options: Mapping[str, Any]) -> tuple[float, float]:
    low, high = _numbers(db, name, options[name], 2)
    return low, high


def _info(db: Database, options: Mapping[str, Any]) -> None:
    """The lens of the camera; or, with a `k`, the parameters that the options give."""
    if options["k"] is None or len(options["k"]) == 0:
        return _compute(db, options)
    from .camera_helper import camera_product
    from .frame_publisher import publish_with
    from .frame_writers import FrameWriter, stamps
    from .image_messages import CAMERA_INFO, camera_info
    from .publishing import topic_name

    product, inputs = camera_product(db), db.inputs
    if product is None:
        return None
    sizes = {"k": 9, "r": 9, "p": 12}
    k, r, p = (_numbers(db, name, options[name], size) for name, size in sizes.items())
    r = r or [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    p = p or [*k[:3], 0.0, *k[3:6], 0.0, *k[6:], 0.0]
    model = options["physicalDistortionModel"] or options["projectionType"] or "plumb_bob"
    coefficients = list(options["physicalDistortionCoefficients"]) or [0.0] * 5
    size = options["width"] or product.resolution[0], options["height"] or product.resolution[1]
    stamp = stamps(db.app, system_time=inputs.useSystemTime, reset_on_stop=inputs.resetSimulationTimeOnStop)
    topic = topic_name(db, product.camera_path)

    def make(frame: Any, at: int) -> Any:
        return camera_info(at, inputs.frameId, size, (model, coefficients), k, r, p)

    db.memory.product = product
    publish_with(db, product, FrameWriter(db.app.bus, topic, CAMERA_INFO, stamp, make, gate="camera_info"))
    return None


def _numbers(db: Database, name: str, values: Sequence[float], count: int) -> list[float]:
    """The values as floats; a table, such as an array of one row, is read row by row."""
    import numpy as np

    found = np.ravel(np.asarray(values, float)).tolist()
    if len(found) not in (0, count):
        db.fail(f"{name} has {len(found)} values; it needs {count}, row by row")
    return found


def _labels(db: Database, options: Mapping[str, Any]) -> None:
    """What the numbers in images and boxes of a camera stand for."""
    from sensors.annotators.annotator import Annotator
    from sensors.annotators.registry import find_annotator

    from .camera_helper import camera_product
    from .camera_messages import MESSAGES, labels_message

    product = camera_product(db)
    if product is None:
        return
    annotator = Annotator(find_annotator(MESSAGES[db.inputs.type].annotator), app=db.app, owner=db.path, copies=False)
    db.memory.product, db.memory.annotator = product, annotator
    _text(db, product, lambda frame, at: labels_message(annotator.get_data(), at))


def _ids(db: Database, options: Mapping[str, Any]) -> None:
    """Which prim each object id of a lidar's points stands for."""
    from sensors.channels import STABLE_IDS
    from sensors.lidar.names import PRIM_TYPE

    from .frame_publisher import product_of
    from .messages import object_id_map

    product = product_of(db, PRIM_TYPE, "not-a-lidar")
    if product is None:
        return
    if not db.app.settings.get(STABLE_IDS, False):
        db.fail(f"object ids are off; set {STABLE_IDS}: true before play")
    db.memory.product, sensor = product, product.sensor
    _text(db, product, lambda frame, at: object_id_map(sensor.object_ids(), at))


def _text(db: Database, product: RenderProduct, make: Callable[[Any, int], Any]) -> None:
    from .frame_publisher import publish_with
    from .frame_writers import FrameWriter, stamps
    from .messages import STRING
    from .publishing import topic_name

    inputs = db.inputs
    stamp = stamps(db.app, system_time=inputs.useSystemTime, reset_on_stop=inputs.resetSimulationTimeOnStop)
    topic = topic_name(db, product.camera_path)
    publish_with(db, product, FrameWriter(db.app.bus, topic, STRING, stamp, make))


_QUANTITIES = (
    *("Intensity", "Timestamp", "EmitterId", "ChannelId", "MaterialId", "TickId", "HitNormal", "Velocity", "ObjectId"),
    *("EchoId", "TickState", "Ring", "Time", "ClassId"),
)
_FLAGS = tuple(f"output{name}" for name in _QUANTITIES)
_COLUMNS = {
    **{"horizontalFov": 0.0, "horizontalResolution": 0.0, "depthRange": (0.0, 0.0)},
    **{"rotationRate": 0.0, "azimuthRange": (0.0, 0.0)},
}
_LENS = {
    **{"width": 0, "height": 0, "projectionType": "", "k": (), "r": (), "p": ()},
    **{"physicalDistortionModel": "", "physicalDistortionCoefficients": ()},
}
_SEEN = {
    "InstanceSegmentation": "instance_segmentation",
    "SemanticSegmentation": "semantic_segmentation",
    "BoundingBox2DTight": "bbox_2d_tight",
    "BoundingBox2DLoose": "bbox_2d_loose",
    "BoundingBox3D": "bbox_3d",
}
"""What a camera sees, by the name in writers -> `type` of the camera helper."""


def _kinds() -> Iterator[tuple[str, _Kind]]:
    """(name with {} for ROS2 or ROS2SystemTime, writer)."""
    cloud = _Kind(LIDAR, "point_cloud", {"type": "point_cloud"}, dict.fromkeys(_FLAGS, False), _cloud)
    yield "RtxLidar{}PublishPointCloud", cloud
    yield "RtxLidar{}PublishPointCloudBuffer", cloud
    yield "RtxLidar{}PublishLaserScan", _Kind(LIDAR, "scan", {"type": "laser_scan"}, _COLUMNS, _scan)
    yield "RtxRadar{}PublishPointCloud", _Kind(RADAR, "radar_point_cloud")
    yield "LdrColor{}PublishImage", _Kind(CAMERA, "rgb", {"type": "rgb"})
    yield "LdrColor{}PublishCompressedImage", _Kind(CAMERA, "image_raw/compressed", {"type": "rgb_h264"})
    yield "DistanceToImagePlaneSD{}PublishImage", _Kind(CAMERA, "depth", {"type": "depth"})
    yield "DistanceToImagePlaneSD{}PublishPointCloud", _Kind(CAMERA, "depth_pcl", {"type": "depth_pcl"})
    for name, kind in _SEEN.items():
        yield "{}Publish" + name, _Kind(CAMERA, kind, {"type": kind})
        yield name + "SD{}PublishSemanticLabels", _Kind(CAMERA, "labels", {"type": kind}, attach=_labels)
    yield "{}PublishCameraInfo", _Kind(INFO, "camera_info", more=_LENS, attach=_info)
    yield "{}PublishObjectIdMap", _Kind(LIDAR, "object_id_map", attach=_ids)


def _spec(name: str, kind: _Kind, *, system_time: bool) -> WriterSpec:
    fixed = {**kind.fixed, "useSystemTime": system_time, "resetSimulationTimeOnStop": not system_time}
    made = _Kind(kind.helper, kind.topic, fixed, kind.more, kind.attach)
    return WriterSpec(partial(Ros2Writer, name, made), channels=frozenset())


WRITERS: Mapping[str, WriterSpec] = {
    name.format(bridge): _spec(name.format(bridge), kind, system_time=bridge != "ROS2")
    for bridge in ("ROS2", "ROS2SystemTime")
    for name, kind in _kinds()
}
"""Name in the registry -> writer."""
