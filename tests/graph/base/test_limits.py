"""The table of limits, and each bound at its value and one beyond."""

import json
import re
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from graph.base import limits
from graph.base.errors import RunError, UserError
from graph.cli.main import main
from graph.files import loads
from graph.session.open import open_session
from graph.sim import App
from graph.sim.fidelity import Fidelity
from graph.sim.geometry.collect import collect_geometry
from graph.sim.geometry.triangulation import triangulate
from graph.sim.scene.stage import open_stage
from graph.sim.usd import UsdGeom
from sensors.lidar.config import EmitterState, LidarConfig

README = Path(__file__).parents[3] / "README.md"


def test_the_readme_lists_every_limit_with_its_value():
    rows = re.findall(r"^\| `([a-z_.]+)` \| ([\d,]+) ([a-z]+) \| (.+?) \|$", README.read_text(), re.MULTILINE)
    assert rows == [(name, f"{one.default:,}", one.unit, one.doc) for name, one in limits.LIMITS.items()]


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
def test_a_limit_that_cannot_be_is_told(name, value, said):
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


@pytest.mark.parametrize(("most", "code"), [(3, 0), (2, 2)])
def test_a_run_has_as_many_updates_as_the_limit_and_no_more(tmp_path, most, code):
    (tmp_path / "g.json").write_text('{"tickgraph": 1, "clock": {"loop_hz": 3}}')
    for length in (["--updates", "3"], ["--duration", "1"]):
        assert main(["run", str(tmp_path / "g.json"), *length, "--limit", f"run.updates={most}"]) == code


LOOPS = {
    "tick": "OnPlaybackTick",
    "outer": {"type": "omni.graph.action.ForLoop", "inputs": {"stop": 10}},
    "inner": {"type": "omni.graph.action.ForLoop", "inputs": {"stop": 10}},
    "count": "omni.graph.action.Counter",
}
WIRES = ["tick.tick -> outer.execIn", "outer.loopBody -> inner.execIn", "inner.loopBody -> count.execIn"]


def test_loops_within_loops_multiply_up_to_the_limit_and_no_further():
    """Outer 11 computes (10 passes and the end), inner 10 x 11, count 100, tick 1: 222 in one evaluation."""
    text = json.dumps({"tickgraph": 1, "graphs": {"/G": {"nodes": LOOPS, "connections": WIRES}}})
    for most, works in ((222, True), (221, False)):
        session = open_session(loads(text, name="g.json"))
        with limits.raised({"graph.steps": most}), session.app as app:
            app.play()
            if works:
                app.update()
                assert app.graphs["/G"].node("count").computes == 100
            else:
                with pytest.raises(RunError, match=r"its loops make more than 221 computes .*--limit graph\.steps=N"):
                    app.update()


def test_faces_have_as_many_corners_as_the_limit_and_no_more():
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    for most, triangles, told in ((4, 2, 0), (3, 0, 1)):
        said = []
        with limits.raised({"mesh.corners": most}):
            found, _ = triangulate(points, np.array([4]), np.arange(4), complain=said.append)
        assert (len(found), len(said)) == (triangles, told)
        assert all("1 faces have too many corners and are left out; the limit is 3 corners" in one for one in said)


def instancers():
    """/Outer copies /Outer/Inner 3 times, which copies a cube 4 times: 12 copies of 12 triangles."""
    stage = open_stage()
    for path, proto, count in (("/Outer", "/Outer/Inner", 3), ("/Outer/Inner", "/Outer/Inner/Cube", 4)):
        one = UsdGeom.PointInstancer.Define(stage, path)
        one.GetPrototypesRel().AddTarget(proto)
        one.GetProtoIndicesAttr().Set([0] * count)
        one.GetPositionsAttr().Set([(i, 0, 0) for i in range(count)])
    UsdGeom.Cube.Define(stage, "/Outer/Inner/Cube")
    return stage


@pytest.mark.parametrize(("most", "copies"), [(12, 12), (11, 0)])
def test_instancers_within_instancers_multiply_up_to_the_limit(most, copies):
    told = []
    with limits.raised({"scene.copies": most}):
        found = collect_geometry(instancers(), 0.001, lambda code, where, message: told.append(message))
    assert len(found) == copies
    refused = [one for one in told if "its 12 copies are too many and left out; the limit is 11 copies" in one]
    assert bool(refused) == (not copies)


def test_a_scene_has_as_many_triangles_as_the_limit_and_no_more():
    with limits.raised({"scene.triangles": 144}):
        assert len(collect_geometry(instancers(), 0.001, lambda *said: None)) == 12
    with limits.raised({"scene.triangles": 143}), pytest.raises(UserError, match=r"--limit scene\.triangles=N"):
        collect_geometry(instancers(), 0.001, lambda *said: None)


@pytest.mark.parametrize(("count", "code"), [(10_000, 0), (10_001, 2)])
def test_iterations_of_a_scene_and_of_a_model_are_limited(tmp_path, count, code):
    scene = f'def PhysicsScene "P" {{\n int mjc:option:iterations = {count}\n}}\n'
    (tmp_path / "a.usda").write_text('#usda 1.0\n(\nmetersPerUnit = 1\nupAxis = "Z"\n)\n' + scene)
    body = '<worldbody><body><freejoint/><geom size="1"/></body></worldbody>'
    (tmp_path / "m.xml").write_text(f'<mujoco><option iterations="{count}"/>{body}</mujoco>')
    (tmp_path / "b.json").write_text('{"tickgraph": 1, "scene": {"mjcf": "m.xml"}}')
    (tmp_path / "c.json").write_text(json.dumps({"tickgraph": 1, "scene": {"usd": "a.usda", "prims": BALL}}))
    assert [main(["run", str(tmp_path / name), "--updates", "1"]) for name in ("b.json", "c.json")] == [code, code]


def test_a_scan_has_as_many_rays_as_the_limit_and_no_more():
    # 4 emitters, 1000 firings a second, 10 turns a second: 400 rays a turn
    states = (EmitterState(np.zeros(4), np.zeros(4)),)
    rays = {"pattern_firing_rate_hz": Fraction(1000), "scan_rate_base_hz": Fraction(10), "emitter_states": states}
    with limits.raised({"lidar.rays": 400}):
        assert LidarConfig(**rays).rays_per_scan == 400
    with limits.raised({"lidar.rays": 399}), pytest.raises(UserError, match=r"--limit lidar\.rays=N"):
        LidarConfig(**rays)
