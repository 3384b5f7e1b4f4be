"""Conveyor belts of `isaacsim.asset.gen.conveyor`, by function and by command."""

from tests.support.without_wing import needs_wing

BELT = """from isaacsim import SimulationApp
app = SimulationApp({"headless": True})
import omni.kit.commands, omni.timeline, omni.usd
from isaacsim.asset.gen.conveyor import create_conveyor_belt
from isaacsim.core.experimental.objects import Cube
from isaacsim.core.experimental.prims import GeomPrim, RigidPrim
from pxr import Gf, UsdPhysics
stage = omni.usd.get_context().get_stage()
def box(path, size, height):
    Cube(path, sizes=size, positions=[0.0, 0.0, height])
    GeomPrim(path, apply_collision_apis=True)
    RigidPrim(path)
    return stage.GetPrimAtPath(path)
belt = box("/belt", 1.0, 0.0)
UsdPhysics.RigidBodyAPI(belt).CreateKinematicEnabledAttr(True)
"""


@needs_wing("robots")
def test_a_belt_carries_a_box_at_the_speed_of_its_variable(run_script):
    code, out, err = run_script(
        BELT
        + """node = create_conveyor_belt(stage, belt)
load = box("/load", 0.1, 0.55)
node.GetAttribute("inputs:direction").Set(Gf.Vec3f(0, 1, 0))
graph = node.GetParent()
graph.GetAttribute("graph:variable:Velocity").Set(0.1)
omni.timeline.get_timeline_interface().play()
for _ in range(80):
    app.update()
speed = RigidPrim("/load").get_velocities()[0].numpy()[0]
print(node.GetPath(), [round(abs(float(one)), 2) for one in speed])
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == ["/ConveyorBeltGraph/ConveyorNode [0.0, 0.1, 0.0]"]


@needs_wing("robots")
def test_a_mesh_becomes_a_body_and_a_part_moves_its_body(run_script):
    code, out, err = run_script(
        BELT
        + """from isaacsim.core.experimental.objects import Mesh
Mesh("/mesh", primitives="Cube")
mesh = stage.GetPrimAtPath("/mesh")
done, node = omni.kit.commands.execute("CreateConveyorBelt", conveyor_prim=mesh)
print(done, node.GetRelationship("inputs:conveyorPrim").GetTargets(), mesh.HasAPI(UsdPhysics.RigidBodyAPI))
print(UsdPhysics.MeshCollisionAPI(mesh).GetApproximationAttr().Get(), mesh.GetPrimTypeInfo().GetAppliedAPISchemas()[-1])
Cube("/belt/part")
second = create_conveyor_belt(stage, stage.GetPrimAtPath("/belt/part"))
print(second.GetPath(), second.GetRelationship("inputs:conveyorPrim").GetTargets())
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == [
        "True [Sdf.Path('/mesh')] True",
        "convexHull PhysxSurfaceVelocityAPI",
        "/ConveyorBeltGraph_01/ConveyorNode [Sdf.Path('/belt')]",
    ]
