"""`omni.replicator.core`: render products, annotators, writers, the orchestrator."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from graph.isaac.outcomes import inert, tell_inert
from graph.isaac.session import app, warn
from sensors import replicator as ours
from sensors.annotators.annotator import Annotator as OurAnnotator
from sensors.products import remove_product
from sensors.writers import AnnotatedWriter, AttachedWriter

from .replicator_augment import (
    Augmentation,
    augmentation_of,
    augmentations_default,
    changed,
    get_augmentation,
    register_augmentation,
)
from .replicator_draws import distribution, trigger, triggers
from .replicator_files import BackendDispatch, backends
from .replicator_functional import functional
from .replicator_orchestrator import orchestrator
from .replicator_prims import MISSING, Create, modify
from .replicator_random import get, new_layer, randomizer

__all__ = [
    "Annotator",
    "AnnotatorRegistry",
    "Augmentation",
    "BackendDispatch",
    "RenderProduct",
    "Writer",
    "WriterRegistry",
    "annotators",
    "augmentations_default",
    "backends",
    "create",
    "distribution",
    "functional",
    "get",
    "get_global_seed",
    "modify",
    "new_layer",
    "orchestrator",
    "randomizer",
    "rng",
    "set_global_seed",
    "settings",
    "trigger",
    "utils",
    "writers",
]


class HydraTexture:
    """A render product as scripts know it: its path, its prim's texture, its end."""

    def __init__(self, product: Any) -> None:
        self._product = product

    @property
    def path(self) -> str:
        return str(self._product.path)

    def __str__(self) -> str:
        return self.path

    @property
    def hydra_texture(self) -> HydraTexture:
        return self

    @property
    def updates_enabled(self) -> bool:
        return bool(self._product.enabled)

    @updates_enabled.setter
    def updates_enabled(self, enabled: bool) -> None:
        self._product.enabled = bool(enabled)

    def set_updates_enabled(self, updates_enabled: bool = True) -> None:
        self._product.enabled = bool(updates_enabled)

    def get_render_product_path(self) -> str:
        return self.path

    def destroy(self) -> None:
        remove_product(app().world, self._product)

    def GetPath(self) -> Any:
        return self.GetPrim().GetPath()

    def GetPrim(self) -> Any:
        return app().stage.GetPrimAtPath(self.path)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "sensor":  # only the product itself has that
            raise AttributeError(name)
        return getattr(self._product, name)


RenderProduct = HydraTexture


def _bare(products: Any) -> Any:
    """Products as our annotators and writers take them."""
    if isinstance(products, (list, tuple)):
        return [_bare(one) for one in products]
    if isinstance(products, HydraTexture):
        return products.path
    if hasattr(products, "GetPath"):
        return str(products.GetPath())
    return products


class _Create(Create):
    @staticmethod
    def render_product(
        camera: Any, resolution: Any = (1280, 720), force_new: bool = False, name: Any = None, **_: Any
    ) -> Any:
        if isinstance(camera, (list, tuple)):
            return [_Create.render_product(one, resolution, force_new, name) for one in camera]
        return HydraTexture(ours.create_render_product(camera, resolution, name=name))


create = _Create("omni.replicator.core.create", MISSING)


class Annotator(OurAnnotator):
    """An annotator that takes render products in every form."""

    def attach(self, render_products: Any, *_: Any, **__: Any) -> Any:  # type: ignore[override]
        return super().attach(_bare(render_products))

    def detach(self, render_products: Any = None) -> Any:
        return super().detach()

    def get_data(self, *args: Any, **named: Any) -> Any:
        """As Isaac Sim gives it: a coloured segmentation is (height, width) uint32, each the bytes of a colour."""
        named.pop("device", None), named.pop("do_array_copy", None)
        found = super().get_data(*args[:0])
        for change in self.__dict__.get("_augmented", ()):
            held = found["data"] if isinstance(found, dict) else found
            held = changed(held, change) if getattr(held, "size", 0) else held
            found = {**found, "data": held} if isinstance(found, dict) else held
        if not isinstance(found, dict) or not self.options.get("colorize") or found["data"].dtype != np.uint8:
            return found
        return {**found, "data": np.ascontiguousarray(found["data"]).view(np.uint32)[..., 0]}

    def augment(self, augmentation: Any, *_: Any, **options: Any) -> Annotator:
        """Changes the data of each frame by a function of NumPy arrays, or by the name of one."""
        self._augmented = [*self.__dict__.get("_augmented", ()), augmentation_of(augmentation, options)]
        return self

    def augment_compose(self, augmentations: Any, *_: Any, **__: Any) -> Annotator:
        """The same by several, one after the other."""
        for one in augmentations:
            self.augment(one)
        return self

    def augmented_again(self) -> Annotator:
        """Another annotator of the same name, with the same augmentations."""
        made: Annotator = get_annotator(self.name)
        made._augmented = list(self.__dict__.get("_augmented", ()))
        return made

    @property
    def template_name(self) -> str:
        return str(self.name)


def get_annotator(
    name: str,
    init_params: Any = None,
    render_products: Any = None,
    device: str | None = None,
    do_array_copy: bool = True,
) -> Any:
    if device not in (None, "cpu"):
        warn(
            "annotator-on-host", name, f"device {device!r}: its arrays are in host memory; .numpy() gives them as well"
        )
    if name in _REGISTERED:
        held = _REGISTERED[name].augmented_again()
        return held if render_products is None else held.attach(render_products)
    made = ours.get_annotator(_present(name), init_params, None, None, do_array_copy)
    made.__class__ = Annotator
    return made if render_products is None else made.attach(render_products)


def _present(name: str) -> str:
    """The name of an annotator of lidars in Isaac Sim 6; older ones began with the kind of the sensor."""
    tail = name.removeprefix("RtxSensorCpu").removeprefix("RtxSensorGpu")
    if tail == name or not tail.startswith("Isaac"):
        return name
    warn("isaac-old-name", name, f"Isaac Sim 6 has no such annotator; it stands for {tail}")
    return tail


_REGISTERED: dict[str, Annotator] = {}


def _annotator(given: Any) -> Any:
    return get_annotator(given) if isinstance(given, str) else given


class AnnotatorRegistry:
    get_annotator = staticmethod(get_annotator)
    get = staticmethod(get_annotator)
    get_registered_annotators = staticmethod(ours.AnnotatorRegistry.get_registered_annotators)
    get_registered = get_registered_annotators

    register_augmentation = staticmethod(register_augmentation)
    get_augmentation = staticmethod(get_augmentation)
    Augmentation = Augmentation

    @staticmethod
    def register(name: str, annotator: Any) -> None:
        _REGISTERED[name] = annotator

    @staticmethod
    def augment(source_annotator: Any, augmentation: Any, *_: Any, **options: Any) -> Any:
        return _annotator(source_annotator).augment(augmentation, **options)

    @staticmethod
    def augment_compose(source_annotator: Any, augmentations: Any, *_: Any, **__: Any) -> Any:
        return _annotator(source_annotator).augment_compose(augmentations)

    @staticmethod
    def register_annotator_from_node(name: str, *_: Any, **__: Any) -> None:
        tell_inert("omni.replicator.core.AnnotatorRegistry.register_annotator_from_node")


annotators = AnnotatorRegistry


class _Share(AnnotatedWriter):
    """One product's part of a script's writer that is attached to several."""

    def __init__(self, writer: Writer) -> None:
        self._writer, self.annotators = writer, [copy(one) for one in writer.annotators]

    def write(self, data: Any) -> None:
        assert self._product is not None
        self._writer.gather(self._product.path.rpartition("/")[2], data)


class Writer(AnnotatedWriter):
    """A writer of the script: `annotators`, and `write(data)` for each frame.

    Attached to several products it gets the data of all at once, by "annotator-product".
    """

    _given: dict[str, Any]
    _writers: list[Any]

    def __new__(cls, *_: Any, **__: Any) -> Any:
        made = super().__new__(cls)
        made.annotators = list(cls.annotators)  # a script appends to it
        return made

    def gather(self, product: str, data: Any) -> None:
        """Takes the data of one product; writes when each product has given its own."""
        if product in self._given:
            self._given = {}
        self._given[product] = data
        if len(self._given) < len(self._writers):
            return
        given, self._given = self._given, {}
        if self.data_structure == "renderProduct":
            self.write({"renderProducts": given})
        else:
            self.write({f"{name}-{one}": found for one, data in given.items() for name, found in data.items()})

    def initialize(self, **options: Any) -> Any:
        self.__init__(**options)  # type: ignore[misc]
        return self

    def attach(self, render_products: Any, trigger: Any = None) -> Any:
        from sensors.writers import WriterSpec

        self._writers, self._given = [], {}
        products = render_products if isinstance(render_products, (list, tuple)) else [render_products]
        for one in products:
            part = self if len(products) == 1 else _Share(self)
            made = AttachedWriter(type(self).__name__, WriterSpec(lambda part=part: part, channels=frozenset()))
            self._writers.append(made.attach([_bare(one)]))
        return self

    def detach(self) -> None:
        for one in getattr(self, "_writers", ()):
            one.detach()

    def on_final_frame(self) -> None:
        return None


class _AttachedWriter:
    """A writer of the registry; one for each product it is attached to."""

    def __init__(self, name: str, options: Any = None) -> None:
        self._name, self._options = name, dict(options or {})
        self._held: list[Any] = []
        self._added: list[Annotator] = []
        self._augmentations: list[tuple[str, Any]] = []
        ours.get_writer(name)  # an unknown name is an error now, not later

    def initialize(self, **options: Any) -> _AttachedWriter:
        backend = options.pop("backend", None)
        if backend is not None:
            options["output_dir"] = backend.output_dir
        self._options.update(options)
        return self

    def attach(self, render_products: Any, trigger: Any = None) -> _AttachedWriter:
        for one in render_products if isinstance(render_products, (list, tuple)) else [render_products]:
            made = ours.get_writer(self._name).initialize(**self._options)
            made.spec = replace(made.spec, factory=partial(self._prepared, made.spec.factory))
            self._held.append(made.attach([_bare(one)]))
        return self

    def _prepared(self, factory: Any, **options: Any) -> Any:
        """A writer whose annotators are augmented and joined by those that were added."""
        made = factory(**options)
        if isinstance(made, AnnotatedWriter):
            made.prepare = self._annotators
        return made

    def _annotators(self, given: list[Any]) -> list[Any]:
        added = {one.name: one.augmented_again() for one in self._added}
        out = [added.pop(one.name, one) for one in given]
        out += added.values()
        for name, change in self._augmentations:
            for one in out:
                if one.name == name:
                    one.__class__ = Annotator
                    one._augmented = [*one.__dict__.get("_augmented", ()), change]
        return out

    def add_annotator(self, annotator: Any) -> None:
        """Writes an annotator's data too, in place of the writer's own of the same name."""
        self._added.append(_annotator(annotator))

    def augment_annotator(self, annotator: Any, augmentation: Any, **options: Any) -> None:
        """Changes the data of one of the writer's annotators, from its next `attach` on."""
        name = annotator if isinstance(annotator, str) else annotator.name
        self._augmentations.append((name, augmentation_of(augmentation, options)))

    async def attach_async(self, render_products: Any, trigger: Any = None) -> _AttachedWriter:
        return self.attach(render_products)

    def detach(self) -> None:
        while self._held:
            self._held.pop().detach()

    @inert("omni.replicator.core")
    def get_node(self) -> Any:
        return None

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or not self._held:
            raise AttributeError(f"writer {self._name} has no {name}; attach it first")
        return getattr(self._held[0], name)


_OWN: dict[str, type[Writer]] = {}


class WriterRegistry:
    @staticmethod
    def get(name: str, init_params: Any = None, render_products: Any = None, trigger: Any = None) -> Any:
        if name in _OWN:
            made: Any = _OWN[name].__new__(_OWN[name])
            if init_params is not None:
                made.initialize(**init_params)
        else:
            made = _AttachedWriter(name, init_params)
        return made if render_products is None else made.attach(render_products)

    @staticmethod
    def register(writer: type[Writer], category: str | None = None) -> None:
        _OWN[writer.__name__] = writer

    @staticmethod
    def is_of_script(name: str) -> bool:
        """Whether a script has registered a writer of that name."""
        return name in _OWN

    @staticmethod
    def register_node_writer(name: str, *_: Any, **__: Any) -> None:
        tell_inert("omni.replicator.core.writers.register_node_writer")

    @staticmethod
    def get_writers() -> dict[str, Any]:
        return {name: name for name in (*ours.WriterRegistry.get_writers(), *_OWN)}

    get_registered = get_writers

    @staticmethod
    def unregister_writer(writer_name: str) -> None:
        _OWN.pop(writer_name, None)


writers = WriterRegistry


def set_global_seed(seed: int) -> None:
    triggers().seed = int(seed)


def get_global_seed() -> int:
    return triggers().seed


class ReplicatorRNG:
    """`generator`, a NumPy generator: the same numbers for the same seed, by default the global one."""

    def __init__(self, seed: int | None = None, **_: Any) -> None:
        self.seed = triggers().seed if seed is None else int(seed)
        self.generator = np.random.default_rng(self.seed)


class _Rng:
    ReplicatorRNG = ReplicatorRNG


rng = _Rng


class settings:  # noqa: N801
    @staticmethod
    def carb_settings(setting: str, value: Any) -> None:
        app().settings.set(setting, value)

    @staticmethod
    @inert("omni.replicator.core")
    def set_render_rtx_realtime(*_: Any, **__: Any) -> None:
        return None

    @staticmethod
    @inert("omni.replicator.core")
    def set_render_pathtraced(*_: Any, **__: Any) -> None: ...


class utils:  # noqa: N801
    @staticmethod
    def send_og_event(event_name: str) -> None:
        from graph.session.runner import graphs_of

        triggers().events.add(event_name)
        graphs_of(app()).context.events.send(f"bus:{event_name}", update=app().update_index)
