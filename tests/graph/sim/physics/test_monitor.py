"""What goes wrong while physics runs is one warning."""

import statistics
from fractions import Fraction

import pytest

from graph.base.errors import RunError
from graph.sim import App
from tests.support.without_wing import needs_wing

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


@pytest.mark.parametrize(("solver", "median"), [("newton", 1), ("cg", 8), ("pgs", 300)])
def test_a_tower_at_rest_takes_the_iterations_that_the_knob_says(solver, median):
    """Measured, not derived: within a fifth of the figures in the text of `physics.solver`."""
    taken = []
    with App(physics_hz=240, loop_hz=240, fidelity={"physics.solver": solver, "physics.iterations": 5000}) as app:
        app.add_prims(tower(10))
        app.play()
        for _ in range(120):
            app.update()
            taken.append(app.physics.data.solver_niter.max())
    assert statistics.median(taken[20:]) == pytest.approx(median, rel=0.2)


@pytest.mark.parametrize("iterations", [2, 3, 4, 5, 6, 8, 10])
@pytest.mark.parametrize("hz", [60, 240])
def test_a_tower_that_falls_for_want_of_iterations_is_one_warning(hz, iterations):
    """Ten boxes stand, 1 to 3 mm lower than their sizes; where they do not, an unfinished step threw them."""
    with App(physics_hz=hz, fidelity={"physics.iterations": iterations}) as app:
        app.add_prims(tower(10))
        app.play()
        app.update(steps=2 * hz)
        error = abs(app.simulation.tensors.positions[-1] - [0, 0, 1.9]).max()
        assert len(told(app, "solver-not-converged")) == (error > 0.01)


@pytest.mark.parametrize(("mass", "size"), [(1e5, 1.0), (1e7, 1.0), (1e9, 1.0), (1e2, 0.02), (1e9, 0.02), (1e9, 0.01)])
@pytest.mark.parametrize("on_ground", [False, True])
def test_a_light_crate_rests_on_a_ship_of_any_mass(mass, size, on_ground):
    """It sinks in by (1 / d - 1) g T2 with d = 0.99 and T = 2 dt, as on a static block: 0.06 mm at 60 Hz.

    A ship that falls freely carries it along: both fall by g t2 / 2.
    """
    side = 20.0
    ship = {"type": "Cube", "size": side, "translate": [0, 0, side / 2], "rigid_body": True, "mass": mass}
    crate = {"type": "Cube", "size": size, "translate": [4, 3, side + size / 2], "rigid_body": True}
    prims = {"/Ship": ship, "/Crate": {**crate, "mass": 1000.0 * size**3}}
    with App(physics_hz=60) as app:
        app.add_prims((PLANE if on_ground else {}) | prims)
        app.play()
        app.update(steps=60)
        places = app.simulation.tensors.positions
        assert told(app, "solver-not-converged") == []
    sunk = side / 2 + size / 2 - (places[1, 2] - places[0, 2])
    assert places[1, :2] == pytest.approx([4, 3], abs=2e-5)
    assert -1e-6 < sunk < 1e-4


def test_a_body_that_has_left_the_scene_is_one_warning():
    """10 m within 1000 km at 100 m/s: it is outside after 0.1 s, and bodies are looked for after 64 steps."""
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


def boxes(lower, upper):
    """Two boxes of these masses [kg], one on the other."""
    box = {"type": "Cube", "size": 0.5, "rigid_body": True}
    first = {**box, "translate": [0, 0, 0.25], "mass": lower}
    return PLANE | {"/Lower": first, "/Upper": {**box, "translate": [0, 0, 0.75], "mass": upper}}


@pytest.mark.parametrize(("ratio", "softness", "sinks"), [(1e3, 1.0, False), (1e4, 1.0, True), (1e4, 0.1, False)])
def test_a_body_that_a_heavy_one_presses_in_is_a_warning_with_the_ratio_of_the_masses(ratio, softness, sinks):
    """About 5 um times the ratio times the softness: 5, 50 and 5 mm."""
    with App(physics_hz=240, fidelity={"physics.contact_softness": softness}) as app:
        app.add_prims(boxes(1.0, ratio))
        app.play()
        app.update(steps=130)
        found = told(app, "bodies-sink")
        depth = 0.25 - app.simulation.tensors.positions[0, 2]
    assert depth == pytest.approx(5e-6 * ratio * softness, rel=0.05)
    assert [where for where, _ in found] == ["/Lower"] * sinks
    if sinks:
        before, _, after = found[0][1].partition(" m and stay so: /Upper, which bears on it, has 1e+04 times")
        assert float(before.removeprefix("it and static geometry overlap by ")) == pytest.approx(depth, rel=0.05)
        assert after


def test_what_has_just_hit_the_ground_does_not_sink():
    """10 m/s at 60 Hz are 0.17 m in a step, so it is deep in the ground now and then, never for a second."""
    ball = {"type": "Sphere", "radius": 0.5, "rigid_body": True, "translate": [0, 0, 5.5]}
    with App(physics_hz=60) as app:
        app.add_prims(PLANE | {"/Ball": ball})
        app.play()
        app.update(steps=300)
        assert told(app, "bodies-sink") == []


@needs_wing("mjcf")
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


@pytest.mark.parametrize("watched", [False, True])
@pytest.mark.parametrize("steps", [1, 2, 3, 4])
def test_a_divergence_is_told_at_its_step_whoever_watches(steps, watched):
    """1e6 m/s at 240 Hz: the last of these steps goes beyond 1e10 m, by half a step. 4 steps an update."""
    start = 1e10 - (steps - 0.5) * 1e6 / 240
    ball = {"type": "Sphere", "radius": 1, "rigid_body": True, "translate": [start, 0, 0], "velocity": [1e6, 0, 0]}
    with App(physics_hz=240, loop_hz=60) as app:
        app.add_prims(NO_GRAVITY | {"/Ball": ball})
        if watched:
            app.on("physics_post_step", lambda: None)
        app.play()
        with pytest.raises(RunError, match=rf"diverged here, at {steps / 240:.6g} s of physics: a position became"):
            app.update()
        assert app.simulation.time == Fraction(steps - 1, 240)
