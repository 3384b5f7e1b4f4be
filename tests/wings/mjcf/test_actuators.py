"""Joint commands reach the actuators that drive the joints; actuators are written and read by name."""

from __future__ import annotations

from contextlib import contextmanager

import numpy as np
import pytest

from graph.base.errors import RunError
from graph.sim import App

ARM = """<mujoco>
  <option timestep="0.002" gravity="0 0 0"/>
  <worldbody>
    <body name="base">
      <geom size=".1" mass="1"/>
      {links}
    </body>
  </worldbody>
  <actuator>{actuators}</actuator>
  {more}
</mujoco>"""
LINK = """<body name="{0}" pos="0 {1} 0"><joint name="{0}" axis="0 0 1" damping="{2}" {3}/>
<geom type="box" size=".1 .1 .1" pos=".5 0 0" mass="1"/></body>"""


def arm(model, actuators, joints=("a",), damping=0.0, more="", kind=""):
    links = "".join(LINK.format(name, 5 * number, damping, kind) for number, name in enumerate(joints))
    return model(ARM.format(links=links, actuators=actuators, more=more))


@contextmanager
def playing(file, robot="/World/base"):
    """An App that plays this model, and the articulation at or above the prim `robot`."""
    with App(mjcf=file) as app:
        app.play()
        yield app, app.physics.articulation(robot)


def test_a_position_command_becomes_the_control_of_a_position_actuator(model):
    """At rest at its target a servo gives no force: with gear 2 and kp 50 the control is 2 q*, and q ends there."""
    file = arm(model, "<position joint='a' kp='50' kv='20' gear='2'/>")
    with playing(file) as (app, robot):
        assert robot.joint_names == ("a",)
        assert robot.driven.tolist() == [True]
        robot.set_targets(positions=[0.3])
        assert app.physics.data.ctrl == pytest.approx([0.6])
        app.simulation.run_steps(3000)
        assert robot.positions == pytest.approx([0.3], abs=1e-6)


def test_a_general_actuator_with_other_gain_and_offset_aims_there_too(model):
    """Force = 0.2 c + 3 - 40 q - 8 dq, so the control for q* = 0.5 is (40 * 0.5 - 3) / 0.2 = 85."""
    file = arm(model, "<general joint='a' gainprm='.2' biastype='affine' biasprm='3 -40 -8'/>")
    with playing(file, "/World/a") as (app, robot):
        robot.set_targets(positions=[0.5])
        assert app.physics.data.ctrl == pytest.approx([85])
        app.simulation.run_steps(4000)
        assert robot.positions == pytest.approx([0.5], abs=1e-6)


def test_a_velocity_command_turns_a_joint_through_a_velocity_actuator(model):
    """kv 4 against the joint's damping 1: 4 (w* - w) = w, so that 2.5 asked for gives 2."""
    file = arm(model, "<velocity joint='a' kv='4'/>", damping=1.0)
    with playing(file) as (app, robot):
        robot.set_targets(velocities=[2.5])
        app.simulation.run_steps(3000)
        assert robot.velocities == pytest.approx([2.0], abs=1e-6)


def test_an_integrating_actuator_takes_a_speed(model):
    file = arm(model, "<intvelocity joint='a' kp='200' kv='40'/>")
    with playing(file) as (app, robot):
        robot.set_targets(velocities=[0.7])
        app.simulation.run_steps(4000)
        assert robot.velocities == pytest.approx([0.7], abs=1e-4)


def test_an_effort_goes_through_the_motor_and_its_limits(model):
    """Gear 5 and controls within 2: 4 N m is the control 0.8, 40 N m the most it gives, 10."""
    file = arm(model, "<motor joint='a' gear='5' ctrllimited='true' ctrlrange='-2 2'/>")
    with playing(file) as (app, robot):
        assert robot.driven.tolist() == [False]
        robot.set_targets(efforts=[4.0])
        assert app.physics.data.ctrl == pytest.approx([0.8])
        app.simulation.run_steps(1)
        assert robot.efforts == pytest.approx([4.0])
        robot.set_targets(efforts=[40.0])
        app.simulation.run_steps(1)
        assert robot.efforts == pytest.approx([10.0])


def test_an_effort_on_a_joint_without_a_motor_acts_by_itself(model):
    """On a body of inertia I about the axis: w = F n dt / I after n steps; I = m (0.25 + (0.04 + 0.04) / 12 ...)."""
    file = arm(model, "")
    inertia = 0.5**2 + (0.2**2 + 0.2**2) / 12
    with playing(file) as (app, robot):
        robot.set_targets(efforts=[1.5])
        app.simulation.run_steps(100)
        assert robot.velocities == pytest.approx([1.5 * 100 * 0.002 / inertia], rel=1e-9)


def test_a_command_leaves_the_other_joints_alone(model):
    servos = "".join(f"<position name='s{name}' joint='{name}' kp='50' kv='10'/>" for name in "abc")
    with playing(arm(model, servos, joints="abc"), "/World/b") as (app, robot):
        assert robot.joint_names == ("a", "b", "c")
        robot.set_targets(positions=[0.1, np.nan, 0.3])
        robot.set_targets(positions=[0.2], joints=[1])
        assert app.physics.data.ctrl == pytest.approx([0.1, 0.2, 0.3])


def test_a_velocity_besides_a_position_adds_the_servos_damping_term(model):
    """kp 50, kv 10: force 50 (q* - q) + 10 (dq* - dq), as a UsdPhysics drive gives it: control q* + 10 / 50 dq*."""
    with playing(arm(model, "<position joint='a' kp='50' kv='10'/>")) as (app, robot):
        robot.set_targets(positions=[0.4], velocities=[2.0])
        assert app.physics.data.ctrl == pytest.approx([0.8])
        robot.set_targets(velocities=[1.0])
        assert app.physics.data.ctrl == pytest.approx([0.6])
        robot.set_targets(positions=[0.5])
        assert app.physics.data.ctrl == pytest.approx([0.7])


def test_controls_are_written_on_the_stage_and_in_fabric_and_read_back(model):
    file = arm(model, "<motor name='left motor' joint='a'/>", more="<sensor><jointvel name='v' joint='a'/></sensor>")
    path = "/World/Actuators/left_motor"
    with App(mjcf=file) as app:
        attribute = app.stage.GetPrimAtPath(path).GetAttribute("mjc:ctrl")
        attribute.Set(0.25)
        app.play()
        assert app.physics.data.ctrl == pytest.approx([0.25])  # what the stage says at play
        attribute.Set(0.5)
        assert app.physics.data.ctrl == pytest.approx([0.5])
        app.fabric.set(path, "mjc:ctrl", -1.0)
        assert app.fabric.get(path, "mjc:ctrl") == -1.0
        app.simulation.run_steps(2)
        assert app.fabric.get(path, "mjc:force") == pytest.approx(-1.0)
        inertia = 0.5**2 + (0.2**2 + 0.2**2) / 12
        # MuJoCo's sensors are those of the state that the last step began with.
        assert app.fabric.get("/World/Sensors/v", "mjc:value") == pytest.approx([-1.0 * 0.002 / inertia])
        with pytest.raises(RunError, match=r"left_motor.mjc:ctrl: actuator left motor takes 1 finite control, not nan"):
            app.fabric.set(path, "mjc:ctrl", float("nan"))
        app.stop()
        assert attribute.Get() == 0.25
        app.play()
        assert app.physics.data.ctrl == pytest.approx([0.25])


def test_a_graph_drives_actuators_by_attribute_and_joints_by_name(model, tmp_path):
    arm(model, "<position name='hold' joint='a' kp='50' kv='20'/><motor name='push' joint='b'/>", joints="ab")
    (tmp_path / "g.yaml").write_text("""tickgraph: 1
scene: {mjcf: model.xml}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      hold:
        type: IsaacArticulationController
        inputs: {targetPrim: [/World/base], jointNames: [a], positionCommand: [0.2]}
      push: {type: WritePrimAttribute, inputs: {prim: [/World/Actuators/push], name: "mjc:ctrl", value: 0.01}}
      seen: {type: ReadPrimAttribute, inputs: {prim: [/World/Actuators/push], name: "mjc:force"}}
      state: {type: IsaacArticulationState, inputs: {targetPrim: [/World/base]}}
    connections:
      - tick.tick -> [hold.execIn, push.execIn, state.execIn]
""")
    with App.from_file(tmp_path / "g.yaml") as app:
        assert app.simulation.steps_per_second == 500
        app.play()
        app.update(steps=240)
        assert app.physics.data.ctrl == pytest.approx([0.2, 0.01])
        inertia = 0.5**2 + (0.2**2 + 0.2**2) / 12
        # The graphs run after physics: the first update's steps are without a control.
        steps = app.simulation.get_num_physics_steps() - 8
        assert app.physics.articulation("/World/b").velocities[1] == pytest.approx(
            0.01 * steps * 0.002 / inertia, rel=1e-6
        )
        assert app.physics.articulation("/World/b").positions[0] == pytest.approx(0.2, abs=1e-3)
        assert not list(app.warnings)


def test_joints_go_by_the_names_of_the_model_too(model, tmp_path):
    """The prim of a joint "left/hip" is left_hip; commands take either name."""
    servo = "<position joint='left/hip' kp='50' kv='20'/><position joint='b' kp='50' kv='20'/>"
    arm(model, servo, joints=("left/hip", "b"))
    for name in ("left/hip", "left_hip"):
        (tmp_path / "g.yaml").write_text(f"""tickgraph: 1
scene: {{mjcf: model.xml}}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      move:
        type: IsaacArticulationController
        inputs: {{robotPath: /World, jointNames: [b, "{name}"], positionCommand: [0.1, 0.2]}}
    connections: [tick.tick -> move.execIn]
""")
        with App.from_file(tmp_path / "g.yaml") as app:
            app.play()
            app.update()
            assert app.physics.data.ctrl == pytest.approx([0.2, 0.1])
