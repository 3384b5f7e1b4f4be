"""`isaacsim.sensors.rtx`: names and numbers of non-visual materials, and Material prims that have them."""

from __future__ import annotations

from typing import Any

from graph.isaac.session import app
from graph.sim.scene.nonvisual import ATTRIBUTES, BASES, PREFIX
from graph.sim.scene.nonvisual import COATINGS as COATING_NAMES
from graph.sim.usd import Sdf, UsdShade

__all__ = [
    "ATTRIBUTES",
    "ATTR_ATTRIBUTE",
    "ATTR_BASE",
    "ATTR_COATING",
    "ATTR_PREFIX",
    "BASE_MATERIALS",
    "COATINGS",
    "GLASS_BASE",
    "METALS_BASE",
    "NONE_BASE",
    "OTHER_BASE",
    "POLYMERS_BASE",
    "apply_nonvisual_material",
    "decode_material_id",
    "get_material_id",
]
BASE_MATERIALS = {name: number for number, name in enumerate(BASES)}
NONE_BASE, METALS_BASE, POLYMERS_BASE, GLASS_BASE, OTHER_BASE = (
    {name: number for name, number in BASE_MATERIALS.items() if first <= number < end}
    for first, end in ((0, 1), (1, 11), (11, 19), (19, 24), (24, len(BASES)))
)
COATINGS = {name: number for number, name in enumerate(COATING_NAMES)}
ATTR_PREFIX = PREFIX
ATTR_BASE, ATTR_COATING, ATTR_ATTRIBUTE = (f"{PREFIX}:{name}" for name in ("base", "coating", "attributes"))
_FIELDS = (
    (ATTR_BASE, BASE_MATERIALS, 0, 0xFF),
    (ATTR_COATING, COATINGS, 8, 0x7),
    (ATTR_ATTRIBUTE, ATTRIBUTES, 11, 0x1F),
)


def apply_nonvisual_material(
    prim: Any, base: str | int, coating: str | int = "none", attribute: str | int = "none"
) -> bool:
    """Names, or their numbers; False, with a warning, for a prim that is not a Material or an unknown name."""
    if not _is_material(prim):
        return False
    names: list[str] = []
    for given, (place, known, _, _) in zip((base, coating, attribute), _FIELDS, strict=True):
        name = given if isinstance(given, str) else next((one for one, two in known.items() if two == given), None)
        if name not in known:
            app().warn(
                "material-unknown", str(prim.GetPath()), f"{given!r} is not one of {', '.join(known)} of {place}"
            )
            return False
        names.append(str(name))
    for name, (place, *_) in zip(names, _FIELDS, strict=True):
        prim.CreateAttribute(place, Sdf.ValueTypeNames.String, custom=True).Set(name)
    return True


def get_material_id(prim: Any) -> int:
    """0 for a prim that is not a Material; an unknown name counts as "none"."""
    if not _is_material(prim):
        return 0
    return sum(known.get(prim.GetAttribute(place).Get(), 0) << shift for place, known, shift, _ in _FIELDS)


def decode_material_id(material_id: int) -> tuple[str, ...]:
    if not 0 <= material_id <= 0xFFFF:
        raise ValueError(f"material id {material_id} is outside valid uint16 range")
    return tuple(
        next((name for name, number in known.items() if number == material_id >> shift & mask), "none")
        for _, known, shift, mask in _FIELDS
    )


def _is_material(prim: Any) -> bool:
    if prim and prim.IsA(UsdShade.Material):
        return True
    where = str(prim.GetPath()) if prim else "a prim"
    app().warn("material-unknown", where, "it is not a Material prim; a non-visual material needs one")
    return False
