"""`isaacsim.core.experimental.actuators` and `newton.actuators`: a cube on a hinge, moved by its actuators."""

import pytest

from tests.support.without_wing import needs_wing

pytestmark = needs_wing("actuators")

SCENE = """
from isaacsim import SimulationApp
app = SimulationApp()
import omni.timeline
import omni.usd
from isaacsim.core.experimental.actuators import *
from isaacsim.core.experimental.prims import Articulation
from newton.actuators import ClampingMaxEffort, ControllerPD, ControllerPID, Delay
from pxr import Sdf, UsdGeom, UsdPhysics
stage = omni.usd.get_context().get_stage()
UsdPhysics.ArticulationRootAPI.Apply(UsdGeom.Xform.Define(stage, "/Robot").GetPrim())
for name in ("base", "link"):
    cube = UsdGeom.Cube.Define(stage, "/Robot/" + name)
    cube.GetSizeAttr().Set(0.2)
    cube.AddTranslateOp().Set((0, 0, name == "link"))
    UsdPhysics.RigidBodyAPI.Apply(cube.GetPrim())
    UsdPhysics.MassAPI.Apply(cube.GetPrim()).GetMassAttr().Set(1.0)
UsdPhysics.FixedJoint.Define(stage, "/Robot/hold").GetBody1Rel().SetTargets(["/Robot/base"])
hinge = UsdPhysics.RevoluteJoint.Define(stage, "/Robot/hinge")
hinge.GetAxisAttr().Set("Y")
hinge.GetBody0Rel().SetTargets(["/Robot/base"])
hinge.GetBody1Rel().SetTargets(["/Robot/link"])
hinge.GetLocalPos0Attr().Set((0, 0, 1))
drive = UsdPhysics.DriveAPI.Apply(hinge.GetPrim(), "angular")
drive.GetStiffnessAttr().Set(1e4)
drive.GetDampingAttr().Set(1e3)
timeline = omni.timeline.get_timeline_interface()
"""


def test_a_prim_and_python_make_the_same_actuator(run_script):
    text = """
add_actuator("/Robot", "hinge", "first", PIDControlConfig(kp=1.0, ki=0.5, kd=0.1), delay=DelayConfig(2),
             clamping=[MaxEffortClampingConfig(0.2), PositionBasedClampingConfig([0.0, 1.0], [3.0, 4.0])])
with ArticulationActuators("/Robot") as robot:
    (found,) = robot.actuators
    print(type(found.controller) is ControllerPID, found.controller.ki, found.delay.delay_steps)
    print([type(one).__name__ for one in found.clamping], robot.actuated_dof_indices)
    timeline.play()
    app.update()
    other = Articulation("/Robot")
    other.set_dof_position_targets([[0.1]])
    print(robot.articulation.get_dof_position_targets().numpy().astype(float).round(6).tolist())
    print([one.numpy().tolist() for one in other.get_dof_gains()])
app.close()
"""
    code, out, err = run_script(SCENE + text)
    assert code == 0, err
    assert out.splitlines() == [
        "True 0.5 2",
        "['ClampingMaxEffort', 'ClampingPositionBased'] [0]",
        "[[0.1]]",  # what one wrapper commands, all read
        "[[[0.0]], [[0.0]]]",
    ]


def test_python_gives_efforts_with_feedforward_within_the_limit(run_script):
    text = """
config = ActuatorConfig(ControllerPD(kp=0.001, kd=0.0), [ClampingMaxEffort(0.004)])
robot = ArticulationActuators.from_actuators("/Robot", [(config, "hinge")], auto_step_pre_physics=False)
timeline.play()
app.update()
robot.articulation.set_dof_position_targets(1.0)
for feedforward in (0.002, 10.0):
    robot.set_dof_feedforward_effort_targets(feedforward)
    robot.step_actuators(1 / 60)
    print(robot.articulation.get_dof_efforts().numpy().astype(float).round(6).tolist())
robot.close()
app.close()
"""
    code, out, err = run_script(SCENE + text)
    assert code == 0, err
    assert out.splitlines() == ["[[0.003]]", "[[0.004]]"]  # 0.001 x 1 + 0.002; then the limit


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ('add_actuator("/Robot", "elbow", "a", PDControlConfig(1.0, 1.0))', "are called 'elbow'; it has hinge, hold"),
        ('add_actuator("/Robot", "hinge", "a", DelayConfig(1))', "is not one of PDControlConfig"),
        ('ArticulationActuators.from_actuators("/Robot", [(ActuatorConfig(3), "hinge")])', "builtins.int does not run"),
        (
            'add_actuator("/Robot", "hinge", "a", NeuralControlConfig("net.pt")); ArticulationActuators("/Robot")',
            "neural networks do not run here",
        ),
    ],
)
def test_wrong_actuators_are_refused(run_script, call, said):
    code, _, err = run_script(SCENE + call)
    assert code != 0
    assert said in err
