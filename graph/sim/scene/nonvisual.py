"""Non-visual materials: surface properties for sensors' rays, as names on a Material prim.

Names and numbers are those of Isaac Sim; the id packs them as base | coating << 8 | attribute << 11.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graph.base.suggest import did_you_mean

PREFIX = "omni:simready:nonvisual"

BASES = (
    *("none", "aluminum", "steel", "oxidized_steel", "iron", "oxidized_iron", "silver", "brass", "bronze"),
    *("oxidized_bronze_patina", "tin", "plastic", "fiberglass", "carbon_fiber", "vinyl", "plexiglass", "pvc", "nylon"),
    *("polyester", "clear_glass", "frosted_glass", "one_way_mirror", "mirror", "ceramic_glass", "asphalt", "concrete"),
    *("leaf_grass", "dead_leaf_grass", "rubber", "wood", "bark", "cardboard", "paper", "fabric", "skin", "fur_hair"),
    *("leather", "marble", "brick", "stone", "gravel", "dirt", "mud", "water", "salt_water", "snow", "ice"),
    "calibration_lambertion",
)
"""A base's number is its index."""

COATINGS = ("none", "paint", "clearcoat", "paint_clearcoat")
"""A coating's number is its index."""

ATTRIBUTES = {"none": 0, "emissive": 1, "retroreflective": 2, "single_sided": 4, "visually_transparent": 8}
"""Attributes by name; a material may have several."""


def parse(value: Any) -> tuple[str, str, str]:
    """Base, coating and attributes of a name or a mapping {base:, coating:, attributes:}. Raises ValueError.

    `attributes` may be one name or a list; they come back as one name, or as names joined by commas.
    """
    if isinstance(value, str):
        value = {"base": value}
    if not isinstance(value, Mapping):
        raise ValueError("give a material's name, or base, coating and attributes")
    unknown = [key for key in value if key not in ("base", "coating", "attributes")]
    if unknown:
        raise ValueError(f"there is no {unknown[0]!r} in a material; it has base, coating and attributes")
    attributes = value.get("attributes", "none")
    names = [attributes] if isinstance(attributes, str) else list(attributes)
    return (
        _known("base", value.get("base", "none"), BASES),
        _known("coating", value.get("coating", "none"), COATINGS),
        ",".join(_known("attribute", name, tuple(ATTRIBUTES)) for name in names) or "none",
    )


def encode(base: str, coating: str, attributes: str) -> int:
    """The material's 16-bit id; 0 if a name is unknown."""
    names = [name.strip() for name in attributes.split(",")]
    if base not in BASES or coating not in COATINGS or any(name not in ATTRIBUTES for name in names):
        return 0
    bits = 0
    for name in names:
        bits |= ATTRIBUTES[name]
    return BASES.index(base) | COATINGS.index(coating) << 8 | bits << 11


def bind(stage: Any, prim: Any, names: tuple[str, str, str]) -> None:
    """Binds a prim to the Material with these names; equal materials of a stage are one prim."""
    from graph.sim.usd import Sdf, UsdShade

    label = "_".join(part.replace(",", "_") for part in names if part != "none") or "none"
    material = UsdShade.Material.Define(stage, f"/NonVisualMaterials/{label}")
    for key, name in zip(("base", "coating", "attributes"), names, strict=True):
        material.GetPrim().CreateAttribute(f"{PREFIX}:{key}", Sdf.ValueTypeNames.Token).Set(name)
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)


def _known(what: str, name: Any, names: tuple[str, ...]) -> str:
    if name not in names:
        hint = did_you_mean(str(name), names, f"there are {', '.join(names)}")
        raise ValueError(f"there is no material {what} {name!r}{hint}")
    return str(name)
