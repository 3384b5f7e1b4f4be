"""Non-visual materials: what lidars and radars see of a surface, as one 16-bit number."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from graph.sim.scene.nonvisual import ATTRIBUTES, BASES, COATINGS

PREFIX = "omni:simready:nonvisual:"
PREFIX_SETTING = "/rtx/materialDb/nonVisualMaterialSemantics/prefix"


def encode(base: str = "none", coating: str = "none", attributes: str | Sequence[str] = "none") -> int:
    """base | coating << 8 | attributes << 11; aluminum + paint + emissive is 2305. 0 if any name is unknown.

    attributes: one name, several separated by commas or spaces, or a sequence of names.
    """
    names = re.split(r"[,\s]+", attributes.strip()) if isinstance(attributes, str) else list(attributes)
    flags = [ATTRIBUTES.get(name or "none") for name in names]
    if base not in BASES or coating not in COATINGS or None in flags:
        return 0
    bits = 0
    for flag in flags:
        bits |= flag or 0
    return BASES.index(base) | COATINGS.index(coating) << 8 | bits << 11


def decode(number: int) -> tuple[str, str, tuple[str, ...]]:
    """(base, coating, attributes) of an encoded material; unknown parts are "none".

    Raises ValueError outside 0 to 65535.
    """
    if not 0 <= number <= 0xFFFF:
        raise ValueError(f"{number} is not an encoded material: it does not fit into 16 bits")
    base, coating, bits = number & 0xFF, number >> 8 & 0x7, number >> 11
    attributes = tuple(name for name, bit in ATTRIBUTES.items() if bit and bits & bit)
    return (
        BASES[base] if base < len(BASES) else "none",
        COATINGS[coating] if coating < len(COATINGS) else "none",
        attributes or ("none",),
    )


def material_of(stage: Any, path: str | None, prefix: str = PREFIX) -> int:
    """The encoded material of a Material prim; 0 for a missing prim, or one without non-visual attributes."""
    prim = stage.GetPrimAtPath(path) if path else None
    if not prim:
        return 0
    values = []
    for name in ("base", "coating", "attributes"):
        attribute = prim.GetAttribute(f"{prefix}{name}")
        value = attribute.Get() if attribute else None
        values.append("none" if value is None or value == "" else value)
    base, coating, attributes = values
    return encode(str(base), str(coating), attributes if isinstance(attributes, str) else [str(a) for a in attributes])
