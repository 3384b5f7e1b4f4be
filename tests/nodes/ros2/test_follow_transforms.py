"""Prims that follow transforms from outside."""

import math

import pytest

from graph import ComputeError
from graph.testing import run_node

TF = "tf2_msgs/msg/TFMessage"
HALF = math.sqrt(0.5)


def transform(parent, child, place, rotation=(0, 0, 0, 1)):
    return {
        "header": {"frame_id": parent}, "child_frame_id": child,
        "transform": {
            "translation": dict(zip("xyz", place, strict=True)), "rotation": dict(zip("xyzw", rotation, strict=True)),
        },
    }  # fmt: skip


def place(app, path):
    return app.fabric.world_matrix(path)[:3, 3].tolist()


@pytest.fixture
def props(stage):
    """/Base at (10, 0, 0) turned 90 degrees to the left and scaled by 2, /Thing at 0 and the free /Ball at height 5."""
    from pxr import UsdGeom, UsdPhysics

    base = UsdGeom.Xform.Define(stage, "/Base")
    base.AddTranslateOp().Set((10, 0, 0))
    base.AddRotateZOp().Set(90)
    base.AddScaleOp().Set((2, 2, 2))
    UsdGeom.Xform.Define(stage, "/Thing")
    ball = UsdGeom.Sphere.Define(stage, "/Ball")
    ball.GetRadiusAttr().Set(0.1)
    ball.AddTranslateOp().Set((0, 0, 5))
    UsdPhysics.RigidBodyAPI.Apply(ball.GetPrim())
    UsdPhysics.MassAPI.Apply(ball.GetPrim()).GetMassAttr().Set(1.0)
    return stage


def follow(app, updates, on_update=None, **inputs):
    inputs = {"frameNamesMap": ["/Base", "base", "/Thing", "thing", "/Ball", "ball"], **inputs}
    return run_node(
        "ROS2SubscribeTransformTree", inputs=inputs, pulses={"execIn": range(updates)},
        updates=updates, app=app, on_update=on_update,
    )  # fmt: skip


def test_a_prim_goes_to_its_place_in_the_parent_frame(props, world, says, play):
    app = world()
    play(app, ("1/30", "/tf", TF, says(TF, transforms=[transform("base", "thing", (1, 2, 3), (HALF, 0, 0, HALF))])))
    trace = follow(app, 3)
    assert trace.fired("execOut") == [1]
    # The base looks along +y: 1 ahead is +y, 2 to the left is -x; its scale does not count.
    assert place(app, "/Thing") == pytest.approx([8, 1, 3])
    # Turned by 90 degrees about the base's x axis: the thing's z axis is the base's -y, the world's +x.
    assert app.fabric.world_matrix("/Thing")[:3, 2].tolist() == pytest.approx([1, 0, 0])


def test_all_waiting_messages_are_taken_at_once_and_chains_work(props, world, says, play):
    app = world(physics_hz=240)
    first = says(TF, transforms=[transform("base", "thing", (1, 0, 0))])
    second = says(TF, transforms=[transform("thing", "ball", (1, 0, 0)), transform("moon", "thing", (9, 9, 9))])
    play(app, (0, "/tf", TF, first), ("1/120", "/tf", TF, second))
    trace = follow(app, 2)
    assert trace.fired("execOut") == [0]
    assert place(app, "/Thing") == pytest.approx([10, 1, 0])
    assert place(app, "/Ball") == pytest.approx([10, 2, 0])


def test_a_body_stays_where_it_was_put(props, world, says, play):
    app = world(physics_hz=240)
    play(app, (0, "/tf", TF, says(TF, transforms=[transform("base", "ball", (0, 0, 4))])))
    follow(app, 30)
    assert place(app, "/Ball") == pytest.approx([10, 0, 4])


def test_a_stop_lets_go(props, world, says, play):
    app = world(physics_hz=240)
    play(app, ("1/60", "/tf", TF, says(TF, transforms=[transform("base", "ball", (0, 0, 4))])))
    seen = []

    def stop_and_play(update, node):
        if update == 2:
            seen.append(node.db.memory.stop_holding is None)
            app.stop()
            seen.extend([node.db.memory.stop_holding is None, app.bus.is_listened_to("/tf"), place(app, "/Ball")])

    follow(app, 3, on_update=stop_and_play)
    assert seen == [False, True, False, [0, 0, 5]]


@pytest.mark.parametrize("named", ["/Robot", "/Robot/hand", "/Robot/wrist"])
def test_a_robot_is_moved_by_its_root_link_whatever_of_its_prims_names_it(named, props, world, says, play):
    """The arm is the root link, the hand hangs on it 1 m ahead; (1, 2, 3) in the base's frame is (8, 1, 3)."""
    from pxr import UsdGeom, UsdPhysics

    UsdPhysics.ArticulationRootAPI.Apply(UsdGeom.Xform.Define(props, "/Robot").GetPrim())
    for name, x in (("arm", 0), ("hand", 1)):
        link = UsdGeom.Cube.Define(props, f"/Robot/{name}")
        link.GetSizeAttr().Set(0.2)
        link.AddTranslateOp().Set((x, 0, 20))
        UsdPhysics.RigidBodyAPI.Apply(link.GetPrim())
    joint = UsdPhysics.FixedJoint.Define(props, "/Robot/wrist")
    joint.GetBody0Rel().SetTargets(["/Robot/arm"])
    joint.GetBody1Rel().SetTargets(["/Robot/hand"])
    joint.GetLocalPos0Attr().Set((1, 0, 0))
    app = world()
    play(app, (0, "/tf", TF, says(TF, transforms=[transform("base", "robot", (1, 2, 3), (0, 0, -HALF, HALF))])))
    trace = follow(app, 3, frameNamesMap=["/Base", "base", named, "robot"], articulationRoots=[named])
    assert (place(app, "/Robot/arm"), list(trace.warnings)) == (pytest.approx([8, 1, 3], abs=1e-3), [])
    assert place(app, "/Robot/hand") == pytest.approx([9, 1, 3], abs=1e-3)


def test_a_transform_without_rotation_is_left_out(props, world, says, play):
    app = world()
    play(app, (0, "/tf", TF, says(TF, transforms=[transform("base", "thing", (1, 2, 3), (0, 0, 0, 0))])))
    trace = follow(app, 1)
    assert place(app, "/Thing") == [0, 0, 0]
    assert [warning.code for warning in trace.warnings] == ["tf-rotation-invalid"]


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"frameNamesMap": ["/Base"]}, "frameNamesMap has 1 entries; it needs pairs"),
        ({"frameNamesMap": ["/Base", "a", "/Thing", "a"]}, "frameNamesMap names a twice"),
        ({"frameNamesMap": ["/Base", "a", "/Base", "b"]}, "frameNamesMap names /Base twice"),
        ({"frameNamesMap": ["/Gone", "a"]}, "there is no prim /Gone on the stage"),
        ({"articulationRoots": ["robot"]}, "there is no prim robot on the stage"),
        ({"articulationRoots": ["/Thing"]}, "articulationRoots: /Thing has no articulation"),
    ],
)
def test_a_map_that_makes_no_sense_stops_the_run(props, world, inputs, message):
    with pytest.raises(ComputeError, match=message):
        follow(world(), 1, **inputs)
