"""Sensor types: everything that a modality adds, registered in one place by the type of its prims.

Wings and other packages declare theirs in the entry point group `tickgraph.sensors`: each entry is a `SensorType`.
A wing's has the name of the prim type, so that a prim whose wing is missing is reported.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

from graph.base.plugins import SENSORS, leave_out, loaded, shipped
from graph.base.records import dataclass, field
from graph.sim import entered
from graph.sim.scene import placed_types

from .channels import CHANNELS, POINT_CHANNELS, Channel
from .errors import SensorValueError

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.renderer.sensor import Sensor
    from graph.sim.renderer.view import WorldView

    from .annotators.types import AnnotatorType
    from .writers.spec import WriterSpec

BUILT_IN = (
    "sensors.lidar.sensor_type",
    "sensors.camera.sensor_type",
    "sensors.radar.sensor_type",
)
"""Modules that register the core's types; those of wings and of other packages are declared as plug-ins."""


@dataclass(frozen=True, slots=True)
class SensorType:
    """One modality.

    - prim_type: of the prims that are such sensors; they have a transform, also where no USD schema declares the type.
    - modality: its name in `GenericModelOutput`, or another where none is made of its frames.
    - runtime: makes the sensor of a prim for images of a width and height (what makes no images takes no notice): a
      `SensorRuntime` class, or a function. Raises UserError for a prim that describes no such sensor.
    - channels: what it can measure; new ones join `CHANNELS`.
    - annotators, writers: its own, beside those for all sensors.
    - attributes: those of its prims that no USD schema declares: name -> USD value type, such as "double".
    - aux_levels: the values that aux_output_level of its prims may have.
    - example: keys of a prim that measures something, as a graph file has them after `type`; for generated examples.
    - check: lines about what is wrong with a prim, before anything runs.
    - author(prim, config, variant, roots=, base=): writes a named configuration, the key `config` of a prim in a graph
      file; None for a type without configurations.
    - facts(scene, prim): what `graph explain` knows of a prim, as JSON data. rows: the same as (label, text) for a
      person.
    - blind(scene, prim): a sentence about what may keep such a sensor from seeing anything, said where it saw nothing.
    - rules: texts of the names that `Sensor.rule` gives, beside those for all sensors.
    - read_by: the nodes that poll such sensors (`sensors.polled`), which then have no render products; "" for rendered
      ones.
    """

    prim_type: str
    runtime: Callable[[WorldView, str, tuple[int, int]], Sensor]
    modality: str = "UNDEFINED"
    channels: Sequence[Channel] = POINT_CHANNELS
    annotators: Sequence[AnnotatorType] = ()
    writers: Mapping[str, WriterSpec] = field(default_factory=dict)
    attributes: Mapping[str, str] = field(default_factory=dict)
    aux_levels: Sequence[str] = ("NONE", "BASIC", "EXTRA", "FULL")
    example: str = ""
    check: Callable[[Usd.Prim], Iterable[str]] = lambda prim: ()
    author: Callable[..., None] | None = None
    facts: Callable[[WorldView, Usd.Prim], Mapping[str, Any]] = lambda scene, prim: {}
    rows: Callable[[Mapping[str, Any]], Iterable[tuple[str, str]]] = lambda facts: ()
    blind: Callable[[WorldView, Usd.Prim], str] = lambda scene, prim: ""
    rules: Mapping[str, str] = field(default_factory=dict)
    read_by: str = ""

    @property
    def measures(self) -> frozenset[str]:
        """The names of its channels."""
        return frozenset(channel.name for channel in self.channels)


_types: dict[str, SensorType] = {}
_loaded = False
_here = threading.local()
"""Whether this thread loads them."""
_LOCK = threading.RLock()


def register_sensor_type(kind: SensorType) -> None:
    """Adds a sensor type. Raises SensorValueError if its prim type, or a name that it adds, is taken."""
    from .annotators.types import TYPES
    from .writers.spec import REGISTRY

    _load()
    if kind.prim_type in _types:
        raise SensorValueError(f"there is a sensor type {kind.prim_type!r} already; give yours another prim type")
    others = _types.values()
    annotators = {*TYPES, *(one.name for other in others for one in other.annotators)}
    writers = set(REGISTRY).union(*(other.writers for other in others))
    for what, names, taken in (
        ("an annotator", [one.name for one in kind.annotators], annotators),
        ("a writer", kind.writers, writers),
        ("a channel", [one.name for one in kind.channels if CHANNELS.get(one.name, one) != one], CHANNELS),
    ):
        if name := next((name for name in names if name in taken), ""):
            raise SensorValueError(f"{kind.prim_type}: there is {what} {name!r} already; give yours another name")
    CHANNELS.update((channel.name, channel) for channel in kind.channels)
    _types[kind.prim_type] = kind
    placed_types.names.add(kind.prim_type)
    for app in [*entered.living]:
        placed_types.give_transforms(app.stage)


def unregister_sensor_type(prim_type: str) -> None:
    """Removes a sensor type and everything that it added; unknown ones are ignored."""
    kind = _types.pop(prim_type, None)
    placed_types.names.discard(prim_type)
    kept = {channel.name for channel in POINT_CHANNELS}.union(*(other.measures for other in _types.values()))
    for name in kind.measures - kept if kind else ():
        del CHANNELS[name]


def sensor_types() -> Mapping[str, SensorType]:
    """Every sensor type by its prim type: shipped, of installed packages, and registered by users."""
    _load()
    return _types


def sensor_type(prim_type: str) -> SensorType | None:
    """The sensor type of a prim type; None for prims that are not sensors."""
    return sensor_types().get(prim_type)


def measures_of(prim_type: str) -> frozenset[str]:
    """The channels that sensors of a prim type measure; empty for prims that are not sensors."""
    kind = sensor_type(prim_type)
    return kind.measures if kind else frozenset()


def prim_types_of(modality: str) -> tuple[str, ...]:
    """The prim types of the sensors of a modality; of every sensor for ""."""
    return tuple(name for name, kind in sensor_types().items() if modality in ("", kind.modality))


def sensor_problems(stage: Usd.Stage) -> Iterable[tuple[str, str]]:
    """(prim path, message) for each mistake in the sensors of a stage."""
    from graph.sim.scene.value_types import type_problems
    from graph.sim.usd import Usd

    missing = {name: plugin.absence for name, plugin in shipped(SENSORS).items() if plugin.absence}
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        name = str(prim.GetTypeName())
        if kind := sensor_type(name):
            messages = list(type_problems(prim)) or kind.check(prim)
            yield from ((str(prim.GetPath()), message) for message in messages)
        elif name in missing:
            yield str(prim.GetPath()), f"sensors of type {name} cannot be used: {missing[name]}"


def _load() -> None:
    """Registers the shipped types and those of installed packages, once; other threads wait until all are there."""
    global _loaded
    if _loaded or getattr(_here, "loading", False):  # a module that is being imported registers its type
        return
    _here.loading = True
    try:
        # Outside of our lock: another thread may import one of these modules, and wait for it.
        for module in BUILT_IN:
            import_module(module)
        packages = list(loaded(SENSORS, SensorType))
        with _LOCK:
            if not _loaded:
                for plugin, kind in packages:
                    try:
                        register_sensor_type(kind)
                    except SensorValueError as error:
                        leave_out(plugin, error)
                _loaded = True
    finally:
        _here.loading = False
