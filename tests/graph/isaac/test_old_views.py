"""Views of `isaacsim.core.prims` have properties by their former names: an arm of two links on a fixed pivot."""

import ast

import pytest

from tests.support.without_wing import needs_wing

pytestmark = needs_wing("stand_ins")

START = """
from isaacsim import SimulationApp
app = SimulationApp()
import numpy as np
import omni.usd, omni.timeline
from isaacsim.core.prims import Articulation, RigidPrim
from isaacsim.storage.native import get_assets_root_path
from pxr import UsdPhysics
arm = get_assets_root_path() + "/Isaac/Robots/IsaacSim/SimpleArticulation/simple_articulation.usd"
omni.usd.get_context().open_stage(arm)
stage = omni.usd.get_context().get_stage()
UsdPhysics.RevoluteJoint(stage.GetPrimAtPath("/Articulation/Arm/RevoluteJoint")).CreateAxisAttr("Y")
omni.timeline.get_timeline_interface().play()
app.update()
robot = Articulation("/Articulation")
show = lambda *found: print([np.round(np.asarray(one, float), 3).tolist() for one in found])
"""


@pytest.fixture
def printed(run_script):
    """The lists that a script prints, one a line."""

    def run(text):
        code, out, err = run_script(f"{START}{text}\napp.close()\n")
        assert code == 0, err
        return [ast.literal_eval(line) for line in out.splitlines()]

    return run


def test_equations_of_motion_and_numbers_of_joints(printed):
    """Arm and slider of 1 kg each, 1 m from the pivot: 19.62 N m hold them, about the axis y with the opposite sign."""
    found = printed("""
show(robot.get_generalized_gravity_forces())
show(robot.get_jacobian_shape(), robot.get_mass_matrix_shape(), robot.get_mass_matrices().shape)
print([robot.get_joint_index("PrismaticJoint"), robot.get_body_index("Arm"), robot.get_articulation_body_count()])
print(robot.get_dof_types(["PrismaticJoint"]))
""")
    assert found[0] == [[[-19.62, 0.0]]]
    assert found[1] == [[2.0, 6.0, 2.0], [2.0, 2.0], [1.0, 2.0, 2.0]]
    assert found[2:] == [[1, 1, 3], ["translation"]]


def test_properties_are_set_and_read_by_joint_by_body_and_whole(printed):
    found = printed("""
robot.set_max_efforts([[5.0, 6.0]])
robot.set_armatures([[0.25]], joint_names=["PrismaticJoint"])
robot.set_body_masses([[1.0, 2.0, 4.0]])
show(robot.get_max_efforts(), robot.get_armatures(), robot.get_body_masses(), robot.get_body_inv_masses())
robot.set_sleep_thresholds([0.5])
robot.set_enabled_self_collisions([True])
robot.set_solver_position_iteration_counts([7])
robot.set_body_disable_gravity([[True]], body_indices=[1])
show(robot.get_sleep_thresholds(), robot.get_enabled_self_collisions(), robot.get_solver_position_iteration_counts())
show(robot.get_body_disable_gravity())
robot.set_joint_efforts([[3.0, 4.0]])
show(robot.get_applied_joint_efforts(joint_indices=[1]), robot.get_joints_state().efforts)
robot.switch_control_mode("effort")
show(*robot.get_gains())
""")
    assert found == [
        [[[5.0, 6.0]], [[0.0, 0.25]], [[1.0, 2.0, 4.0]], [[1.0, 0.5, 0.25]]],
        [[0.5], [1.0], [7.0]],
        [[[0.0, 1.0, 0.0]]],
        [[[4.0]], [[3.0, 4.0]]],
        [[[0.0, 0.0]], [[0.0, 0.0]]],
    ]


def test_bodies_of_a_view(printed):
    found = printed("""
body = RigidPrim("/Articulation/Slider")
body.set_densities([0.5])
body.disable_gravities()
show(body.get_densities(), body.get_inv_masses(), body.get_coms()[0], [body.is_physics_handle_valid()])
show([stage.GetPrimAtPath("/Articulation/Slider").GetAttribute("physxRigidBody:disableGravity").Get()])
""")
    assert found == [[[0.5], [1.0], [[0.0, 0.0, 0.0]], [1.0]], [[1.0]]]


def test_colliders_of_a_view(printed):
    found = printed("""
from pxr import UsdGeom
from isaacsim.core.prims import GeometryPrim
omni.timeline.get_timeline_interface().stop()
app.update()
for name in ("a", "b"):
    UsdGeom.Mesh.Define(stage, "/Shapes/" + name)
shapes = GeometryPrim("/Shapes/.*", collisions=[True, True])
shapes.set_contact_offsets([0.02, 0.04])
shapes.set_rest_offsets([0.01], indices=[1])
shapes.set_min_torsional_patch_radii([0.5, 0.25])
shapes.set_collision_approximations(["convexHull", "none"])
shapes.disable_collision(indices=[0])
show(shapes.get_contact_offsets(), shapes.get_rest_offsets()[1:], shapes.get_min_torsional_patch_radii())
show(shapes.is_collision_enabled(), shapes.get_torsional_patch_radii(indices=[0]))
print(shapes.get_collision_approximations())
""")
    assert found == [[[0.02, 0.04], [0.01], [0.5, 0.25]], [[0.0, 1.0], [0.0]], ["convexHull", "none"]]
