"""What goes wrong while physics runs is one warning."""

import pytest

from graph.sim import App

PLANE = {"/Ground": {"type": "Plane"}}
NO_GRAVITY = {"/Scene": {"type": "PhysicsScene", "attributes": {"physics:gravityMagnitude": 0.0}}}


def tower(count, size=0.2):
    """Boxes on a plane, one on the other."""
    return PLANE | {
        f"/Box{i}": {"type": "Cube", "size": size, "translate": [0, 0, (i + 0.5) * size], "rigid_body": True}
        for i in range(count)
    }


def told(app, code):
    return [(warning.where, warning.message) for warning in app.warnings if warning.code == code]


@pytest.mark.parametrize(
    ("solver", "iterations", "warned"),
    [("newton", 3, True), ("newton", 100, False), ("pgs", 3, True), ("pgs", 100, False)],
)
def test_a_solver_far_from_done_at_its_cap_is_one_warning(solver, iterations, warned):
    """The tower of the measurement at `RESIDUAL`: it falls apart at 3 iterations, and stands at 100."""
    with App(physics_hz=240, fidelity={"physics.solver": solver, "physics.iterations": iterations}) as app:
        app.add_prims(tower(20))
        app.play()
        app.update(steps=60)
        found = told(app, "solver-not-converged")
        top = app.simulation.tensors.positions[-1, 2]
    assert len(found) == warned
    if warned:
        assert "stopped after 3 iterations" in found[0][1]
    else:
        assert top == pytest.approx(19.5 * 0.2, abs=0.01)


def test_a_body_that_has_left_the_scene_is_one_warning():
    """10 m within 1000 km at 100 m/s: it is outside after 0.1 s, and bodies are looked for every 64 updates."""
    ball = {"type": "Sphere", "radius": 1, "rigid_body": True, "translate": [999_990, 0, 0], "velocity": [100, 0, 0]}
    near = {"type": "Sphere", "radius": 1, "rigid_body": True}
    with App(physics_hz=60) as app:
        app.add_prims(NO_GRAVITY | {"/Lost": ball, "/Near": near})
        app.play()
        app.update(steps=63)
        assert told(app, "body-far-away") == []
        app.update(steps=200)
        (where, message), *more = told(app, "body-far-away")
    assert (where, more) == ("/Lost", [])
    assert message.startswith("it is more than 1000 km from the origin")


def test_contacts_that_mujoco_has_no_memory_for_are_one_warning_and_nothing_on_the_terminal(tmp_path, capfd):
    """100 boxes on a plane have 400 contacts; 100 KB hold fewer (a contact takes more than half a KB)."""
    boxes = "".join(
        f"<body pos='{i % 10} {i // 10} .0995'><freejoint/><geom type='box' size='.1 .1 .1'/></body>"
        for i in range(100)
    )
    file = tmp_path / "boxes.xml"
    file.write_text(
        f"<mujoco><size memory='100K'/><worldbody><geom type='plane' size='9 9 1'/>{boxes}</worldbody></mujoco>"
    )
    with App(mjcf=file) as app:
        app.play()
        app.update(steps=10)
        found = told(app, "contacts-dropped")
    assert len(found) == 1
    assert "raise <size memory> of the model" in found[0][1]
    assert capfd.readouterr() == ("", "")
