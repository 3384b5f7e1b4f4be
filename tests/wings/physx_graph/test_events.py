"""Contacts and triggers: a ball that falls 0.1 m onto the ground, and one that falls through a volume."""

from graph.testing import run_node
from tests.wings.physx_graph.test_queries import app_of

GROUND = {"/World/Ground": {"type": "Plane"}}


def test_a_contact_begins_lasts_and_ends(tmp_path):
    """0.1 m of free fall take sqrt(0.2 / 9.81) = 0.143 s, 9 updates of 1/60 s; at update 30 the ball is lifted."""
    ball = {"type": "Sphere", "radius": 0.1, "translate": [0, 0, 0.2], "rigid_body": True, "mass": 1.0}
    with app_of(tmp_path, {**GROUND, "/World/Ball": ball}) as app:

        def lift(update, node):
            if update == 30:
                app.simulation.tensors.set_poses([[0.0, 0.0, 5.0]], bodies=["/World/Ball"])

        inputs = {"bodyPaths": ["/World/Ball"]}
        trace = run_node("omni.physx.graph.OnContactEventBasic", inputs=inputs, updates=40, app=app, on_update=lift)
    (begin,) = trace.fired("foundExecOut")
    assert 7 <= begin <= 10
    assert trace.fired("persistsExecOut")[:5] == list(range(begin + 1, begin + 6))
    (end,) = trace.fired("lostExecOut")
    assert 29 <= end <= 31
    assert trace.values("contactingBody")[begin] == "/World/Ground"


def test_what_enters_and_leaves_a_trigger_is_told_once_each(tmp_path):
    """From 1 m down the ball enters the volume of 0.4 m about z = 0.5 at z = 0.8, and leaves it at z = 0.2."""
    ball = {"type": "Sphere", "radius": 0.1, "translate": [0, 0, 1.0], "rigid_body": True, "mass": 1.0}
    volume = {"type": "Cube", "size": 0.4, "translate": [0, 0, 0.5], "schemas": ["PhysxTriggerAPI"]}
    with app_of(tmp_path, {"/World/Ball": ball, "/World/Gate": volume}) as app:
        inputs = {"triggersPaths": ["/World/Gate"]}
        trace = run_node("omni.physx.graph.OnTriggerCollider", inputs=inputs, updates=40, app=app)
    (enter,), (leave,) = trace.fired("enterExecOut"), trace.fired("leaveExecOut")
    assert abs(enter - 60 * (2 * 0.2 / 9.81) ** 0.5) < 3
    assert abs(leave - 60 * (2 * 0.8 / 9.81) ** 0.5) < 3
    assert trace.values("otherBody")[enter] == "/World/Ball"
    assert trace.values("triggerCollider")[enter] == "/World/Gate"


def test_a_contact_event_gives_the_points_and_what_holds_the_body(tmp_path):
    """A cube of 1 kg rests on the ground: impulses of a step of 1/60 s add up to 9.81 / 60 N s, upwards."""
    cube = {"type": "Cube", "size": 0.2, "translate": [0, 0, 0.1], "rigid_body": True, "mass": 1.0}
    with app_of(tmp_path, {**GROUND, "/World/Cube": cube}) as app:
        inputs = {"bodyPaths": ["/World/Cube"]}
        trace = run_node("omni.physx.graph.OnContactEventAdvanced", inputs=inputs, updates=60, app=app)
    last = trace.fired("persistsExecOut")[-1]
    names = ("inputBody", "inputBodyCollider", "contactingBody", "contactingCollider")
    assert [trace.values(name)[last] for name in names] == ["/World/Cube"] * 2 + ["/World/Ground"] * 2
    points, normals, impulses = (trace.values(f"contact{name}")[last] for name in ("Points", "Normals", "Impulses"))
    assert len(points) == len(normals) == len(impulses) == len(trace.values("contactDepths")[last])
    assert abs(sum(one[2] for one in impulses) - 9.81 / 60) < 0.01
    assert all(abs(one[2] - 1) < 1e-3 for one in normals)
    assert all(abs(one[2]) < 0.01 for one in points)
    assert trace.values("inputBodyFaces")[last].tolist() == [-1] * len(points)
