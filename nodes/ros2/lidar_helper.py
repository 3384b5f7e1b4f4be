"""Publishes a lidar's frames: attaches a writer to a render product once; from then on each frame is published."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, NodeAtLoad, node_type
from graph.sim import settings as keys
from nodes.fitting_sensors import check_fit

from .debug_view import debug_view
from .driver_clouds import DRIVER_CLOUDS, METADATA, driver_cloud
from .frame_ids import frame_ids
from .frame_publisher import STAMP_INPUTS, PointPublisher, detach, product_of, publish_with, stamp_notes, warn_of_inputs
from .frame_writers import FrameWriter, stamps
from .laser_scans import LASER_SCAN, scan_style
from .lidar_frames import GRID_CHANNELS, FrameScan, Grids, cloud_channels, frame_cloud, grid_shape
from .messages import STRING, class_labels, object_id_map
from .point_clouds import CLOUD_FIELDS, POINT_CLOUD
from .publishing import check_names, publisher_inputs, topic_name

if TYPE_CHECKING:
    from graph.sim.renderer.products import RenderProduct
    from graph.sim.renderer.sensor import Sensor
    from sensors.frame import Frame

_MESSAGES = {"laser_scan": LASER_SCAN, "point_cloud": POINT_CLOUD}


def _tilted(prim: Any) -> Iterator[str]:
    """Why a laser scan cannot be made of a prim's lidar; "" if it can, and for other prims."""
    from graph.base.errors import UserError
    from sensors.lidar.flat_scan import require_level_beams
    from sensors.lidar.names import MODALITY
    from sensors.lidar.prim import read_config
    from sensors.sensor_types import prim_types_of

    if not prim or prim.GetTypeName() not in prim_types_of(MODALITY):
        return
    config = read_config(prim)
    try:
        require_level_beams(str(prim.GetPath()), config)
    except UserError as error:
        yield str(error)


def _check(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    """Checks names as for every publisher, and reports unknown quantities and laser scans of a tilted lidar."""
    from graph.base.errors import UserError
    from graph.sim.scene.prim_paths import prim_at
    from sensors.lidar.names import PRIM_TYPE

    yield from check_names(node)
    yield from check_fit(node, PRIM_TYPE)
    if "selectedMetadata" in node.given:
        for problem in _unknown_quantities(node.db.inputs.selectedMetadata):
            yield "selectedMetadata", problem
    for problem in _contradictory_fields(node.db.inputs):
        yield "fields", problem
    if node.db.inputs.organized and not node.db.connected("inputs:type") and node.db.inputs.type == "laser_scan":
        yield "organized", "organized is for clouds; set type to point_cloud, or leave it out"
    bins = node.settings.get(keys.SCAN_BINS)
    if bins or node.db.connected("inputs:type") or node.db.inputs.type != "laser_scan":
        return
    for path in node.sensors:
        try:
            problems = list(_tilted(prim_at(node.stage, path)))
        except UserError:  # reported at the prim
            continue
        yield from (("", problem) for problem in problems)


def _notes(db: Database) -> Iterator[tuple[str, str, str]]:
    if db.inputs.fullScan == db.app.settings.get(keys.FULL_SCAN_WARNS):  # reported only if its value has an effect
        message = "fullScan has no effect; partial scans come from tickRate or accumulateOutputs"
        yield "fullScan", "full-scan-deprecated", message
    yield from stamp_notes(db)


@node_type(
    "isaacsim.ros2.bridge.ROS2RtxLidarHelper",
    version=3,
    needs=(("renderProductPath",),),
    check=_check,
    notes=_notes,
    inputs={
        "execIn": Attribute("execution", "attaches the publisher to the product; later activations find it attached"),
        "enabled": Attribute("bool", "if not, nothing is published and what was attached is taken off", default=True),
        **publisher_inputs("scan", frame_id="sim_lidar"),
        "renderProductPath": Attribute("token", "path of the lidar's render product", role="product"),
        "type": Attribute(
            "token", "what to publish", default="laser_scan", allowed_tokens=("laser_scan", "point_cloud")
        ),
        **STAMP_INPUTS,
        "fullScan": Attribute(
            "bool",
            "without effect",
            default=True,
            deprecated="whole scans come from tickRate = scanRateBaseHz",
            warns_itself=True,
        ),
        "showDebugView": Attribute(
            "bool", "draw each cloud into a PNG file, in the folder debug_view of the run's --out", default=False
        ),
        "frameSkipCount": Attribute(
            "uint",
            "frames left out between two messages",
            default=0,
            unit="frames",
            deprecated="lower the sensor's tickRate",
            warns_itself=True,
        ),
        "selectedMetadata": Attribute(
            "token[]", f"quantities of a cloud besides x, y, z: {', '.join(CLOUD_FIELDS)}", default=[]
        ),
        "fields": Attribute(
            "token",
            "a driver whose field names, offsets and types a cloud has, instead of selectedMetadata; the stamp is the "
            "first firing, and times count from it",
            default="",
            allowed_tokens=("", *DRIVER_CLOUDS),
        ),
        "organized": Attribute(
            "bool",
            "lay a cloud out as an image: a row for each line from the lowest up, a column for each firing; NaN where "
            "nothing came back",
            default=False,
        ),
        "enableObjectIdMap": Attribute("bool", "publish which prim each object id stands for"),
        "objectIdMapTopicName": Attribute("string", "topic of that map", default="object_id_map"),
    },
    memory=PointPublisher,
    release=detach,
    message_type=lambda db: _MESSAGES.get(db.inputs.type, ""),
    further_topics=lambda db: {"objectIdMapTopicName": STRING} if db.inputs.enableObjectIdMap else {},
)
def rtx_lidar_helper(db: Database) -> bool:
    """Publish every frame of a lidar's render product as PointCloud2 or LaserScan.

    Settings are read when the publisher is attached; a new product path attaches it again. A cloud's fields are
    x, y, z and those of selectedMetadata that the sensor delivers. The stamp is the time that the frame's pose belongs
    to (of a laser scan: of its first ray), so that a transform as of the stamp is right.
    """
    from sensors.lidar.names import PRIM_TYPE

    if not db.inputs.enabled:
        detach(db)
        return False
    product = product_of(db, PRIM_TYPE, "not-a-lidar")
    if product is None:
        return False
    if product is not db.memory.product:
        detach(db)
        if not _attach(db, product):
            return False
    db.memory.listen(db.app.bus)
    return True


def _attach(db: Database, product: RenderProduct) -> bool:
    from sensors.lidar.names import CORE_API
    from sensors.lidar.prim import is_lidar

    app, inputs, memory = db.app, db.inputs, db.memory
    if not is_lidar(app.stage.GetPrimAtPath(product.camera_path)):
        db.warn("not-a-lidar", f"{product.camera_path} has not the schema {CORE_API}; nothing is published")
        return False
    kind = inputs.type
    if kind not in _MESSAGES:
        db.fail(f"input type is {kind!r}; it must be one of {', '.join(_MESSAGES)}")
    if kind == "laser_scan" and not app.settings.get(keys.SCAN_BINS):
        for problem in _tilted(app.stage.GetPrimAtPath(product.camera_path)):
            db.fail(problem)
    warn_of_inputs(db, _notes(db))
    for problem in _contradictory_fields(inputs):
        db.fail(problem)
    metadata: tuple[str, ...] = ()
    if kind == "point_cloud":
        metadata = METADATA if inputs.fields else _metadata(db, product)
        _check_lines(db, product, metadata)
    if "Time" in metadata:
        _warn_of_nominal_times(db, product)
    memory.product, memory.demand = product, _needs(db, kind, metadata)
    for writer in _writers(db, product, kind, metadata):
        publish_with(db, product, writer)
    memory.view = debug_view(db, product, "RtxSensorDebugDrawPointCloud", "omni:sensor:Core:outputFrameOfReference")
    return True


def _metadata(db: Database, product: RenderProduct) -> tuple[str, ...]:
    """The chosen quantities that the sensor measures. Fails the node for an unknown name."""
    from sensors.sensor_types import sensor_types

    names = tuple(db.inputs.selectedMetadata)
    for problem in _unknown_quantities(names):
        db.fail(f"selectedMetadata: {problem}")
    measured = sensor_types()[product.sensor.type_name].measures
    strange = [name for name in names if CLOUD_FIELDS[name].channel not in measured]
    if strange:
        db.warn("metadata-not-measured", f"selectedMetadata: a lidar measures no {', '.join(strange)}; it is left out")
    return tuple(name for name in names if name not in strange)


def _contradictory_fields(inputs: Any) -> Iterator[str]:
    """Why a driver's fields cannot be published, if so."""
    if not inputs.fields:
        return
    if inputs.fields not in DRIVER_CLOUDS:
        yield f'no driver "{inputs.fields}"; there are {", ".join(DRIVER_CLOUDS)}'
    elif inputs.type == "laser_scan":
        yield "fields is for clouds; set type to point_cloud, or leave it empty"
    elif len(inputs.selectedMetadata):
        yield f"fields {inputs.fields} fixes the fields of the cloud; leave selectedMetadata empty"


def _unknown_quantities(names: Iterable[str]) -> Iterator[str]:
    from graph.base.suggest import did_you_mean

    for name in names:
        if name not in CLOUD_FIELDS:
            near = did_you_mean(name, CLOUD_FIELDS, f"there are {', '.join(CLOUD_FIELDS)}")
            yield f'no quantity "{name}"{near}'


def _warn_of_nominal_times(db: Database, product: RenderProduct) -> None:
    """Warns of a frozen scan of a moving lidar: it shows one instant, but its points' times are those of a scan."""
    app = db.app
    if app.fidelity.lidar_motion == "frozen" and product.is_frozen and app.fabric.body_of(product.camera_path):
        db.warn(
            "frozen-times-nominal",
            f"{product.camera_path} moves and lidar.motion is frozen: a scan shows one instant, its field time is "
            "nominal; do not deskew by it, or use --fidelity lidar.motion=continuous",
        )


def _writers(db: Database, product: RenderProduct, kind: str, metadata: tuple[str, ...]) -> list[FrameWriter]:
    """The writers of each frame: scans or clouds and, on request, the map of object ids."""
    inputs, app = db.inputs, db.app
    camera = product.camera_path
    every = inputs.frameSkipCount + 1
    topic = topic_name(db, camera)
    times = {"system_time": inputs.useSystemTime, "reset_on_stop": inputs.resetSimulationTimeOnStop}
    if kind == "laser_scan":
        scan = FrameScan(inputs.frameId, scan_style(app))
        return [FrameWriter(app.bus, topic, LASER_SCAN, stamps(app, **times, first_ray=scan.first_ray), scan, every)]
    stamp = stamps(app, **times, from_start=bool(inputs.fields))
    make = _cloud_maker(db, product, metadata)
    writers = [FrameWriter(app.bus, topic, POINT_CLOUD, stamp, make, every)]
    if "ClassId" in metadata:
        make_labels = partial(_labels_message, product.sensor)
        writers.append(FrameWriter(app.bus, f"{topic}_labels", STRING, stamp, make_labels, every))
    if inputs.enableObjectIdMap:
        from sensors.channels import STABLE_IDS

        if "ObjectId" in metadata and app.settings.get(STABLE_IDS, False):
            topic = topic_name(db, camera, inputs.objectIdMapTopicName)
            make = partial(_ids_message, product.sensor)
            writers.append(FrameWriter(app.bus, topic, STRING, stamp, make, every))
        else:
            db.warn(
                "object-id-map-unavailable",
                f"enableObjectIdMap needs ObjectId in selectedMetadata and {STABLE_IDS}: true; no map is published",
            )
    return writers


def _cloud_maker(db: Database, product: RenderProduct, metadata: tuple[str, ...]) -> Callable[[Frame, int], Any]:
    """Frame and stamp -> cloud, as the inputs ask for it."""
    driver, grids = db.inputs.fields, Grids() if db.inputs.organized else None
    ids = frame_ids(db, product, "sim_lidar")

    def make(frame: Frame, at: int) -> Any:
        grid = None if grids is None else grids.of(frame)
        if driver:
            return driver_cloud(frame, driver, at, ids.of(frame), grid)
        return frame_cloud(frame, metadata, at, ids.of(frame), grid)

    return make


def _ids_message(sensor: Sensor, frame: Any, at: int) -> Any:
    return object_id_map(sensor.object_ids(), at)


def _labels_message(sensor: Sensor, frame: Any, at: int) -> Any:
    return class_labels(sensor.class_labels(), at)


def _needs(db: Database, kind: str, metadata: tuple[str, ...]) -> dict[object, tuple[frozenset[str], bool]]:
    """Owner -> the channels to request, and whether also those above the prim's auxiliary level."""
    if kind == "laser_scan":
        from sensors.lidar.flat_scan import FLAT_SCAN_CHANNELS

        return {db.path: (FLAT_SCAN_CHANNELS, False)}
    return {db.path: (cloud_channels(metadata) | (GRID_CHANNELS if db.inputs.organized else frozenset()), False)}


def _check_lines(db: Database, product: RenderProduct, metadata: tuple[str, ...]) -> None:
    """Fails the node for a lidar whose lines cannot be numbered, or laid out as an image, where that is asked."""
    from graph.base.errors import UserError
    from sensors.lidar.lines import lines_of
    from sensors.lidar.prim import read_config

    config = read_config(db.app.stage.GetPrimAtPath(product.camera_path))
    try:
        if "Ring" in metadata:
            lines_of(config).check(product.camera_path)
        if db.inputs.organized:
            grid_shape(config, product.camera_path)
    except UserError as error:
        db.fail(str(error))
