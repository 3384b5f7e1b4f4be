"""`NonVisualMaterial` of `isaacsim.core.experimental.materials`."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.results import Result, array, result
from graph.sim.scene.nonvisual import ATTRIBUTES, BASES, COATINGS, PREFIX
from graph.sim.usd import UsdShade

from .accessors import text
from .prim_base import Prim, define, prims_of
from .stage import usd_stage

__all__ = [
    "ATTRIBUTE_SPEC",
    "BASE_SPEC",
    "COATING_SPEC",
    "NonVisualMaterial",
]
BASE_SPEC = {name: number for number, name in enumerate(BASES)}
COATING_SPEC = {name: number for number, name in enumerate(COATINGS)}
ATTRIBUTE_SPEC = ATTRIBUTES


class NonVisualMaterial(Prim):
    set_bases, get_bases = text(f"{PREFIX}:base", "bases", default="none")
    set_coatings, get_coatings = text(f"{PREFIX}:coating", "coatings", default="none")
    set_attributes, get_attributes = text(f"{PREFIX}:attributes", "attributes", default="none")

    def __init__(self, paths: Any, *, bases: Any = None, coatings: Any = None, attributes: Any = None) -> None:
        super().__init__(define(paths, "Material"), resolve_paths=False)
        for put, values in ((self.set_bases, bases), (self.set_coatings, coatings), (self.set_attributes, attributes)):
            if values is not None:
                put(values)

    @property
    def materials(self) -> list[Any]:
        return [UsdShade.Material(prim) for prim in self.prims]

    @staticmethod
    def encode_material_ids(prims: Any) -> Result:
        from sensors.surfaces.material_codes import material_of

        listed = prims.prims if isinstance(prims, NonVisualMaterial) else prims_of(prims)
        return result([[material_of(usd_stage(), str(one.GetPath()))] for one in listed], np.uint32)

    @staticmethod
    def decode_material_ids(ids: Any) -> list[tuple[str, str, str]]:
        """Base, coating and attribute of each id; "none" for a number without a name."""
        fields = ((BASE_SPEC, 0, 0xFF), (COATING_SPEC, 8, 0x7), (ATTRIBUTE_SPEC, 11, 0x1F))
        names = [({number: name for name, number in spec.items()}, shift, mask) for spec, shift, mask in fields]

        def name_of(field: int, number: int) -> str:
            known, shift, mask = names[field]
            return known.get(number >> shift & mask, "none")

        return [(name_of(0, int(one)), name_of(1, int(one)), name_of(2, int(one))) for one in array(ids).flat]
