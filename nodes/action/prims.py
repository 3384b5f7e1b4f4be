"""Edits of the stage from an action graph, and loops over prims."""

from __future__ import annotations

from typing import Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from graph.sim.scene.prim_paths import is_path
from nodes.data.stage_prims import find_prim, only_target

EXEC_IN = Attribute("execution", "activates the node")


@node_type(
    "omni.graph.action.SetPrimActive",
    version=2,
    inputs={
        "active": Attribute("bool", "whether it is to be active", default=False),
        "execIn": EXEC_IN,
        "prim": Attribute("path", "path of the prim", default="", deprecated="use primTarget", role="prim"),
        "primTarget": Attribute("target", "the prim"),
    },
    outputs={"execOut": Attribute("execution", "follows once it is done")},
)
def set_prim_active(db: Database) -> bool:
    """Switch a prim and its descendants on or off; refused while playing if physics or sensors use them."""
    inputs = db.inputs
    path = only_target(db, "primTarget", inputs.primTarget) if inputs.primTarget or not inputs.prim else inputs.prim
    prim = find_prim(db, str(path))
    if prim is None:
        return False
    if prim.IsActive() != inputs.active:
        refused = db.app.live is not None and db.app.when_playing != "recompile"
        if refused and ((not inputs.active and _in_the_world(prim)) or inputs.active):
            db.fail(
                f"{path} cannot be switched while the timeline plays: physics and geometry are read at play; hide it "
                "by its attribute visibility, switch it before, or run with --/tickgraph/whenPlaying=recompile"
            )
        prim.SetActive(inputs.active)
    db.fire("execOut")
    return True


def _in_the_world(prim: Any) -> bool:
    """Whether physics or sensors use the prim or one of its descendants."""
    from graph.sim.usd import Usd, UsdGeom, UsdPhysics

    roles = (UsdPhysics.RigidBodyAPI, UsdPhysics.CollisionAPI, UsdPhysics.ArticulationRootAPI)
    return any(
        one.IsA(UsdGeom.Gprim) or one.IsA(UsdPhysics.Joint) or any(one.HasAPI(role) for role in roles)
        for one in Usd.PrimRange(prim)
    )


@node_type(
    "omni.graph.action.AddPrimRelationship",
    version=1,
    inputs={
        "execIn": EXEC_IN,
        "name": Attribute("token", "name of the relationship", default=""),
        "path": Attribute("path", "path of the prim that has it", default="", role="prim"),
        "target": Attribute("path", "path to add: of a prim, an attribute or a relationship", default=""),
    },
    outputs={"isSuccessful": Attribute("bool", "whether the relationship names the target now")},
)
def add_prim_relationship(db: Database) -> None:
    """Add a target to a relationship. A missing relationship is created; a target is never added twice."""
    from graph.sim.usd import Sdf

    inputs = db.inputs
    if not inputs.name:
        db.lack("input name is empty; give it the name of a relationship")
    if not is_path(inputs.target) or not inputs.target.startswith("/"):
        db.fail(f'input target is "{inputs.target}", which is not an absolute path')
    prim = find_prim(db, inputs.path)
    db.outputs.isSuccessful = prim is not None
    if prim is None:
        return
    relationship = prim.GetRelationship(inputs.name) or prim.CreateRelationship(inputs.name)
    if Sdf.Path(inputs.target) not in relationship.GetTargets():
        db.outputs.isSuccessful = bool(relationship.AddTarget(inputs.target))


@dataclass(slots=True)
class _Target:
    index: int = 0


@node_type(
    "omni.graph.action.ForEachTarget",
    version=1,
    inputs={
        "execIn": Attribute("execution", "starts the loop"),
        "targets": Attribute("target", "the prims to go through"),
    },
    outputs={
        "arrayIndex": Attribute("int", "position of the prim, from 0"),
        "finished": Attribute("execution", "follows once after the last pass"),
        "loopBody": Attribute("execution", "follows once per pass, to its end, before the next pass"),
        "target": Attribute("target", "the prim of this pass"),
    },
    memory=_Target,
)
def for_each_target(db: Database) -> None:
    """Run one pass for each prim; without prims the node only finishes. Both data outputs keep their last values."""
    memory, targets = db.memory, db.inputs.targets
    memory.index = 0 if db.triggered("execIn") else memory.index + 1
    if memory.index < len(targets):
        db.outputs.arrayIndex = memory.index
        db.outputs.target = [targets[memory.index]]
        db.fire_and_return("loopBody")
    else:
        db.fire("finished")
