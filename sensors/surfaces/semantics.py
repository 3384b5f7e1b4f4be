"""Semantic labels of hit prims: UsdSemantics, and the attributes of older versions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

Labels = dict[str, str]
"""Taxonomy (a token such as "class") -> label; several labels are joined by commas."""

LABELS = "semantics:labels:"
OLD_TYPE, OLD_DATA = ":params:semanticType", ":params:semanticData"
BACKGROUND: Labels = {"class": "BACKGROUND"}
UNLABELLED: Labels = {"class": "UNLABELLED"}


def labels_of(prim: Any) -> Labels:
    """The labels on a prim itself, by taxonomy.

    Reads `semantics:labels:<taxonomy>` (UsdSemantics; SemanticsLabelsAPI need not be applied), then
    `semantic:<name>:params:semanticType` with `...:semanticData`, then `semantics:<taxonomy>`; the first one of a
    taxonomy wins.
    """
    found: Labels = {}
    names = [str(name) for name in prim.GetAuthoredPropertyNames() if str(name).startswith("semantic")]
    for name in sorted(names, key=_rank):
        if name.startswith(LABELS):
            _add(found, name.removeprefix(LABELS), _value(prim, name))
        elif name.startswith("semantic:") and name.endswith(OLD_DATA):
            kind = _value(prim, name.removesuffix(OLD_DATA) + OLD_TYPE)
            _add(found, str(kind or "class"), _value(prim, name))
        elif name.startswith("semantics:"):
            _add(found, name.removeprefix("semantics:"), _value(prim, name))
    return found


def inherited_labels(stage: Any, path: str) -> Labels:
    """The labels of a prim: for each taxonomy, those of the nearest prim at or above it that has any."""
    found: Labels = {}
    prim = stage.GetPrimAtPath(path)
    while prim and not prim.IsPseudoRoot():
        for taxonomy, label in labels_of(prim).items():
            found.setdefault(taxonomy, label)
        prim = prim.GetParent()
    return found


def surface_label(stage: Any, surface: Any) -> Labels:
    """The labels of a surface: of its prim, then, for a copy, of the point instancer."""
    path = str(surface.path)
    found = inherited_labels(stage, str(surface.source or path))
    if "[" in path:
        found = {**inherited_labels(stage, path.partition("[")[0]), **found}
    return found


def numbered(surfaces: Sequence[Labels]) -> tuple[np.ndarray, dict[int, Labels]]:
    """The number of each surface's labels, (n,) uint32, and the labels of each number.

    0 means no hit, 1 no label; labels follow from 2 on, in the order of their text.
    """
    different = sorted({_key(labels) for labels in surfaces if labels})
    number = {key: place for place, key in enumerate(different, start=2)}
    numbers = np.array([number[_key(labels)] if labels else 1 for labels in surfaces], np.uint32)
    return numbers, {0: BACKGROUND, 1: UNLABELLED} | {place: dict(key) for key, place in number.items()}


def _key(labels: Labels) -> tuple[tuple[str, str], ...]:
    return tuple(sorted(labels.items()))


def _rank(name: str) -> tuple[int, str]:
    return (0 if name.startswith(LABELS) else 1 if name.startswith("semantic:") else 2), name


def _value(prim: Any, name: str) -> Any:
    attribute = prim.GetAttribute(name)
    return attribute.Get() if attribute else None


def _add(found: Labels, taxonomy: str, value: Any) -> None:
    texts = [value] if isinstance(value, str) else [str(text) for text in _listed(value)]
    label = ",".join(text for text in texts if text)
    if taxonomy and label:
        found.setdefault(taxonomy, label)


def _listed(value: Any) -> Iterable[Any]:
    return () if value is None or isinstance(value, (bool, int, float)) else value
