"""Every annotator there is, by its name in Replicator's registry: what it reads of a sensor, what it hands out."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import UserError

from .annotators import (
    EXTRACT_CHANNELS,
    FLAT_SCAN_CHANNELS,
    SCAN_BUFFER_CHANNELS,
    FlatScan,
    empty_outputs,
    extract_point_cloud,
    flat_scan,
    require_2d,
    scan_buffer,
)
from .channels import AuxLevel
from .errors import SensorValueError
from .gmo import channels_for, pack

if TYPE_CHECKING:
    from graph.sim import App
    from graph.sim.renderer.rendering import RenderProduct

    from .frame import Frame

LIDAR, RADAR = "OmniLidar", "OmniRadar"


@dataclass(slots=True)
class Reading:
    """What an annotator reads from: a frame of a render product (None before the first), and its options."""

    app: App
    product: RenderProduct
    options: Mapping[str, Any]
    frame: Frame | None = None

    @property
    def sensor(self) -> Any:
        """What measures, behind the product."""
        return self.product.sensor


@dataclass(frozen=True, slots=True)
class AnnotatorType:
    """One kind of annotator.

    read: what `get_data` gives of a reading; it is called once a frame. channels: what it needs.
    optional: asks for the auxiliary channels too, as far as the prim's level reaches. options: those of `initialize`,
    with their defaults. prims: types of prims it can read. keeps_last: a frame without elements changes nothing.
    check: raises UserError for a product it cannot work on. instead: what to use, where it is deprecated.
    """

    name: str
    read: Callable[[Reading], Any]
    channels: Callable[[Reading], Iterable[str]] = lambda reading: ("xyz",)
    optional: bool = False
    options: Mapping[str, Any] = field(default_factory=dict)
    prims: tuple[str, ...] = (LIDAR, RADAR)
    keeps_last: bool = False
    check: Callable[[Reading], None] = lambda reading: None
    instead: str = ""

    def checked_options(self, options: Mapping[str, Any]) -> dict[str, Any]:
        """All options, given ones over the defaults. Raises SensorValueError for one it does not have."""
        for name in options:
            if name not in self.options:
                near = difflib.get_close_matches(name, self.options, n=1)
                there_are = f"it has {', '.join(self.options)}" if self.options else "it has none"
                hint = f'did you mean "{near[0]}"?' if near else there_are
                raise SensorValueError(f"{self.name} has no option {name!r}; {hint}")
        return {**self.options, **options}


TYPES: dict[str, AnnotatorType] = {}
"""The registry."""


def register_annotator(kind: AnnotatorType) -> None:
    """Adds an annotator to the registry. Raises SensorValueError if its name is taken."""
    if kind.name in TYPES:
        raise SensorValueError(f"there is an annotator {kind.name!r} already; give yours another name")
    TYPES[kind.name] = kind


def find_annotator(name: str) -> AnnotatorType:
    """The annotator of this name. Raises SensorValueError with a name that is near, or those there are."""
    if name not in TYPES:
        near = difflib.get_close_matches(name, TYPES, n=1)
        hint = f'did you mean "{near[0]}"?' if near else f"there are: {', '.join(sorted(TYPES))}"
        raise SensorValueError(f"there is no annotator {name!r}; {hint}")
    return TYPES[name]


FLAGS = {f"output{name[0].upper()}{name[1:]}": name for name in SCAN_BUFFER_CHANNELS if name != "data"}
"""Option of IsaacCreateRTXLidarScanBuffer -> the output that it adds."""

NO_EFFECT = {
    "keepOnlyPositiveDistance": True,
    "transformPoints": False,
    "accuracyErrorAzimuthDeg": 0.0,
    "accuracyErrorElevationDeg": 0.0,
    "accuracyErrorPosition": (0.0, 0.0, 0.0),
    "enablePerFrameOutput": False,
    "cudaDeviceIndex": -1,
}
"""Options that the original has and does not read."""


def _with_info(found: dict[str, Any], reading: Reading) -> dict[str, Any]:
    """Adds what describes the arrays."""
    frame = reading.frame
    transform = found.pop("transform", np.eye(4))
    found["transform"] = transform.reshape(-1)
    found["info"] = {
        "transform": found["transform"],
        "width": len(found["data"]),
        "height": 1,
        "timestampNs": frame.timestamp_ns if frame is not None else 0,
        "renderProductPath": reading.product.path,
    }
    return found


def _extract(reading: Reading) -> dict[str, Any]:
    frame = reading.frame
    return _with_info(extract_point_cloud(frame) if frame is not None else empty_outputs(("data",)), reading)


def _wanted(options: Mapping[str, Any]) -> list[str]:
    return [name for flag, name in FLAGS.items() if options[flag]]


def _scan_channels(reading: Reading) -> set[str]:
    return {"xyz"}.union(*(SCAN_BUFFER_CHANNELS[name] for name in _wanted(reading.options)))


def _scan_buffer(reading: Reading) -> dict[str, Any]:
    names = _wanted(reading.options)
    if reading.frame is None:
        return _with_info(empty_outputs(("data", *names)), reading)
    return _with_info(scan_buffer(reading.frame, reading.app.meters_per_unit, names), reading)


def _flat_scan(reading: Reading) -> dict[str, Any]:
    flat = FlatScan() if reading.frame is None else flat_scan(reading.frame)
    return {
        "linearDepthData": flat.ranges,
        "intensitiesData": flat.intensities,
        "horizontalFov": flat.horizontal_fov,
        "horizontalResolution": flat.horizontal_resolution,
        "depthRange": np.array(flat.depth_range, np.float32),
        "rotationRate": flat.rotation_rate,
        "azimuthRange": np.array(flat.azimuth_range, np.float32),
        "numRows": flat.num_rows,
        "numCols": flat.num_cols,
    }


def _is_flat(reading: Reading) -> None:
    config = getattr(reading.sensor, "config", None)
    if config is not None:
        require_2d(reading.product.camera_path, config)


def _stable_id_map(reading: Reading) -> np.ndarray | None:
    return None if reading.frame is None else reading.sensor.packed_object_ids()


def _say_stable_ids(reading: Reading) -> None:
    """Warns at once where there will be no map."""
    reading.sensor.has_stable_ids()


def _semantic_classes(reading: Reading) -> dict[str, Any]:
    data = np.empty(0, np.uint32) if reading.frame is None else reading.frame.channel("classId")
    labels = {str(number): dict(found) for number, found in reading.sensor.class_labels().items()}
    return {"data": data, "info": {"idToLabels": labels}}


for _kind in (
    AnnotatorType(
        "GenericModelOutput",
        lambda reading: None if reading.frame is None else pack(reading.frame),
        lambda reading: channels_for(AuxLevel.NONE, reading.sensor.config.elements_coords_type),
        optional=True,
    ),
    AnnotatorType(
        "StableIdMap",
        _stable_id_map,
        lambda reading: (),
        check=_say_stable_ids,
    ),
    AnnotatorType("SemanticClasses", _semantic_classes, lambda reading: ("classId",)),
    AnnotatorType("IsaacExtractRTXSensorPointCloud", _extract, lambda reading: EXTRACT_CHANNELS, optional=True),
    AnnotatorType(
        "IsaacExtractRTXSensorPointCloudNoAccumulator",
        _extract,
        lambda reading: EXTRACT_CHANNELS,
        optional=True,
        instead="IsaacExtractRTXSensorPointCloud",
    ),
    AnnotatorType(
        "IsaacCreateRTXLidarScanBuffer",
        _scan_buffer,
        _scan_channels,
        options={**dict.fromkeys(FLAGS, False), **NO_EFFECT},
        prims=(LIDAR,),
        keeps_last=True,
        instead="IsaacExtractRTXSensorPointCloud",
    ),
    AnnotatorType(
        "IsaacComputeRTXLidarFlatScan",
        _flat_scan,
        lambda reading: FLAT_SCAN_CHANNELS,
        prims=(LIDAR,),
        keeps_last=True,
        check=_is_flat,
        instead="IsaacExtractRTXSensorPointCloud, or ROS2RtxLidarHelper with type laser_scan",
    ),
):
    register_annotator(_kind)


def check_product(kind: AnnotatorType, reading: Reading) -> None:
    """Raises SensorValueError, naming prim and annotator, where a product is not for this kind of annotator."""
    path = reading.product.camera_path
    prim_type = str(reading.app.stage.GetPrimAtPath(path).GetTypeName()) if path else ""
    if prim_type not in kind.prims:
        what, where = prim_type or "no sensor", path or reading.product.path
        raise SensorValueError(f"{kind.name}: {where} is {what}; it reads {' or '.join(kind.prims)} only")
    try:
        kind.check(reading)
    except UserError as error:
        raise SensorValueError(f"{kind.name}: {error}") from error
