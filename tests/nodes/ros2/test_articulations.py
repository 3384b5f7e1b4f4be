"""Every node takes the articulation of a prim by its joints: from its root, a link, a joint, or a prim above."""

import pytest

from graph.sim import App, MemorySink
from graph.testing import run_node
from tests.support.jointed_robots import ROOTS, TWO_ROBOTS, define_ball, define_robot
from tests.support.without_wing import needs_wing

WALKER = [("world", "torso"), ("torso", "leg"), ("leg", "foot")]
ARM = [("world", "stand"), ("stand", "arm")]


@pytest.fixture
def models(tmp_path):
    """A playing world of the two MJCF robots."""
    (tmp_path / "robots.xml").write_text(TWO_ROBOTS)
    with App(mjcf=tmp_path / "robots.xml") as app:
        app.sink = MemorySink()
        app.bus.subscribe(app.sink)
        yield app


def once(app, kind, **inputs):
    return run_node(kind, inputs=inputs, pulses={"execIn": [1]}, updates=2, app=app)


def edges(app, target):
    once(app, "ROS2PublishTransformTree", targetPrims=[target])
    transforms = app.sink["/tf"][-1].message.transforms
    return [(one.header.frame_id, one.child_frame_id) for one in transforms]


def names(app, target):
    once(app, "ROS2PublishJointState", targetPrim=[target])
    return list(app.sink["/joint_states"][-1].message.name)


@needs_wing("mjcf")
@pytest.mark.parametrize(
    ("target", "frames"),
    [
        ("/World/torso", WALKER),
        ("/World/leg/hip_yaw_l", WALKER),
        ("/World/leg", [("world", "leg")]),
        ("/World/stand", ARM),
        ("/World/ball", [("world", "ball")]),
    ],
)
def test_the_tree_of_a_models_robot_is_its_own_links(models, target, frames):
    assert edges(models, target) == frames


@needs_wing("mjcf")
@pytest.mark.parametrize(
    ("target", "joints"),
    [
        *((f"/World/{link}", ["hip-yaw.l"]) for link in ("torso", "leg", "foot", "leg/hip_yaw_l", "foot/foot_weld")),
        *((f"/World/{link}", ["elbow"]) for link in ("stand", "arm", "arm/elbow")),
    ],
)
def test_joint_states_have_the_models_names_from_any_prim_of_the_robot(models, target, joints):
    assert names(models, target) == joints


@needs_wing("mjcf")
@pytest.mark.parametrize("name", ["hip-yaw.l", "hip_yaw_l"])
def test_commands_take_the_models_name_and_the_prims(models, name):
    trace = once(models, "IsaacArticulationState", targetPrim=["/World/torso"], jointNames=[name])
    assert trace.value("jointNames") == ["hip-yaw.l"]
    once(models, "IsaacArticulationController", targetPrim=["/World/torso"], jointNames=[name], effortCommand=[1.0])


@pytest.fixture(params=ROOTS)
def yard(request, stage, world):
    """A world with a robot, its root API somewhere, another robot and a ball beside it in one Xform."""
    root = define_robot(stage, "/World/Robot", request.param)
    define_robot(stage, "/World/Other", request.param, (10, 0, 0))
    define_ball(stage, "/World/Robot/ball")
    app = world()
    app.root = root
    return app


def test_every_node_takes_the_root_of_a_usd_robot_wherever_it_is(yard):
    assert edges(yard, yard.root) == [("world", "base"), ("base", "arm")]
    assert names(yard, yard.root) == ["hinge"]
    for target in (yard.root, "/World/Robot/arm", "/World/Robot/hinge"):
        assert once(yard, "IsaacArticulationState", targetPrim=[target]).value("jointNames") == ["hinge"]
        assert once(yard, "IsaacReadJointState", prim=[target]).value("jointNames") == ["hinge"]
        once(yard, "IsaacArticulationController", targetPrim=[target], effortCommand=[1.0])
        assert once(yard, "IsaacJointNameResolver", targetPrim=[target], jointNames=["x"]).value("jointNames") == ["x"]


def test_odometry_takes_the_root_link_that_moves(stage, world):
    define_robot(stage, "/World/Robot", "above", (0, 0, 9), free=True)
    define_robot(stage, "/World/Other", "above", (10, 0, 0))
    define_ball(stage, "/World/Robot/a_ball")
    app = world()
    trace = once(app, "IsaacComputeOdometry", chassisPrim=["/World/Robot"])
    fallen = app.fabric.world_matrix("/World/Robot/base")[2, 3] - 9
    assert fallen < 0
    assert trace.value("position")[2] == pytest.approx(0, abs=1e-9)  # the first reading
    assert trace.value("globalLinearVelocity")[2] < 0


def test_an_overridden_joint_name_is_in_messages_and_commands(stage, world):
    from pxr import Sdf

    define_robot(stage, "/World/Robot", "link")
    hinge = stage.GetPrimAtPath("/World/Robot/hinge")
    hinge.CreateAttribute("isaac:nameOverride", Sdf.ValueTypeNames.String).Set("left.hinge")
    app = world()
    assert names(app, "/World/Robot") == ["left.hinge"]
    once(app, "IsaacArticulationController", targetPrim=["/World/Robot"], jointNames=["left.hinge"], effortCommand=[1])


@needs_wing("mjcf")
def test_a_sensor_that_excludes_a_robot_hits_none_of_its_links(models):
    from sensors.prim import read_exclude, write_exclude

    prim = models.stage.DefinePrim("/World/torso/Lidar", "OmniLidar")
    for excluded, hidden in (
        ("/World/torso", ["foot", "leg", "torso"]),
        ("/World/stand", ["arm", "stand"]),
        ("/World/leg", ["leg"]),
    ):
        write_exclude(prim, (excluded,))
        assert sorted(read_exclude(prim)) == [f"/World/{name}" for name in hidden]


@needs_wing("mjcf")
@pytest.mark.parametrize(("excluded", "nearest"), [("/World/torso", 4.9), ("/World/wall", 0.9)])
def test_a_walkers_lidar_sees_other_robots_and_not_its_own_legs(tmp_path, excluded, nearest):
    # The balls of 0.1 m of its leg and of the stand are 1 and 5 m from the lidar, the wall at 6 m.
    wall = '<geom name="wall" type="box" size="9 .5 9" pos="0 6.5 0"/></worldbody>'
    text = TWO_ROBOTS.replace('<geom name="trunk" size=".1"/>', '<geom name="hull" size=".01" pos="-1 0 0"/>')
    (tmp_path / "robots.xml").write_text(text.replace("</worldbody>", wall))
    (tmp_path / "g.yaml").write_text(
        "tickgraph: 1\nscene:\n  mjcf: robots.xml\n  prims:\n    /World/torso/Lidar: {type: OmniLidar, "
        f"config: Example_Rotary_2D, exclude: [{excluded}]}}\n"
    )
    from sensors import LidarSensor, parse_generic_model_output_data

    with App.from_file(tmp_path / "g.yaml") as app:
        sensor = LidarSensor("/World/torso/Lidar", annotators=["generic-model-output"], app=app)
        app.play()
        app.update(7)
        frame = parse_generic_model_output_data(sensor.get_data("generic-model-output")[0])
    assert min(frame.z) == pytest.approx(nearest, abs=0.02)
