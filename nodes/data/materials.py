"""Materials of prims."""

from __future__ import annotations

from typing import Any

from graph import Attribute, node_type

from .stage_prims import find_prim


@node_type(
    "omni.graph.nodes.WritePrimMaterial",
    version=1,
    inputs={
        "execIn": Attribute("execution", "binds the material"),
        "materialPath": Attribute("path", "path of a Material prim", default=""),
        "primPath": Attribute("path", "path of the prim that gets it", default=""),
    },
    outputs={"execOut": Attribute("execution", "follows once it is bound")},
)
def write_prim_material(db: Any) -> bool:
    """Bind a material to a prim; a path that is no Material fails, a missing prim is passed by."""
    from graph.sim.usd import UsdShade

    prim = find_prim(db, db.inputs.primPath)
    material = find_prim(db, db.inputs.materialPath)
    if prim is None or material is None:
        return False
    if not material.IsA(UsdShade.Material):
        db.fail(f"{material.GetPath()} is no Material but {material.GetTypeName() or 'a prim without type'}")
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(UsdShade.Material(material))
    db.fire("execOut")
    return True
