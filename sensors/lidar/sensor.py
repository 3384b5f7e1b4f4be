"""LidarSensor: a lidar at work, its render product, annotators and writers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, cast

from sensors.annotators.annotator import Annotator, split_data
from sensors.annotators.specs import ANNOTATORS
from sensors.annotators.types import find_annotator
from sensors.errors import SensorValueError
from sensors.products import render_product
from sensors.writers import REGISTRY, WRITERS, AttachedWriter, Writer, WriterSpec, find_writer

from .authoring import Lidar

if TYPE_CHECKING:
    from graph.sim import App
    from graph.sim.renderer.rendering import RenderProduct

    from .runtime import LidarRuntime

RESOLUTION = (300, 300)


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
        self._annotator_table: dict[str, dict[str, Any]] = dict(ANNOTATORS)
        self._writer_table = dict(WRITERS)
        names, writer_names = _names(annotators), _names(writers)
        for name in names:
            self._check_annotator(name)
        for name in writer_names:
            self._writer_spec(name)
        self.lidar = lidar if isinstance(lidar, Lidar) else Lidar(lidar, app=app)
        self.render_vars = tuple(render_vars or ())
        self._app = self.lidar.app
        self._product = render_product(self._app, self.lidar.path, RESOLUTION)
        self._annotators: dict[str, Annotator] = {}
        self._writers: dict[str, AttachedWriter] = {}
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

    def get_data(self, name: str) -> tuple[Any, Mapping[str, Any]]:
        """(data, info) of an attached annotator; data is None before the first frame.

        Raises SensorValueError for a name that is unknown or not attached.
        """
        self._check_annotator(name)
        if name not in self._annotators:
            raise SensorValueError(f"{self.lidar.path}: annotator {name!r} is not attached; attach it first")
        return split_data(self._annotators[name].get_data())

    def attach_annotators(self, names: str | Iterable[str]) -> dict[str, Annotator]:
        """Attaches annotators; a name given again gets a fresh one. Returns name -> annotator."""
        names = _names(names)
        for name in names:
            self._check_annotator(name)
        for name in names:
            if name in self._annotators:
                self._annotators[name].detach()
            spec = self._annotator_table[name]
            annotator = Annotator(find_annotator(spec["name"]), app=self._app)
            annotator.initialize(**spec.get("defaults", {})).attach(self.render_product)
            self._annotators[name] = annotator
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
        """Attaches a writer: it gets every new frame. Arguments beat the table's defaults.

        name: of the writer table, or of Replicator's registry (RtxSensorDebugDrawPointCloud).
        """
        spec = self._writer_spec(name)
        if name in self._writers:
            self.detach_writer(name)
        attached = AttachedWriter(name, spec, app=self._app).initialize(**arguments).attach(self.render_product)
        self._writers[name] = attached
        assert attached.writer is not None
        return attached.writer

    def detach_writer(self, name: str) -> None:
        """Detaches a writer; an unknown name is a warning."""
        attached = self._writers.pop(name, None)
        if attached is None:
            self._app.warn("not-attached", self.lidar.path, f"writer {name!r} is not attached")
        else:
            attached.detach()

    def _writer_spec(self, name: str) -> WriterSpec:
        return REGISTRY[name] if name in REGISTRY else find_writer(self._writer_table, name)

    def _check_annotator(self, name: str) -> None:
        if name not in self._annotator_table:
            raise SensorValueError(f"there is no annotator {name!r}; there are: {', '.join(self._annotator_table)}")


def _names(names: str | Iterable[str] | None) -> list[str]:
    if names is None:
        return []
    return [names] if isinstance(names, str) else list(names)
