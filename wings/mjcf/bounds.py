"""Limits of a model: numbers in the XML that would make it larger than any machine can hold."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from graph.base.errors import Problem
from graph.base.limits import allowed, most

from .source import Element

MAX_ELEMENTS = 200_000
"""Elements after replication and attachment, and points of objects made of points."""
MAX_PIXELS = 2**26
MAX_SAMPLES = 2**24
MAX_MEMORY = 2**32
_UNITS = {"K": 2**10, "M": 2**20, "G": 2**30, "T": 2**40, "P": 2**50, "E": 2**60}

_LARGEST: Mapping[tuple[str, str], int] = {
    ("camera", "resolution"): 2**14,
    ("mesh", "params"): 2048,
    ("numeric", "size"): 10**6,
    ("size", "nkey"): 10**4,
    ("size", "nuserdata"): 10**7,
    ("size", "njmax"): 10**6,
    ("size", "nconmax"): 10**6,
    ("size", "nstack"): 10**8,
    **{
        ("size", f"nuser_{kind}"): 1000
        for kind in ("actuator", "body", "cam", "geom", "jnt", "sensor", "site", "tendon")
    },
}
"""The largest allowed number of an attribute."""

_COUNT = "physics.iterations"
_LARGEST_ANYWHERE = {"nsample": 10**5, "actdim": 10**4, "dim": 10**5, "num": 10**5}


def elements(root: Element, models: Mapping[str, int]) -> float:
    """The number of elements that MuJoCo makes of a tree; `models`: that of each attachable model, by name."""

    def count(element: Element) -> float:
        inner = 1 + sum(map(count, element.children))
        if element.tag == "replicate":
            return inner * max(_numbers(element.get("count")), default=1)
        if element.tag == "attach":
            return inner + models.get(element.get("model") or "", 0)
        if element.tag == "flexcomp":
            return inner + math.prod(max(number, 1) for number in _numbers(element.get("count")))
        return inner

    return count(root)


def too_large(element: Element) -> Iterator[Problem]:
    """The limit this element exceeds, if any."""
    get = element.get
    for name, text in element.attributes.items():
        largest = _LARGEST.get((element.tag, name), _LARGEST_ANYWHERE.get(name))
        if element.tag == "option" and name.endswith("iterations") and max(_numbers(text), default=0) > most(_COUNT):
            yield Problem(f"option: {name} {text!r}; {allowed(_COUNT)}", element.mark)
        if largest is not None and max(_numbers(text), default=0) > largest:
            yield Problem(f"{element.tag}: {name} {text!r} is above {largest}", element.mark)
    if element.tag == "texture" and _product(get("width"), get("height"), get("nchannel") or "3") > 3 * MAX_PIXELS:
        yield Problem(f"texture: {get('width')} by {get('height')} pixels are above {MAX_PIXELS}", element.mark)
    if element.tag == "hfield" and _product(get("nrow"), get("ncol")) > MAX_SAMPLES:
        yield Problem(f"hfield: {get('nrow')} by {get('ncol')} samples are above {MAX_SAMPLES}", element.mark)
    if element.tag == "size" and _memory(get("memory")) > MAX_MEMORY:
        yield Problem(f"size: memory {get('memory')!r} is above {MAX_MEMORY >> 30}G", element.mark)
    if element.tag == "lengthrange" and _product(get("inttotal") or "10") / _product(get("timestep") or "0.01") > 1e6:
        yield Problem("lengthrange: inttotal is above 1000000 of its time steps", element.mark)


def image_size(data: bytes) -> tuple[int, int] | None:
    """Width and height in the header of a PNG; None for another file."""
    if data[:8] != b"\x89PNG\r\n\x1a\n" or len(data) < 24:
        return None
    return int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")


def _numbers(text: str | None) -> list[float]:
    out = []
    for word in (text or "").split():
        try:
            value = float(word)
        except ValueError:  # MuJoCo reports the mistake
            continue
        out.append(math.inf if math.isnan(value) else value)
    return out


def _product(*texts: str | None) -> float:
    return math.prod((_numbers(text) or [1.0])[0] for text in texts) or 1e-300


def _memory(text: str | None) -> float:
    text = (text or "").strip()
    unit = _UNITS.get(text[-1:].upper())
    numbers = _numbers(text[:-1] if unit else text)
    return (numbers or [0.0])[0] * (unit or 1)
