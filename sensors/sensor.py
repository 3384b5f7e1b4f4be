"""The user's handle of a rendered sensor of any modality: its render product, annotators and writers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar, cast

from graph.base.suggesting import Suggesting
from graph.sim.renderer.wrapper import unwrapped

from .annotators.annotator import Annotator, split_data
from .annotators.registry import ANNOTATORS, find_annotator
from .errors import SensorValueError
from .products import product_name, shared_product
from .writers import WRITERS, AttachedWriter, Writer, WriterSpec, find_writer, writer_specs

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.renderer.products import RenderProduct
    from graph.sim.renderer.view import WorldView

RESOLUTION = (300, 300)
"""Of the render products of sensors that measure no picture; it has no effect on what they measure."""

Authored = TypeVar("Authored")
Runtime = TypeVar("Runtime")


def check_names(
    annotators: Iterable[str], writers: Iterable[str], table: Mapping[str, Mapping[str, Any]] = ANNOTATORS
) -> None:
    """Raises SensorValueError for an unknown short name of an annotator or writer, before anything is authored.

    table: the annotators by their short names.
    """
    for name in annotators:
        _check_annotator(name, table)
    for name in writers:
        _writer_spec(name, WRITERS)


class RenderedSensor(Suggesting):
    """A sensor prim with a render product, and annotators and writers by their short names.

    Making it makes the product; a product made while playing ends at the stop. Raises SensorValueError (a UserError
    and a ValueError) for unknown names and prims.
    """

    annotator_specs: ClassVar[Mapping[str, dict[str, Any]]] = ANNOTATORS
    """Its annotators by their short names."""
    product_word: ClassVar[str] = "rtx_sensor"
    """The prefix of the names of its render products."""

    def __init__(
        self,
        scene: WorldView,
        path: str,
        resolution: tuple[int, int],
        annotators: Iterable[str] = (),
        writers: Iterable[str] = (),
    ) -> None:
        self.path = path
        self.scene = scene
        """The world of its prim."""
        self._annotator_table: dict[str, dict[str, Any]] = dict(self.annotator_specs)
        self._writer_table = dict(WRITERS)
        self._product = shared_product(scene, path, resolution, product_name(path, resolution, self.product_word))
        self._annotators: dict[str, Annotator] = {}
        self._writers: dict[str, AttachedWriter] = {}
        self.attach_annotators(annotators)
        for name in writers:
            self.attach_writer(name)

    @property
    def render_product(self) -> RenderProduct:
        """The render product. Raises RuntimeError after its removal (a stop removes products made while playing)."""
        if self._product.scene is None:
            raise RuntimeError(f"{self._product.path} is gone: a stop ended it; make a new {type(self).__name__}")
        return self._product

    @property
    def annotators(self) -> list[str]:
        """Names of the attached annotators, sorted."""
        return sorted(self._annotators)

    def get_data(self, annotator: str) -> tuple[Any, Mapping[str, Any]]:
        """(data, info) of an attached annotator; data is None before the first frame.

        Raises SensorValueError for a name that is unknown or not attached.
        """
        return split_data(self._attached(annotator).get_data())

    def _attached(self, annotator: str) -> Annotator:
        _check_annotator(annotator, self._annotator_table)
        if annotator not in self._annotators:
            raise SensorValueError(f"{self.path}: annotator {annotator!r} is not attached; attach it first")
        return self._annotators[annotator]

    def attach_annotators(self, annotators: str | Iterable[str]) -> dict[str, Annotator]:
        """Attaches annotators; a repeated name gets a new one. Returns name -> annotator."""
        names = short_names(annotators)
        for name in names:
            _check_annotator(name, self._annotator_table)
        for name in names:
            if name in self._annotators:
                self._annotators[name].detach()
            spec = self._annotator_table[name]
            annotator = Annotator(find_annotator(spec["name"]))
            annotator.initialize(**spec.get("defaults", {})).attach(self.render_product)
            self._annotators[name] = annotator
        return {name: self._annotators[name] for name in names}

    def detach_annotators(self, annotators: str | Iterable[str]) -> None:
        """Detaches annotators; a name that is not attached gives a warning."""
        for name in short_names(annotators):
            annotator = self._annotators.pop(name, None)
            if annotator is None:
                self.scene.warn("not-attached", f"{self.path}.{name}", f"annotator {name!r} is not attached")
            else:
                annotator.detach()

    def attach_writer(self, writer_name: str, **arguments: Any) -> Writer:
        """Attaches a writer: it gets every new frame. Arguments replace the table's defaults.

        writer_name: in the writer table, or in Replicator's registry (RtxSensorDebugDrawPointCloud).
        """
        spec = _writer_spec(writer_name, self._writer_table)
        if writer_name in self._writers:
            self.detach_writer(writer_name)
        attached = AttachedWriter(writer_name, spec).initialize(**arguments).attach(self.render_product)
        self._writers[writer_name] = attached
        assert attached.writer is not None
        return attached.writer

    def detach_writer(self, writer_name: str) -> None:
        """Detaches a writer; an unknown name gives a warning."""
        attached = self._writers.pop(writer_name, None)
        if attached is None:
            self.scene.warn("not-attached", f"{self.path}.{writer_name}", f"writer {writer_name!r} is not attached")
        else:
            attached.detach()


class PointSensor(RenderedSensor, Generic[Authored, Runtime]):
    """A rendered sensor that measures points or signals, over the object that authors its prim.

    path: such an object, or a path, which makes one on that prim, whose attributes stay as they are. The render product
    is 300 x 300, named rtx_sensor_<hash>; one made while playing ends at the stop. writers: names from the writer
    table. Raises SensorValueError (a UserError and a ValueError) for unknown names and prims.
    """

    authored_by: ClassVar[type[Any]]
    """The class of the object that authors the prim."""

    def __init__(
        self,
        path: Authored | str,
        *,
        annotators: str | Iterable[str] | None = None,
        writers: str | Iterable[str] | None = None,
        render_vars: Iterable[str] | None = None,
        app: App | None = None,
    ) -> None:
        annotators, writers = short_names(annotators), short_names(writers)
        check_names(annotators, writers)
        made: Any = path if isinstance(path, self.authored_by) else self.authored_by(path, app=app)
        self._authored: Authored = made
        self.render_vars = tuple(render_vars or ())
        super().__init__(made.scene, made.path, RESOLUTION, annotators, writers)

    def get_data(self, annotator: str, device: str | None = None) -> tuple[Any, Mapping[str, Any]]:
        """(data, info) of an attached annotator; data is None before the first frame.

        device: "cpu"; the App's device gives arrays that are still there, of a point cloud or a GenericModelOutput.
        Raises SensorValueError for a name that is unknown or not attached, and for data that is in host memory only.
        """
        return split_data(self._attached(annotator).get_data(device))

    @property
    def authoring_object(self) -> Authored:
        """The object that authors the prim."""
        return self._authored

    @property
    def runtime(self) -> Runtime:
        """The runtime behind the render product; also after the product was removed."""
        found: Any = unwrapped(self._product.sensor)
        return cast("Runtime", found)


def _writer_spec(name: str, table: Mapping[str, WriterSpec]) -> WriterSpec:
    known = writer_specs()
    return known[name] if name in known else find_writer(table, name)


def _check_annotator(name: str, table: Mapping[str, Any]) -> None:
    if name not in table:
        raise SensorValueError(f"there is no annotator {name!r}; there are: {', '.join(table)}")


def short_names(names: str | Iterable[str] | None) -> list[str]:
    """None, one name or several, as a list. Raises SensorValueError for anything else."""
    if names is None:
        return []
    listed = [names] if isinstance(names, str) or not isinstance(names, Iterable) else list(names)
    for name in listed:
        if not isinstance(name, str):
            raise SensorValueError(f"{name!r} is not a name; give one such as generic-model-output, or several")
    return listed
