"""Writers by name: each receives every new frame of a render product."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any

from graph.base import plugins
from graph.base.suggest import did_you_mean
from sensors.annotators.annotator import Product, only_product
from sensors.channels import Consumer
from sensors.errors import SensorValueError
from sensors.sensor_types import sensor_types

from .annotated import AnnotatedWriter
from .basic import BasicWriter
from .spec import DEBUG_DRAW, REGISTRY, Writer, WriterSpec

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.renderer.products import RenderProduct


REGISTRY["BasicWriter"] = WriterSpec(BasicWriter, channels=frozenset())


def writer_specs() -> dict[str, WriterSpec]:
    """Every writer by its name in the registry: those for all sensors, of sensor types, and declared ones."""
    found = {**REGISTRY, **_declared()}
    for kind in sensor_types().values():
        found |= kind.writers
    return found


@cache
def _declared() -> dict[str, WriterSpec]:
    return {name: spec for _, declared in plugins.loaded(plugins.WRITERS, dict) for name, spec in declared.items()}


WRITERS: dict[str, WriterSpec] = {"draw-point-cloud": REGISTRY[DEBUG_DRAW]}
"""Short names; a sensor copies this table when it is created, so later entries reach only later sensors."""


def register_writer_spec(name: str, spec: WriterSpec | Mapping[str, Any]) -> None:
    """Makes the writer `name` available to sensors that are created from now on.

    spec: a `WriterSpec`, or {"name": name in the registry, "defaults": arguments}. Raises SensorValueError if the name
    is taken, or the registry has no such writer.
    """
    if name in WRITERS:
        raise SensorValueError(f"there is a writer {name!r} already; give yours another name")
    if isinstance(spec, Mapping):
        if "name" not in spec:
            raise SensorValueError(f'writer {name!r}: the spec needs "name", the writer\'s name in the registry')
        known = find_writer(writer_specs(), spec["name"])
        spec = replace(known, defaults={**known.defaults, **spec.get("defaults", {})})
    WRITERS[name] = spec


def unregister_writer_spec(name: str) -> None:
    """Removes a short name; unknown ones are ignored. Existing sensors keep it."""
    WRITERS.pop(name, None)


def find_writer(table: Mapping[str, WriterSpec], name: str) -> WriterSpec:
    """The writer of this name. Raises SensorValueError with a similar name, or with all names."""
    if name not in table:
        hint = did_you_mean(name, table, f"there are: {', '.join(sorted(table)) or 'none'}")
        raise SensorValueError(f"there is no writer {name!r}{hint}")
    return table[name]


class AttachedWriter:
    """A writer for a render product: `initialize(size=0.2).attach(product)`; `detach()` ends it."""

    def __init__(self, name: str, spec: WriterSpec, *, app: App | None = None) -> None:
        self.name = name
        self.spec = spec
        self.options = dict(spec.defaults)
        self.writer: Writer | None = None
        self._scene = None if app is None else app.world
        self._product: RenderProduct | None = None
        self._owner = Consumer(f"writer {name}")

    @property
    def product(self) -> RenderProduct | None:
        """The render product it is attached to."""
        return self._product

    def initialize(self, **options: Any) -> AttachedWriter:
        """Sets arguments in place of the defaults. Raises SensorValueError after it is attached."""
        if self._product is not None:
            raise SensorValueError(f"writer {self.name} is attached already; initialize it before attach")
        self.options.update(options)
        return self

    def attach(self, products: Product) -> AttachedWriter:
        """Attaches it to a render product (or a list of one): from now on it gets every new frame.

        Raises SensorValueError for wrong arguments, a product that does not exist, and if it is already attached.
        """
        _, product = only_product(products, self._scene, f"writer {self.name}")
        if self._product is not None:
            raise SensorValueError(f"writer {self.name} is attached to {self._product.path} already; detach it first")
        try:
            writer = self.spec.factory(**self.options)
        except (TypeError, ValueError) as error:
            raise SensorValueError(f"writer {self.name}: {error}") from error
        if not product.camera_path:
            raise SensorValueError(f"writer {self.name}: {product.path} renders no sensor yet; give it one first")
        product.sensor.require(self._owner, self.spec.channels)
        if isinstance(writer, AnnotatedWriter):
            try:
                writer.attach_to(product)
            except BaseException:
                product.sensor.release(self._owner)
                raise
        product.writers.append(writer)
        self._product, self.writer = product, writer
        return self

    def detach(self) -> None:
        """Detaches it; harmless if it is not attached."""
        product, self._product = self._product, None
        if product is None:
            return
        product.sensor.release(self._owner)
        if isinstance(self.writer, AnnotatedWriter):
            self.writer.release()
        if self.writer in product.writers:
            product.writers.remove(self.writer)

    def __getattr__(self, name: str) -> Any:
        """The writer's own attributes, after it was made."""
        writer = self.__dict__.get("writer")
        if writer is None or name.startswith("__"):
            raise AttributeError(f"writer {self.__dict__.get('name')} has no {name}; attach it first")
        return getattr(writer, name)


def get(name: str, init_params: Mapping[str, Any] | None = None, *, app: App | None = None) -> AttachedWriter:
    """A new writer by its name in the registry, or its short name. Raises SensorValueError for unknown names."""
    return AttachedWriter(name, find_writer({**WRITERS, **writer_specs()}, name), app=app).initialize(
        **(init_params or {})
    )
