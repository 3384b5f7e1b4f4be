"""The short names by which sensors find annotators; the annotators themselves are in `sensors.annotators.types`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sensors.errors import SensorValueError

from .registry import find_annotator, register_annotator
from .types import TYPES, AnnotatorType

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
