"""Every annotator by its name: those for all sensors, those of sensor types, those that users registered.

Sensors find them by short names too.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graph.base.errors import UserError
from graph.base.suggest import did_you_mean
from sensors.errors import SensorValueError
from sensors.sensor_types import prim_types_of, sensor_types

from .types import TYPES, AnnotatorType, Reading


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


def check_product(kind: AnnotatorType, reading: Reading) -> None:
    """Raises SensorValueError, with prim and annotator, for a product that the annotator cannot read."""
    path = reading.product.camera_path
    prim_type = str(reading.scene.stage.GetPrimAtPath(path).GetTypeName()) if path else ""
    readable = prim_types_of(kind.modality)
    if prim_type not in readable:
        what, where = prim_type or "not a sensor", path or reading.product.path
        raise SensorValueError(f"{kind.name}: {where} is {what}; it reads {' or '.join(readable)} only")
    try:
        kind.check(reading)
    except UserError as error:
        raise SensorValueError(f"{kind.name}: {error}") from error


ANNOTATORS: dict[str, dict[str, Any]] = {
    "generic-model-output": {"name": "GenericModelOutput"},
    "stable-id-map": {"name": "StableIdMap"},
    "semantic-classes": {"name": "SemanticClasses"},
}
"""Short name -> name in the registry, and default options. A sensor copies the table when it is created."""

_BUILT_IN = frozenset(ANNOTATORS)


def register_annotator_spec(name: str, spec: Mapping[str, Any] | AnnotatorType) -> None:
    """Makes the annotator `name` available to sensors that are created from now on.

    spec: {"name": name in the registry, "defaults": options}, or your own `AnnotatorType`, which is added to the
    registry. Raises SensorValueError if the name is taken, or the registry has no such annotator.
    """
    if name in ANNOTATORS:
        raise SensorValueError(f"there is an annotator {name!r} already; give yours another name")
    if isinstance(spec, AnnotatorType):
        if TYPES.get(spec.name) is not spec:
            register_annotator(spec)
        ANNOTATORS[name] = {"name": spec.name}
        return
    if "name" not in spec:
        raise SensorValueError(f'annotator {name!r}: the spec needs "name", the annotator\'s name in the registry')
    defaults = dict(spec.get("defaults", {}))
    find_annotator(spec["name"]).checked_options(defaults)
    ANNOTATORS[name] = {"name": spec["name"], "defaults": defaults}


def unregister_annotator_spec(name: str) -> None:
    """Removes a short name; unknown ones are ignored. Existing sensors keep it."""
    spec = ANNOTATORS.pop(name, None)
    if spec is not None and name in _BUILT_IN:
        ANNOTATORS[name] = spec
        raise SensorValueError(f"annotator {name!r} is one of our own; it stays")
