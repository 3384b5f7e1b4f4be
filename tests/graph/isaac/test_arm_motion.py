"""The Franka's controllers, solver and tasks: cubes are really gripped, carried and set down."""

import math

import pytest

from tests.support.without_wing import needs_wing

pytestmark = needs_wing("stand_ins")

APP = """
from isaacsim import SimulationApp
app = SimulationApp({"headless": True})
import numpy as np
from isaacsim.core.api import World
world = World(stage_units_in_meters=1.0)
"""
PICK_PLACE = f"""{APP}
from isaacsim.robot.manipulators.examples.franka.controllers.pick_place_controller import PickPlaceController
from isaacsim.robot.manipulators.examples.franka.tasks import PickPlace
task = PickPlace()
world.add_task(task)
world.reset()
params = task.get_params()
robot = world.scene.get_object(params["robot_name"]["value"])
cube = params["cube_name"]["value"]
controller = PickPlaceController(name="controller", gripper=robot.gripper, robot_articulation=robot)
"""


@pytest.fixture
def lines(run_script):
    def run(text):
        code, out, err = run_script(text)
        assert code == 0, err
        return out.splitlines()

    return run


def test_a_cube_is_gripped_lifted_carried_and_set_down(lines):
    highest, phases, calls, *place = lines(f"""{PICK_PLACE}
highest, phases = 0.0, []
for _ in range(1000):
    world.step(render=False)
    seen = world.get_observations()
    place = seen[cube]["position"]
    highest = max(highest, float(place[2]))
    joints = seen[robot.name]["joint_positions"]
    action = controller.forward(place, seen[cube]["target_position"], joints)
    robot.get_articulation_controller().apply_action(action)
    phases.append(controller.get_current_event())
    if controller.is_done():
        break
print(highest)
print(sorted(set(phases)))
print(len(phases))
for one in (*place, *robot.get_joint_positions()[-2:]):
    print(float(one))
app.close()
""")
    assert 0.25 < float(highest) < 0.31  # the fingertips go to 0.3 m
    assert phases == "[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10]"
    # 1 / share calls of each phase: 125 + 200 + 1 + 10 + 20 + 20 + 400 + 1 + 125 + 13; floats may add up to a bit less
    assert 915 <= int(calls) <= 920
    x, y, z, left, right = map(float, place)
    assert math.hypot(x + 0.3, y + 0.3) < 0.03
    assert abs(z - 0.0515 / 2) < 0.001  # it lies on the ground
    assert min(left, right) > 0.039


def test_the_phases_can_pause_begin_again_and_be_fewer(lines):
    assert lines(f"""{PICK_PLACE}
controller = PickPlaceController("short", robot.gripper, robot, events_dt=[0.5, 0.5])
seen = world.get_observations()
def step():
    return controller.forward(seen[cube]["position"], seen[cube]["target_position"], robot.get_joint_positions())
controller.pause()
print(step().joint_positions, controller.get_current_event())
controller.resume()
for _ in range(4):
    step()
print(controller.is_done(), step().joint_positions)
controller.reset()
print(controller.is_done(), controller.get_current_event())
app.close()
""") == [f"{[None] * 9} 0", f"True {[None] * 9}", "False 0"]


def test_the_solver_finds_joint_positions_within_their_limits(lines):
    reached, error, turn, far = lines(f"""{APP}
from isaacsim.robot.manipulators.examples.franka import Franka, KinematicsSolver
robot = world.scene.add(Franka("/World/Franka", position=np.array([1.0, 0.0, 0.0])))
world.reset()
solver = KinematicsSolver(robot)
down = np.array([0.0, 0.0, 1.0, 0.0])
action, reached = solver.compute_inverse_kinematics(np.array([1.3, -0.35, 0.2]), down)
robot.set_joint_positions([float(one) for one in action.joint_positions[:7]], list(range(7)))
world.step(render=False)
place, axes = solver.compute_end_effector_pose()
low, high = robot.get_articulation_controller().get_joint_limits()[:7].T
print(reached and bool((low <= action.joint_positions[:7]).all() and (action.joint_positions[:7] <= high).all()))
print(float(np.abs(place - [1.3, -0.35, 0.2]).max()))
print(axes.round(2).tolist())
print(solver.compute_inverse_kinematics(np.array([3.0, 0.0, 0.2]), down)[1])
app.close()
""")
    assert reached == "True"
    assert float(error) < 0.002
    # half a turn about y: x and z point the other way; the zeros' signs do not matter
    assert turn.replace("-0.0", "0.0") == "[[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]"
    assert far == "False"


def test_the_hand_follows_a_target(lines):
    (miss,) = lines(f"""{APP}
from isaacsim.robot.manipulators.examples.franka.controllers.rmpflow_controller import RMPFlowController
from isaacsim.robot.manipulators.examples.franka.kinematics_solver import KinematicsSolver
from isaacsim.robot.manipulators.examples.franka.tasks import FollowTarget
task = FollowTarget(target_position=np.array([0.4, -0.3, 0.4]))
world.add_task(task)
world.reset()
params = task.get_params()
robot = world.scene.get_object(params["robot_name"]["value"])
controller, solver = RMPFlowController("lead", robot), KinematicsSolver(robot)
for _ in range(150):
    world.step(render=False)
    target = world.get_observations()[params["target_name"]["value"]]
    action = controller.forward(target["position"], target["orientation"])
    robot.get_articulation_controller().apply_action(action)
print(float(np.linalg.norm(solver.compute_end_effector_pose(True)[0] - target["position"])))
app.close()
""")
    assert float(miss) < 0.005


def test_two_cubes_are_stacked(lines):
    done, *places = lines(f"""{APP}
from isaacsim.robot.manipulators.examples.franka.controllers.stacking_controller import StackingController
from isaacsim.robot.manipulators.examples.franka.tasks import Stacking
task = Stacking()
world.add_task(task)
world.reset()
name = task.get_params()["robot_name"]["value"]
robot = world.scene.get_object(name)
controller = StackingController("stack", robot.gripper, robot, task.get_cube_names(), name)
for _ in range(2000):
    world.step(render=False)
    robot.get_articulation_controller().apply_action(controller.forward(world.get_observations()))
    if controller.is_done():
        break
print(controller.is_done())
for one in task.get_cube_names():
    for value in world.get_observations()[one]["position"]:
        print(float(value))
app.close()
""")
    x1, y1, z1, x2, y2, z2 = map(float, places)
    assert done == "True"
    assert math.hypot(x1 - 0.5, y1 - 0.5) < 0.03
    assert math.hypot(x2 - x1, y2 - y1) < 0.0515 / 2  # its middle is above the one below
    assert z1 == pytest.approx(0.0515 / 2, abs=0.001)
    assert z2 == pytest.approx(0.0515 * 1.5, abs=0.002)


def test_controllers_of_arms_of_other_makers_say_that_they_move_a_franka(run_script):
    code, _, err = run_script(f"""{APP}
from isaacsim.core.api.robots import Robot
from isaacsim.core.utils.stage import add_reference_to_stage
from isaacsim.robot.manipulators.examples.franka.controllers import RMPFlowController
add_reference_to_stage("omniverse://localhost/Isaac/Robots/UniversalRobots/ur10/ur10.usd", "/World/Arm")
robot = world.scene.add(Robot("/World/Arm"))
world.reset()
RMPFlowController("lead", robot).forward([0.5, 0.0, 0.5])
""")
    assert code == 1
    assert "/World/Arm: these controllers move a Franka; it has joints shoulder_pan_joint, " in err
