"""Walking robots as their makers' MJCF models are, of 12 and 29 joints on a free base: every node takes all of one."""

import numpy as np
import pytest

from graph.sim import App, MemorySink
from graph.testing import run_node
from tests.support.mjcf_robots import humanoid_of_29_joints, quadruped_of_twelve_joints

WALKERS = {"12": quadruped_of_twelve_joints, "29": humanoid_of_29_joints}
STANDS = """<body name="post" pos="2 0 2"><geom name="pole" size=".1"/>
<body name="sign" pos="0 0 .3"><joint name="swing" axis="0 0 1"/><geom name="board" size=".05"/></body></body>
<body name="ball" pos="0 2 2"><freejoint/><geom name="round" size=".1"/></body></worldbody>"""
"""An arm on a post that stays, and a free ball, beside the walker."""


@pytest.fixture(params=WALKERS)
def walker(request, tmp_path):
    """The model in a world without gravity, beside an arm and a ball; `app` plays it, `sink` has what is sent."""
    found = WALKERS[request.param]()
    text = found.text.replace("</worldbody>", STANDS).replace("<default>", '<option gravity="0 0 0"/><default>', 1)
    (tmp_path / "robot.xml").write_text(text)
    with App(mjcf=tmp_path / "robot.xml") as app:
        found.app, found.sink = app, MemorySink()
        app.bus.subscribe(found.sink)
        yield found


def prim(name):
    """The name of a prim or of a frame for a name of the model."""
    return "".join(one if one.isalnum() else "_" for one in name)


def every(app, kind, updates=2, **inputs):
    return run_node(kind, inputs=inputs, pulses={"execIn": range(updates)}, updates=updates, app=app)


def paths(walker):
    """Prims that are the walker: its base, links and joints of all limbs."""
    links = [walker.base, *(link for link, _ in walker.links)]
    return [*(f"/World/{prim(link)}" for link in links), *(f"/World/{prim(b)}/{prim(a)}" for a, b in walker.joints)]


def test_the_tree_has_every_link_below_its_parent_and_nothing_else(walker):
    every(walker.app, "ROS2PublishTransformTree", targetPrims=[f"/World/{prim(walker.base)}"])
    found = [(one.child_frame_id, one.header.frame_id) for one in walker.sink["/tf"][-1].message.transforms]
    links = [(walker.base, "world"), *walker.links]
    assert len(found) == len(links) in (17, 30)
    assert {(prim(child), prim(parent)) for child, parent in found} == {
        (prim(one), prim(other)) for one, other in links
    }


def test_joint_states_have_every_joint_by_the_models_name_whatever_prim_is_named(walker):
    names = [joint for joint, _ in walker.joints]
    for target in paths(walker):
        every(walker.app, "ROS2PublishJointState", targetPrim=[target])
        message = walker.sink["/joint_states"][-1].message
        assert list(message.name) == names, target
        assert len(message.position) == len(message.velocity) == len(message.effort) == len(names) in (12, 29)


def test_joint_states_and_the_tree_of_one_stamp_say_the_same(walker, tmp_path):
    """Each link is turned in its parent by its joint's position; every joint has a force of its own."""
    names, base = [joint for joint, _ in walker.joints], f"/World/{prim(walker.base)}"
    forces = [0.5 * (-1) ** number / (1 + number % 4) for number in range(len(names))]
    (tmp_path / "g.yaml").write_text(
        f"""tickgraph: 1
scene: {{mjcf: robot.xml}}
graphs:
  /G:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      push: {{type: IsaacArticulationController, inputs: {{targetPrim: {base}, jointNames: {names},
        effortCommand: {forces}}}}}
      tree: {{type: ROS2PublishTransformTree, inputs: {{targetPrims: [{base}]}}}}
      joints: {{type: ROS2PublishJointState, inputs: {{targetPrim: {base}}}}}
    connections:
      - tick.tick -> [push.execIn, tree.execIn, joints.execIn]
      - time.simulationTime -> [tree.timeStamp, joints.timeStamp]
"""
    )
    with App.from_file(tmp_path / "g.yaml") as app:
        app.bus.subscribe(sink := MemorySink())
        app.play()
        app.update(8)
    message = sink["/joint_states"][-1].message
    turned = 0
    for (joint, link), angle in zip(walker.joints, message.position, strict=True):
        sent = {prim(one.child_frame_id): one for one in sink["/tf"][-1].message.transforms}[prim(link)]
        assert sent.header.stamp == message.header.stamp
        turn = sent.transform.rotation
        assert 2 * np.arctan2(np.linalg.norm([turn.x, turn.y, turn.z]), turn.w) % (2 * np.pi) == pytest.approx(
            abs(angle), abs=1e-6
        ), joint
        turned += abs(angle) > 1e-4
    assert turned > len(names) / 2


@pytest.mark.parametrize("spelt", ["as in the model", "as the prim"])
def test_a_command_moves_the_joint_that_it_names(walker, spelt):
    names = [joint for joint, _ in walker.joints]
    chosen = names[-1]  # whose reaction moves the others less
    called = chosen if spelt == "as in the model" else prim(chosen)
    target = [f"/World/{prim(walker.links[3][0])}"]  # any link
    inputs = {"targetPrim": target, "jointNames": [called], "effortCommand": [2.0]}
    every(walker.app, "IsaacArticulationController", updates=3, **inputs)
    trace = every(walker.app, "IsaacArticulationState", targetPrim=target, jointNames=[called])
    assert trace.value("jointNames") == [chosen]
    every(walker.app, "ROS2PublishJointState", targetPrim=target)
    message = walker.sink["/joint_states"][-1].message
    assert np.argmax(np.abs(message.position)) == names.index(chosen)


def test_a_lidar_that_excludes_any_prim_of_the_walkers_root_has_no_point_of_its_own(walker, tmp_path):
    """It stands amid the limbs; the post is 1.9 m away, its sign and the ball beyond: nothing nearer is left."""
    from sensors.prim import read_exclude, write_exclude

    lidar = walker.app.stage.DefinePrim(f"/World/{prim(walker.base)}/Lidar", "OmniLidar")
    write_exclude(lidar, (f"/World/{prim(walker.base)}",))
    links = {f"/World/{prim(link)}" for link in (walker.base, *(link for link, _ in walker.links))}
    assert set(read_exclude(lidar)) == links
    graph = f"""tickgraph: 1
scene:
  mjcf: robot.xml
  prims:
    /World/{prim(walker.base)}/Lidar:
      {{type: OmniLidar, config: Example_Rotary, exclude: [/World/{prim(walker.base)}]}}
"""
    (tmp_path / "g.yaml").write_text(graph)
    from sensors import LidarSensor, parse_generic_model_output_data

    with App.from_file(tmp_path / "g.yaml") as app:
        sensor = LidarSensor(f"/World/{prim(walker.base)}/Lidar", annotators=["generic-model-output"], app=app)
        app.play()
        app.update(7)
        frame = parse_generic_model_output_data(sensor.get_data("generic-model-output")[0])
    assert len(frame.z) > 50
    assert min(frame.z) > 1.85
