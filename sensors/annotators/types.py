"""Kinds of annotators by their names in Replicator's registry: the channels that each reads, the data that it gives."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.records import dataclass, field
from graph.base.suggest import did_you_mean
from sensors.channels import AuxLevel
from sensors.errors import SensorValueError
from sensors.frame import Frame
from sensors.gmo import channels_for, pack
from sensors.gmo.buffer import on_device as model_output_on_device

from .outputs import EXTRACT_CHANNELS, LABELS, cloud_on_device, empty_outputs, extract_point_cloud

if TYPE_CHECKING:
    from graph.sim.renderer.products import RenderProduct
    from graph.sim.renderer.sensor import Sensor
    from graph.sim.renderer.view import WorldView
    from graph.sim.timing.time_queries import TimeQueries
    from sensors.raycast.world import CastWorld


@dataclass(slots=True)
class Reading:
    """The input of an annotator: a frame of a render product (None before the first), and the options.

    times: the samples of simulation, monotonic and system time, which are looked up by the frame's time.
    """

    scene: WorldView
    times: TimeQueries
    product: RenderProduct
    options: Mapping[str, Any]
    frame: Frame | None = None

    @property
    def world(self) -> CastWorld:
        """The surfaces that frames show."""
        from sensors.raycast.shared import cast_world

        return cast_world(self.scene)

    @property
    def sensor(self) -> Sensor:
        """The sensor behind the product."""
        return self.product.sensor


def reference_time(reading: Reading) -> dict[str, int]:
    """The reference time for look-ups of the frame's own time; before the first frame 0/0, which means now."""
    numerator = denominator = 0
    if reading.frame is not None:
        numerator, denominator = reading.times.frame_key(reading.frame.reference).as_integer_ratio()
    return {"referenceTimeNumerator": numerator, "referenceTimeDenominator": denominator}


def simulation_time(reading: Reading) -> dict[str, float]:
    """The frame's simulation time [s].

    Without resetOnStop, the one that a stop does not reset; 0 before the first frame.
    """
    return {"simulationTime": _time(reading, "simulation" if reading.options["resetOnStop"] else "monotonic")}


def system_time(reading: Reading) -> dict[str, float]:
    """The wall clock [UNIX s] at the physics step that the frame shows; 0 before the first frame."""
    return {"systemTime": _time(reading, "system")}


def _time(reading: Reading, which: Any) -> float:
    return 0.0 if reading.frame is None else float(reading.times.of_frame(reading.frame.reference, which))


@dataclass(frozen=True, slots=True)
class AnnotatorType:
    """One kind of annotator.

    read: returns the data of `get_data` for a `Reading`; called once for each frame. channels: the channels it needs.
    optional: also requests the auxiliary channels, as far as the prim's level includes them. options: those of
    `initialize`, with their defaults. modality: the sensors that it can read; "" is any that measures its channels.
    keeps_last: a frame without elements changes nothing. check: raises UserError for a product that it cannot read.
    instead: the replacement of a deprecated annotator. on_device: returns the data of a frame on the
    App's device as arrays there; None: it is in host memory only.
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
    on_device: Callable[[Frame], Any] | None = None

    def checked_options(self, options: Mapping[str, Any]) -> dict[str, Any]:
        """All options: the given ones, and defaults for the rest. Raises SensorValueError for an unknown option."""
        for name in options:
            if name not in self.options:
                there_are = f"it has {', '.join(self.options)}" if self.options else "it has none"
                hint = did_you_mean(name, self.options, there_are)
                raise SensorValueError(f"{self.name} has no option {name!r}{hint}")
        return {**self.options, **options}


TYPES: dict[str, AnnotatorType] = {}
"""Those for every sensor, and those that users registered; `registry` adds those of sensor types."""


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
    found = empty_outputs(("data", *LABELS))
    return with_info(found if frame is None else {**found, **extract_point_cloud(frame)}, reading)


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
        on_device=model_output_on_device,
    ),
    AnnotatorType(
        "StableIdMap",
        _stable_id_map,
        lambda reading: (),
        check=_say_stable_ids,
    ),
    AnnotatorType("SemanticClasses", _semantic_classes, lambda reading: ("classId",)),
    AnnotatorType(
        "IsaacExtractRTXSensorPointCloud",
        _extract,
        lambda reading: EXTRACT_CHANNELS,
        optional=True,
        on_device=cloud_on_device,
    ),
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
