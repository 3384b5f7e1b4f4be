"""Materials of prims."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type

from .stage_prims import find_prim, only_target


@node_type(
    "omni.graph.nodes.WritePrimMaterial",
    version=1,
    inputs={
        "execIn": Attribute("execution", "binds the material"),
        "materialPath": Attribute("path", "path of a Material prim", default="", role="prim"),
        "primPath": Attribute("path", "path of the prim that gets it", default="", role="prim"),
    },
    outputs={"execOut": Attribute("execution", "follows once it is bound")},
)
def write_prim_material(db: Database) -> bool:
    """Bind a material to a prim; a path that is not a Material fails, a missing prim is skipped."""
    from graph.sim.usd import UsdShade

    prim = find_prim(db, db.inputs.primPath)
    material = find_prim(db, db.inputs.materialPath)
    if prim is None or material is None:
        return False
    if not material.IsA(UsdShade.Material):
        db.fail(f"{material.GetPath()} is not a Material but {material.GetTypeName() or 'a prim without type'}")
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(UsdShade.Material(material))
    db.fire("execOut")
    return True


@node_type(
    "omni.graph.nodes.ReadPrimMaterial",
    version=2,
    volatile=True,
    inputs={
        "prim": Attribute("target", "the prim, before primPath"),
        "primPath": Attribute("path", "path of the prim", default="", role="prim"),
    },
    outputs={
        "material": Attribute("path", "path of its material; empty without one"),
        "materialPrim": Attribute("target", "its material"),
    },
)
def read_prim_material(db: Database) -> bool:
    """Read the material of a prim, bound to it or to an ancestor; for a missing prim the outputs keep their values."""
    from graph.sim.usd import UsdShade

    inputs = db.inputs
    prim = find_prim(db, only_target(db, "prim", inputs.prim) if inputs.prim else inputs.primPath)
    if prim is None:
        return False
    material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    path = str(material.GetPath()) if material else ""
    db.outputs.material, db.outputs.materialPrim = path, [path] if path else []
    return True
