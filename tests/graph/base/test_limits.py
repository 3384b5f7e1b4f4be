"""The table of limits; `tests/robustness/test_bounds.py` takes each at its value and one beyond."""

import json

import pytest

from graph.base import limits
from graph.base.errors import RunError, UserError
from graph.cli.main import main
from graph.sim import App
from graph.sim.fidelity import Fidelity


def test_a_limit_is_changed_for_what_runs_inside_alone():
    before = limits.most("lidar.bins")
    with limits.raised({"lidar.bins": "2e4"}):
        assert limits.most("lidar.bins") == 20_000
        with limits.raised({"lidar.rays": 5}):
            assert (limits.most("lidar.bins"), limits.most("lidar.rays")) == (20_000, 5)
    assert limits.most("lidar.bins") == before


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("lidar.bin", 5, 'there is no such limit; did you mean "lidar.bins"'),
        ("lidar.bins", 0, "0 is not a whole number from 1"),
        ("lidar.bins", "1.5", "1.5 is not a whole number from 1"),
        ("lidar.bins", "many", "'many' is not a number"),
    ],
)
def test_a_limit_that_cannot_be_is_reported(name, value, said):
    with pytest.raises(ValueError, match=said), limits.raised({name: value}):
        pass


def test_an_amount_at_the_limit_passes_and_one_more_does_not():
    limits.check("lidar.bins", 10_000, "x")
    with pytest.raises(limits.OverLimit, match=r"^x; the limit is 10,000 spans; raise it with --limit lidar\.bins=N$"):
        limits.check("lidar.bins", 10_001, "x")


@pytest.mark.parametrize(
    "knob",
    [
        *("physics.iterations", "physics.ls_iterations", "physics.noslip_iterations", "physics.ccd_iterations"),
        *("lidar.bins", "lidar.subrays"),
    ],
)
def test_knobs_that_count_take_their_limit_and_no_more(knob):
    most = limits.most(
        "lidar.rays" if knob == "lidar.subrays" else "lidar.bins" if knob == "lidar.bins" else "physics.iterations"
    )
    assert Fidelity.from_mapping({knob: most})[knob] == most
    with pytest.raises(UserError, match=rf"{most + 1:,} is too many; the limit is"):
        Fidelity.from_mapping({knob: most + 1})


BALL = {"/W/Ball": {"type": "Sphere", "rigid_body": True, "translate": [0, 0, 5]}}


def test_an_update_makes_as_many_steps_as_the_limit_and_no_more():
    with limits.raised({"clock.steps": 2000}), App(physics_hz=2000, loop_hz=1) as app:
        app.add_prims(BALL)
        app.play()
        app.update()
        assert app.simulation.get_num_physics_steps() == 2000
    with limits.raised({"clock.steps": 1999}), App(physics_hz=2000, loop_hz=1) as app:
        app.add_prims(BALL)
        app.play()
        with pytest.raises(RunError, match=r"this update would make 2,000 physics steps; .*--limit clock\.steps=N"):
            app.update()
        assert app.simulation.get_num_physics_steps() == 0


def test_steps_without_anything_that_moves_cost_nothing_and_have_no_limit():
    with App(physics_hz=10**6, loop_hz="1/10") as app:
        app.play()
        app.update()
        assert app.simulation.get_num_physics_steps() == 10**7


@pytest.mark.parametrize(("hz", "code"), [(2000, 0), (2001, 2)])
def test_run_refuses_too_many_steps_before_it_writes(tmp_path, hz, code):
    document = {"tickgraph": 1, "clock": {"physics_hz": hz, "loop_hz": 1}, "scene": {"prims": BALL}}
    (tmp_path / "g.json").write_text(json.dumps(document))
    command = ["run", str(tmp_path / "g.json"), "--updates", "1", "--out", str(tmp_path / "out")]
    assert main([*command, "--limit", "clock.steps=2000"]) == code
    assert (tmp_path / "out").exists() == (code == 0)


@pytest.mark.parametrize("command", ["check", "explain"])
@pytest.mark.parametrize(("scene", "code"), [(BALL, 2), ({}, 0)])
def test_too_many_steps_are_found_without_a_run_where_anything_moves(tmp_path, capsys, command, scene, code):
    document = {"tickgraph": 1, "clock": {"physics_hz": "1e9", "loop_hz": 60}, "scene": {"prims": scene}}
    (tmp_path / "g.json").write_text(json.dumps(document))
    assert main([command, str(tmp_path / "g.json")]) == code
    said = "physics_hz 1,000,000,000 over loop_hz 60 makes 16,666,667 steps in an update; the limit is 100,000 steps"
    assert (said in capsys.readouterr().err) == (code == 2)
