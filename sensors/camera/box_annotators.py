"""The annotators that give boxes and how much of prims is hidden, with the fields of Replicator's."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from sensors.annotators.types import AnnotatorType, Reading

from .channels import AROUND, BOX, FIRST, FLAT_BOX, LABELLED, LOOSE, SOLID_BOX, TIGHT
from .label_filter import OPTIONS, check_filter, kept_labels
from .names import MODALITY

HIDDEN = np.dtype([("instanceId", "<u4"), ("semanticId", "<u4"), ("occlusionRatio", "<f4")])


def _classes(reading: Reading) -> tuple[dict[int, int], dict[int, dict[str, str]]]:
    """Number of a labelled prim -> number of its labels, from 0; number of labels -> what they are.

    Only labels that the options let through, and prims with any of them.
    """
    from .entities import entities_of  # which needs USD

    labels = entities_of(reading.world, LABELLED).labels
    kept = {number: kept_labels(found, reading.options) for number, found in labels.items()}
    texts = {number: tuple(sorted(found.items())) for number, found in kept.items() if found}
    place = {text: number for number, text in enumerate(sorted(set(texts.values())))}
    classes = {number: place[text] for number, text in texts.items()}
    return classes, {number: dict(text) for text, number in place.items()}


def _boxes(kind: str) -> Callable[[Reading], dict[str, Any]]:
    fields = SOLID_BOX if kind in (BOX, AROUND) else FLAT_BOX

    def read(reading: Reading) -> dict[str, Any]:
        given = np.dtype([("semanticId", "<u4"), *fields])
        if reading.frame is None:
            empty = {"idToLabels": {}, "bboxIds": np.empty(0, np.uint32), "primPaths": []}
            return {"data": np.empty(0, given), "info": empty}
        from .entities import entities_of

        classes, labels = _classes(reading)
        boxes = reading.frame.channel(kind)
        boxes = boxes[np.isin(boxes["instance"], list(classes))]
        numbers = boxes["instance"].tolist()
        data = np.empty(len(boxes), given)
        data["semanticId"] = [classes[number] for number in numbers]
        for name, *_ in fields:
            data[name] = boxes[name]
        paths = entities_of(reading.world, LABELLED).paths
        info = {
            "idToLabels": {number: labels[number] for number in sorted(set(data["semanticId"].tolist()))},
            "bboxIds": boxes["instance"] - np.uint32(FIRST),
            "primPaths": [paths[number] for number in numbers],
        }
        return {"data": data, "info": info}

    return read


def _occlusion(reading: Reading) -> np.ndarray:
    found = _boxes(LOOSE)(reading)
    data = np.empty(len(found["data"]), HIDDEN)
    data["instanceId"], data["semanticId"] = found["info"]["bboxIds"] + np.uint32(FIRST), found["data"]["semanticId"]
    data["occlusionRatio"] = found["data"]["occlusionRatio"]
    return data


def _annotator(kind: str, name: str) -> AnnotatorType:
    return AnnotatorType(
        name, _boxes(kind), lambda reading: (kind,), options=OPTIONS, modality=MODALITY, check=check_filter
    )


BOX_ANNOTATORS = (
    *(_annotator(kind, f"{kind}{fast}") for kind in (TIGHT, LOOSE, BOX) for fast in ("", "_fast")),
    _annotator(AROUND, AROUND),
    AnnotatorType(
        "occlusion", _occlusion, lambda reading: (LOOSE,), options=OPTIONS, modality=MODALITY, check=check_filter
    ),
)
