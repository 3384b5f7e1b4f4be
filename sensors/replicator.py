"""Render products, annotators and writers spelt as in omni.replicator.core: `import sensors.replicator as rep`.

    product = rep.create.render_product("/World/Lidar", (1024, 1024))
    buffer = rep.AnnotatorRegistry.get_annotator("IsaacCreateRTXLidarScanBuffer")
    buffer.initialize(outputTimestamp=True, outputIntensity=True)
    buffer.attach([product])
    writer = rep.writers.get("RtxSensorDebugDrawPointCloud")
    writer.initialize(size=0.05, output_dir="out/clouds")
    writer.attach([product])
    app.play()
    app.update(steps=12)  # or rep.orchestrator.step(), one update that pauses afterwards
    points = buffer.get_data()["data"]

Every function takes `app`; None is the App entered last. `sensors.annotators.types` has the annotators, with their
channels and options; `sensors.writers` the writers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from graph.sim import entered

from .annotators.annotator import Annotator, Product, check_device
from .annotators.registry import annotator_types, find_annotator, register_annotator
from .annotators.types import TYPES, AnnotatorType
from .errors import SensorValueError
from .orchestrator import Orchestrator
from .products import render_product
from .writers import REGISTRY, WriterSpec, writer_specs
from .writers import AnnotatedWriter as Writer
from .writers import get as get_writer

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.renderer.products import RenderProduct


def create_render_product(
    camera: Any, resolution: Sequence[int] = (1280, 720), *, name: str | None = None, app: App | None = None
) -> RenderProduct:
    """The render product of a sensor at a resolution (width, height); an equal one is reused.

    camera: path of a sensor prim, a prim, or an authoring object such as `Lidar`. Raises SensorValueError (a UserError
    and a ValueError) for a missing prim or another kind of prim.
    """
    path = camera.GetPath() if hasattr(camera, "GetPath") else getattr(camera, "path", camera)
    return render_product(app or entered.current(), str(path), resolution, name)


def get_annotator(
    name: str,
    init_params: Mapping[str, Any] | None = None,
    render_products: Product = None,
    device: str | None = None,
    do_array_copy: bool = True,
    *,
    app: App | None = None,
) -> Annotator:
    """A new annotator by its name in the registry; init_params: arguments of `initialize`.

    render_products: attaches it to this one. device: only the host has data ("cpu"). do_array_copy: whether data are
    your own, to write on. Raises SensorValueError for unknown names and options.
    """
    check_device(device)
    made = Annotator(find_annotator(name), app=app, copies=do_array_copy).initialize(**(init_params or {}))
    return made if render_products is None else made.attach(render_products)


class AnnotatorRegistry:
    """The registered annotators."""

    get_annotator = staticmethod(get_annotator)
    get = staticmethod(get_annotator)

    @staticmethod
    def get_registered_annotators() -> list[str]:
        """Their names, sorted."""
        return sorted(annotator_types())

    @staticmethod
    def register(kind: AnnotatorType) -> None:
        """Adds your own annotator. Raises SensorValueError if its name is taken."""
        register_annotator(kind)

    @staticmethod
    def unregister_annotator(name: str) -> None:
        """Removes an annotator; unknown ones are ignored."""
        TYPES.pop(name, None)


class WriterRegistry:
    """The registered writers."""

    get = staticmethod(get_writer)

    @staticmethod
    def get_writers() -> list[str]:
        """Their names, sorted."""
        return sorted(writer_specs())

    @staticmethod
    def register(writer: str | type[Writer], spec: WriterSpec | None = None) -> None:
        """Adds your own writer: a subclass of `Writer`, by its own name, or a name and a factory.

        Raises SensorValueError if the name is taken.
        """
        name = writer if isinstance(writer, str) else writer.__name__
        if spec is None:
            if isinstance(writer, str) or not issubclass(writer, Writer):
                raise SensorValueError(f"writer {name!r}: give a subclass of Writer, or a name and a WriterSpec")
            spec = WriterSpec(writer, channels=frozenset())
        if name in writer_specs():
            raise SensorValueError(f"there is a writer {name!r} already; give yours another name")
        REGISTRY[name] = spec

    @staticmethod
    def unregister_writer(name: str) -> None:
        """Removes a writer; unknown ones are ignored."""
        REGISTRY.pop(name, None)


class create:  # noqa: N801  (spelt as in omni.replicator.core)
    """`create.render_product`."""

    render_product = staticmethod(create_render_product)


annotators = AnnotatorRegistry
orchestrator = Orchestrator(lambda: entered.current().driver)
writers = WriterRegistry

__all__ = [
    "AnnotatorRegistry",
    "Writer",
    "WriterRegistry",
    "annotators",
    "create",
    "create_render_product",
    "get_annotator",
    "get_writer",
    "orchestrator",
    "writers",
]
