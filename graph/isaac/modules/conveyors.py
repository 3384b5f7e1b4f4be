"""`isaacsim.asset.gen.conveyor`: a graph whose `IsaacConveyor` moves a body's surface."""

from __future__ import annotations

from typing import Any

from graph.isaac.omnigraph.controller import Controller
from graph.sim.usd import Sdf, Tf, UsdGeom, UsdPhysics

from .usd import get_stage_next_free_path

__all__ = ["create_conveyor_belt"]


def create_conveyor_belt(stage: Any, conveyor_prim: Any, prim_name: str = "ConveyorBeltGraph") -> Any:
    """The node's prim. The belt is the nearest rigid body at or above the prim; without one, the prim becomes one."""
    body = conveyor_prim
    while body and not body.HasAPI(UsdPhysics.RigidBodyAPI):
        body = body.GetParent()
    if not body:
        body = conveyor_prim
        UsdPhysics.RigidBodyAPI.Apply(body)
        UsdPhysics.CollisionAPI.Apply(body)
        if body.IsA(UsdGeom.Mesh):
            UsdPhysics.MeshCollisionAPI.Apply(body).CreateApproximationAttr().Set("convexHull")
        body.AddAppliedSchema("PhysxSurfaceVelocityAPI")
    base = body.GetPath() if body == stage.GetDefaultPrim() else body.GetPath().GetParentPath()
    path = get_stage_next_free_path(stage, str(base.AppendChild(Tf.MakeValidIdentifier(prim_name))), True)
    keys = Controller.Keys
    Controller.edit(
        {"graph_path": path, "evaluator_name": "execution"},
        {
            keys.CREATE_VARIABLES: [("Velocity", "float")],
            keys.CREATE_NODES: [
                ("OnTick", "omni.graph.action.OnPlaybackTick"),
                ("ConveyorNode", "isaacsim.asset.gen.conveyor.IsaacConveyor"),
                ("read_speed", "omni.graph.core.ReadVariable"),
            ],
            keys.SET_VALUES: [
                ("read_speed.inputs:graph", path),
                ("read_speed.inputs:variableName", "Velocity"),
                ("ConveyorNode.inputs:conveyorPrim", str(body.GetPath())),
            ],
            keys.CONNECT: [
                ("OnTick.outputs:tick", "ConveyorNode.inputs:onStep"),
                ("OnTick.outputs:deltaSeconds", "ConveyorNode.inputs:delta"),
                ("read_speed.outputs:value", "ConveyorNode.inputs:velocity"),
            ],
        },
    )
    return stage.GetPrimAtPath(Sdf.Path(path).AppendChild("ConveyorNode"))
