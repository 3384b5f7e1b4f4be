"""`omni.replicator.core`: render products, annotators, writers, the orchestrator."""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from itertools import count
from typing import Any

from graph.isaac.outcomes import inert, tell_inert
from graph.isaac.session import RUN, app, kit, warn
from graph.sim import settings as keys
from sensors import replicator as ours
from sensors.annotators.annotator import Annotator as OurAnnotator
from sensors.products import remove_product
from sensors.writers import AnnotatedWriter, AttachedWriter

from .replicator_draws import distribution, trigger, triggers
from .replicator_prims import MISSING, Create, functional, modify
from .replicator_random import get, new_layer, randomizer

__all__ = [
    "Annotator",
    "AnnotatorRegistry",
    "RenderProduct",
    "Writer",
    "WriterRegistry",
    "annotators",
    "create",
    "distribution",
    "functional",
    "get",
    "get_global_seed",
    "modify",
    "new_layer",
    "orchestrator",
    "randomizer",
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
        named.pop("device", None), named.pop("do_array_copy", None)
        return super().get_data(*args[:0])

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
    made = ours.get_annotator(_present(name), init_params, None, device, do_array_copy)
    made.__class__ = Annotator
    return made if render_products is None else made.attach(render_products)


def _present(name: str) -> str:
    """The name of an annotator of lidars in Isaac Sim 6; older ones began with the kind of the sensor."""
    tail = name.removeprefix("RtxSensorCpu").removeprefix("RtxSensorGpu")
    if tail == name or not tail.startswith("Isaac"):
        return name
    warn("isaac-old-name", name, f"Isaac Sim 6 has no such annotator; it stands for {tail}")
    return tail


class AnnotatorRegistry:
    get_annotator = staticmethod(get_annotator)
    get = staticmethod(get_annotator)
    get_registered_annotators = staticmethod(ours.AnnotatorRegistry.get_registered_annotators)
    get_registered = get_registered_annotators

    @staticmethod
    def register_annotator_from_node(name: str, *_: Any, **__: Any) -> None:
        tell_inert("omni.replicator.core.AnnotatorRegistry.register_annotator_from_node")


annotators = AnnotatorRegistry


class Writer(AnnotatedWriter):
    """A writer of the script: `annotators`, and `write(data)` for each frame."""

    def initialize(self, **options: Any) -> Any:
        self.__init__(**options)  # type: ignore[misc]
        return self

    def attach(self, render_products: Any, trigger: Any = None) -> Any:
        from sensors.writers import WriterSpec

        self._writers: list[Any] = []
        for one in render_products if isinstance(render_products, (list, tuple)) else [render_products]:
            made = AttachedWriter(type(self).__name__, WriterSpec(lambda: self, channels=frozenset()))
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
        ours.get_writer(name)  # an unknown name is an error now, not later

    def initialize(self, **options: Any) -> _AttachedWriter:
        self._options.update(options)
        return self

    def attach(self, render_products: Any, trigger: Any = None) -> _AttachedWriter:
        for one in render_products if isinstance(render_products, (list, tuple)) else [render_products]:
            made = ours.get_writer(self._name).initialize(**self._options)
            self._held.append(made.attach([_bare(one)]))
        return self

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


class _Status(Enum):
    NOT_STARTED = 0
    STARTING = 1
    STARTED = 2
    PAUSED = 3
    STOPPING = 4
    STOPPED = 5


class _Orchestrator:
    Status = _Status

    def __init__(self) -> None:
        self._status = _Status.NOT_STARTED
        self._looping = False
        """Whether a call of `run` is counting its frames."""

    def step(
        self,
        rt_subframes: int = -1,
        pause_timeline: bool = True,
        delta_time: float | None = None,
        wait_for_render: bool = True,
    ) -> None:
        run = RUN.get()
        if run is not None:
            run.check()
        app().orchestrator.step(rt_subframes, pause_timeline, delta_time, wait_for_render)
        kit().turn()

    async def step_async(
        self,
        rt_subframes: int = -1,
        pause_timeline: bool = True,
        delta_time: float | None = None,
        wait_for_render: bool = True,
    ) -> None:
        await app().orchestrator.step_async(rt_subframes, pause_timeline, delta_time, wait_for_render)

    def preview(self) -> None:
        kit().update()

    async def preview_async(self) -> None:
        await kit().next_update()

    def run(self, num_frames: int | None = None, start_timeline: bool = False) -> None:
        """Captures a frame in each update until the triggers that end are over.

        While the timeline does not play, and in a snippet, it captures all of them at once; else further updates do.
        """
        self._start(start_timeline)
        run = RUN.get()
        at_once = not app().timeline.is_playing() or (run is not None and run.from_editor)
        for _ in self._frames(num_frames, whole=at_once):
            self._capture()

    async def run_async(self, num_frames: int | None = None, start_timeline: bool = False) -> None:
        self._start(start_timeline)
        for _ in self._frames(num_frames, whole=not app().timeline.is_playing()):
            await self._capture_async()

    def run_until_complete(self, num_frames: int | None = None, start_timeline: bool = False) -> None:
        self._start(start_timeline)
        for _ in self._frames(num_frames):
            self._capture()
        self._turn(_Status.STOPPED)

    async def run_until_complete_async(self, num_frames: int | None = None, start_timeline: bool = False) -> None:
        self._start(start_timeline)
        for _ in self._frames(num_frames):
            await self._capture_async()
        self._turn(_Status.STOPPED)

    def _frames(self, most: int | None, *, whole: bool = True) -> Iterator[int]:
        """Counts frames: `most`; or, if `whole`, until the triggers that end are over; else one."""
        whole = whole and most is None and triggers().finite
        self._looping = True
        try:
            for number in count():
                if (triggers().over if whole else number >= (most or 1)) or not self.get_is_started():
                    return
                yield number
        finally:
            self._looping = False
            app().rendering.stepped = self.get_is_started() and not triggers().over

    def _capture(self) -> None:
        """One frame, of the world at rest unless the timeline plays."""
        if app().timeline.is_playing():
            kit().update()
        else:
            self.step(delta_time=0.0)

    async def _capture_async(self) -> None:
        if app().timeline.is_playing():
            await kit().next_update()
        else:
            await self.step_async(delta_time=0.0)

    def _end_if_over(self) -> None:
        if self._status is _Status.STARTED and triggers().over and not self._looping:
            self._turn(_Status.STOPPED)

    def _start(self, start_timeline: bool) -> None:
        if start_timeline:
            app().play()
        kit().singleton(_Orchestrator, lambda: app().on("end", self._end_if_over))
        self._turn(_Status.STARTED)

    def _turn(self, status: _Status) -> None:
        """The new status; while started, every update is a step of the orchestrator."""
        self._status, app().rendering.stepped = status, status is _Status.STARTED

    def stop(self) -> None:
        self._turn(_Status.STOPPED)

    def pause(self) -> None:
        self._turn(_Status.PAUSED)

    def resume(self) -> None:
        self._turn(_Status.STARTED)

    def wait_until_complete(self) -> None:
        app().deliver_frames()

    async def wait_until_complete_async(self) -> None:
        app().deliver_frames()

    def set_capture_on_play(self, value: bool) -> None:
        app().settings.set(keys.CAPTURE_ON_PLAY, bool(value))

    def get_status(self) -> _Status:
        return self._status

    def get_is_started(self) -> bool:
        return self._status is _Status.STARTED


orchestrator = _Orchestrator()


def set_global_seed(seed: int) -> None:
    triggers().seed = int(seed)


def get_global_seed() -> int:
    return triggers().seed


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
