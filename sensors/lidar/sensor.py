"""LidarSensor: a lidar at work, its render product, annotators and writers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from sensors.channels import AuxLevel
from sensors.errors import SensorValueError
from sensors.frame import Frame
from sensors.gmo import channels_for, pack
from sensors.ids import pack_stable_id_map
from sensors.products import render_product
from sensors.writers import WRITERS, Writer, find_writer

from .authoring import Lidar

if TYPE_CHECKING:
    from graph.sim import App
    from graph.sim.rendering import RenderProduct

    from .runtime import LidarRuntime

RESOLUTION = (300, 300)
ANNOTATORS: dict[str, str] = {"generic-model-output": "GenericModelOutput", "stable-id-map": "StableIdMap"}
"""Short name of an annotator -> its name in the registry."""


class LidarAnnotator:
    """One annotator attached to a sensor; `get_data` gives what the newest frame holds."""

    def __init__(self, sensor: LidarSensor, name: str) -> None:
        self.name = name
        self.registry_name = ANNOTATORS[name]
        self._sensor = sensor
        self._packed: tuple[Frame, np.ndarray] | None = None
        runtime = sensor.runtime
        self._owner = (id(self), name)
        if name == "generic-model-output":
            level = AuxLevel[sensor.lidar.aux_output_level]
            runtime.require(self._owner, channels_for(level, runtime.config.elements_coords_type))
        else:
            runtime.has_stable_ids()

    def get_data(self) -> np.ndarray | None:
        """The buffer of the newest frame, uint8; None before the first one. Between ticks the same buffer again."""
        frame = self._sensor.render_product.frame
        if frame is None:
            return None
        if self._packed is None or self._packed[0] is not frame:
            if self.name == "generic-model-output":
                self._packed = (frame, pack(frame))
            elif self._sensor.runtime.has_stable_ids():
                self._packed = (frame, pack_stable_id_map(self._sensor.runtime.object_ids()))
            else:
                return None
        return self._packed[1]

    def detach(self) -> None:
        """Ends the demand; the annotator gives no new data afterwards."""
        self._sensor.runtime.release(self._owner)


class LidarSensor:
    """Renders a lidar: `LidarSensor(lidar_or_path, annotators=["generic-model-output"])`.

    A path builds the Lidar with its defaults (aux NONE, accumulating) on that prim. The render product is 300 x 300,
    named rtx_sensor_<hash>; it exists from now on, and if made while playing until stop. writers: names from the
    writer table. Raises SensorValueError (a UserError and a ValueError) for unknown names and prims.
    """

    def __init__(
        self,
        lidar: Lidar | str,
        *,
        annotators: str | Iterable[str] | None = None,
        writers: str | Iterable[str] | None = None,
        render_vars: Iterable[str] | None = None,
        app: App | None = None,
    ) -> None:
        self._annotator_table = dict(ANNOTATORS)
        self._writer_table = dict(WRITERS)
        names, writer_names = _names(annotators), _names(writers)
        for name in names:
            self._check_annotator(name)
        for name in writer_names:
            find_writer(self._writer_table, name)
        self.lidar = lidar if isinstance(lidar, Lidar) else Lidar(lidar, app=app)
        self.render_vars = tuple(render_vars or ())
        self._app = self.lidar.app
        self._product = render_product(self._app, self.lidar.path, RESOLUTION)
        self._annotators: dict[str, LidarAnnotator] = {}
        self._writers: dict[str, Writer] = {}
        self.attach_annotators(names)
        for name in writer_names:
            self.attach_writer(name)

    @property
    def authoring_object(self) -> Lidar:
        """The Lidar."""
        return self.lidar

    @property
    def render_product(self) -> RenderProduct:
        """The render product. Raises RuntimeError once it is gone (a stop ends products made while playing)."""
        if self._app.rendering.products.get(self._product.path) is not self._product:
            raise RuntimeError(f"{self._product.path} is gone: a stop ended it; make a new LidarSensor")
        return self._product

    @property
    def runtime(self) -> LidarRuntime:
        """What measures, behind the render product; also after that is gone."""
        return cast("LidarRuntime", self._product.sensor)

    @property
    def annotators(self) -> list[str]:
        """Names of the attached annotators, sorted."""
        return sorted(self._annotators)

    def get_data(self, name: str) -> tuple[np.ndarray | None, Mapping[str, Any]]:
        """(data, info) of an attached annotator; data is None before the first frame.

        Raises SensorValueError for a name that is unknown or not attached.
        """
        self._check_annotator(name)
        if name not in self._annotators:
            raise SensorValueError(f"{self.lidar.path}: annotator {name!r} is not attached; attach it first")
        return self._annotators[name].get_data(), {}

    def attach_annotators(self, names: str | Iterable[str]) -> dict[str, LidarAnnotator]:
        """Attaches annotators; a name given again gets a fresh one. Returns name -> annotator."""
        names = _names(names)
        for name in names:
            self._check_annotator(name)
        for name in names:
            if name in self._annotators:
                self._annotators[name].detach()
            self._annotators[name] = LidarAnnotator(self, name)
        return {name: self._annotators[name] for name in names}

    def detach_annotators(self, names: str | Iterable[str]) -> None:
        """Detaches annotators; one that is not attached is a warning."""
        for name in _names(names):
            annotator = self._annotators.pop(name, None)
            if annotator is None:
                self._app.warn("not-attached", self.lidar.path, f"annotator {name!r} is not attached")
            else:
                annotator.detach()

    def attach_writer(self, name: str, **arguments: Any) -> Writer:
        """Attaches a writer of the table: it gets every new frame. Arguments beat the table's defaults."""
        spec = find_writer(self._writer_table, name)
        if name in self._writers:
            self.detach_writer(name)
        writer = spec.factory(**{**spec.defaults, **arguments})
        self.runtime.require((id(self), name), spec.channels)
        self.render_product.writers.append(writer)
        self._writers[name] = writer
        return writer

    def detach_writer(self, name: str) -> None:
        """Detaches a writer; an unknown name is a warning."""
        writer = self._writers.pop(name, None)
        if writer is None:
            self._app.warn("not-attached", self.lidar.path, f"writer {name!r} is not attached")
            return
        self.runtime.release((id(self), name))
        if writer in self._product.writers:
            self._product.writers.remove(writer)

    def _check_annotator(self, name: str) -> None:
        if name not in self._annotator_table:
            raise SensorValueError(f"there is no annotator {name!r}; there are: {', '.join(self._annotator_table)}")


def _names(names: str | Iterable[str] | None) -> list[str]:
    if names is None:
        return []
    return [names] if isinstance(names, str) else list(names)
