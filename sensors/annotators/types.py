"""Every annotator, by its name in Replicator's registry: the channels that it reads and the data that it gives."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import UserError
from graph.base.suggest import did_you_mean
from sensors.channels import AuxLevel
from sensors.errors import SensorValueError
from sensors.gmo import channels_for, pack
from sensors.sensor_types import prim_types_of, sensor_types

from .outputs import EXTRACT_CHANNELS, empty_outputs, extract_point_cloud
from .times import reference_time, simulation_time, system_time

if TYPE_CHECKING:
    from graph.sim import App
    from graph.sim.renderer.rendering import RenderProduct
    from graph.sim.renderer.sensor import Sensor
    from sensors.frame import Frame


@dataclass(slots=True)
class Reading:
    """The input of an annotator: a frame of a render product (None before the first), and the options."""

    app: App
    product: RenderProduct
    options: Mapping[str, Any]
    frame: Frame | None = None

    @property
    def sensor(self) -> Sensor:
        """The sensor behind the product."""
        return self.product.sensor


@dataclass(frozen=True, slots=True)
class AnnotatorType:
    """One kind of annotator.

    read: returns the data of `get_data` for a `Reading`; called once for each frame. channels: the channels it needs.
    optional: also requests the auxiliary channels, as far as the prim's level includes them. options: those of
    `initialize`, with their defaults. modality: the sensors that it can read; "" is any that measures its channels.
    keeps_last: a frame without elements changes nothing. check: raises UserError for a product that it cannot read.
    instead: the replacement of a deprecated annotator.
    """

    name: str
    read: Callable[[Reading], Any]
    channels: Callable[[Reading], Iterable[str]] = lambda reading: ("xyz",)
    optional: bool = False
    options: Mapping[str, Any] = field(default_factory=dict)
    modality: str = ""
    keeps_last: bool = False
    check: Callable[[Reading], None] = lambda reading: None
    instead: str = ""

    def checked_options(self, options: Mapping[str, Any]) -> dict[str, Any]:
        """All options: the given ones, and defaults for the rest. Raises SensorValueError for an unknown option."""
        for name in options:
            if name not in self.options:
                there_are = f"it has {', '.join(self.options)}" if self.options else "it has none"
                hint = did_you_mean(name, self.options, there_are)
                raise SensorValueError(f"{self.name} has no option {name!r}{hint}")
        return {**self.options, **options}


TYPES: dict[str, AnnotatorType] = {}
"""Those for every sensor, and those that users registered; sensor types add their own."""


def annotator_types() -> dict[str, AnnotatorType]:
    """Every annotator by its name."""
    return TYPES | {one.name: one for kind in sensor_types().values() for one in kind.annotators}


def register_annotator(kind: AnnotatorType) -> None:
    """Adds an annotator to the registry. Raises SensorValueError if its name is taken."""
    if kind.name in annotator_types():
        raise SensorValueError(f"there is an annotator {kind.name!r} already; give yours another name")
    TYPES[kind.name] = kind


def find_annotator(name: str) -> AnnotatorType:
    """The annotator of this name. Raises SensorValueError with a similar name, or with all names."""
    known = annotator_types()
    if name not in known:
        hint = did_you_mean(name, known, f"there are: {', '.join(sorted(known))}")
        raise SensorValueError(f"there is no annotator {name!r}{hint}")
    return known[name]


def with_info(found: dict[str, Any], reading: Reading) -> dict[str, Any]:
    """Adds descriptions of the arrays."""
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
    return with_info(extract_point_cloud(frame) if frame is not None else empty_outputs(("data",)), reading)


def _stable_id_map(reading: Reading) -> np.ndarray | None:
    return None if reading.frame is None else reading.sensor.packed_object_ids()


def _say_stable_ids(reading: Reading) -> None:
    """Warns at once if the map will be missing."""
    reading.sensor.has_stable_ids()


def _semantic_classes(reading: Reading) -> dict[str, Any]:
    data = np.empty(0, np.uint32) if reading.frame is None else reading.frame.channel("classId")
    labels = {str(number): dict(found) for number, found in reading.sensor.class_labels().items()}
    return {"data": data, "info": {"idToLabels": labels}}


for _kind in (
    AnnotatorType(
        "GenericModelOutput",
        lambda reading: None if reading.frame is None else pack(reading.frame),
        lambda reading: channels_for(AuxLevel.NONE, reading.sensor.coords),
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
    AnnotatorType("ReferenceTime", reference_time, lambda reading: ()),
    AnnotatorType("IsaacReadSimulationTime", simulation_time, lambda reading: (), options={"resetOnStop": True}),
    AnnotatorType("IsaacReadSystemTime", system_time, lambda reading: ()),
):
    TYPES[_kind.name] = _kind


def check_product(kind: AnnotatorType, reading: Reading) -> None:
    """Raises SensorValueError, with prim and annotator, for a product that the annotator cannot read."""
    path = reading.product.camera_path
    prim_type = str(reading.app.stage.GetPrimAtPath(path).GetTypeName()) if path else ""
    readable = prim_types_of(kind.modality)
    if prim_type not in readable:
        what, where = prim_type or "not a sensor", path or reading.product.path
        raise SensorValueError(f"{kind.name}: {where} is {what}; it reads {' or '.join(readable)} only")
    try:
        kind.check(reading)
    except UserError as error:
        raise SensorValueError(f"{kind.name}: {error}") from error
