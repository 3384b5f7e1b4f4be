"""`randomize:` of a graph file: what a seed draws, copies, mounting errors, and where mistakes are reported."""

from __future__ import annotations

import math

import numpy as np
import pytest

from graph.base.errors import UserError
from graph.files import loads
from graph.session.open import build_parts, open_session
from graph.session.randomized import randomized
from graph.sim import transforms
from graph.spec.distributions import Stream, parse

FILE = """\
tickgraph: 1
scene:
  prims:
    /World/Rock: {type: Cube, size: 0.5, mass: 2.0, rigid_body: true}
    /World/Rock/Tip: {type: Sphere, radius: 0.1}
    /World/Eye: {type: Camera, translate: [1, 2, 3], rotate: [0, 0, 90]}
    /World/Sun: {type: DistantLight, attributes: {"inputs:intensity": 1000}}
randomize:
  KEYS
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      wait: {type: Countdown, inputs: {duration: 5, period: 1}}
    connections:
      - tick.tick -> wait.execIn
"""


def file_with(*lines):
    return loads(FILE.replace("KEYS", "\n  ".join(lines)), name="r.yaml")


def drawn(seed, *lines, fixed=()):
    return randomized(file_with(*lines), seed, fixed)


def test_each_target_draws_from_a_stream_of_its_own():
    _, values = drawn(17, "/World/Rock.mass: uniform(1, 3)", "wait.duration: integers(1, 9)")
    assert values == {
        "/World/Rock.mass": parse("uniform(1, 3)").draw(Stream(17, "randomize /World/Rock.mass")),
        "wait.duration": parse("integers(1, 9)").draw(Stream(17, "randomize wait.duration")),
    }
    _, more = drawn(17, "/World/Sun.inputs:intensity: uniform(1, 9)", "/World/Rock.mass: uniform(1, 3)")
    assert more["/World/Rock.mass"] == values["/World/Rock.mass"]


def test_values_are_those_of_the_file_before_anything_is_built():
    spec, values = drawn(3, "/World/Rock.mass: uniform(1, 3)", "wait.duration: integers(1, 9)")
    assert spec.scene.prims["/World/Rock"]["mass"] == values["/World/Rock.mass"]
    assert spec.graphs[0].nodes[1].inputs["duration"] == values["wait.duration"]
    parts = build_parts(file_with("/World/Sun.inputs:intensity: uniform(1, 9)"), seed=3)
    light = parts.stage.GetPrimAtPath("/World/Sun").GetAttribute("inputs:intensity").Get()
    assert light == pytest.approx(parts.drawn["/World/Sun.inputs:intensity"])


def test_a_value_that_the_caller_sets_is_not_drawn():
    parts = build_parts(file_with("/World/Rock.mass: uniform(1, 3)"), overrides={"/World/Rock.mass": "7"})
    assert parts.spec.scene.prims["/World/Rock"]["mass"] == 7
    assert parts.drawn == {}


def test_copies_come_with_their_children_and_draw_their_own_values():
    spec, values = drawn(1, "/World/Rock.copies: choice(3)", "/World/Rock/Tip.radius: uniform(0.1, 0.2)")
    names = [path for path in spec.scene.prims if "Rock" in path]
    assert names == [
        *("/World/Rock", "/World/Rock_1", "/World/Rock_2"),
        *("/World/Rock/Tip", "/World/Rock_1/Tip", "/World/Rock_2/Tip"),
    ]
    radii = [values[f"{path}.radius"] for path in names[3:]]
    assert len({*radii}) == 3
    assert [spec.scene.prims[path]["radius"] for path in names[3:]] == radii


def test_no_copy_leaves_the_prim_out():
    spec, values = drawn(1, "/World/Rock.copies: choice(0)", "/World/Rock.mass: uniform(1, 3)")
    assert values == {"/World/Rock.copies": 0}
    assert not any("Rock" in path for path in spec.scene.prims)


def test_copies_of_copies():
    spec, _ = drawn(1, "/World/Rock/Tip.copies: choice(2)", "/World/Rock.copies: choice(2)")
    assert sorted(path for path in spec.scene.prims if "Tip" in path) == [
        *("/World/Rock/Tip", "/World/Rock/Tip_1", "/World/Rock_1/Tip", "/World/Rock_1/Tip_1"),
    ]


def test_prims_of_a_usd_scene_are_copied_and_removed_too(tmp_path):
    (tmp_path / "s.usda").write_text(SCENE)
    keys = ["/World/Ball.copies: choice(0)", "/World/Tree.copies: choice(3)", "/World/Tree/Top.radius: uniform(1, 2)"]
    text = "tickgraph: 1\nscene: {usd: s.usda}\nrandomize:\n  " + "\n  ".join(keys)
    parts = build_parts(loads(text, folder=tmp_path), seed=4)
    assert parts.problems == []
    assert not parts.stage.GetPrimAtPath("/World/Ball").IsActive()
    radii = [parts.stage.GetPrimAtPath(f"/World/{one}/Top").GetAttribute("radius").Get() for one in TREES]
    assert radii == [parts.drawn[f"/World/{one}/Top.radius"] for one in TREES]
    assert len({*radii}) == 3


TREES = ("Tree", "Tree_1", "Tree_2")
SCENE = """\
#usda 1.0
(
    upAxis = "Z"
)
def Xform "World"
{
    def Sphere "Ball"
    {
        double radius = 0.5
    }
    def Xform "Tree"
    {
        def Sphere "Top"
        {
            double radius = 1
        }
    }
}
"""


def test_a_mounting_error_acts_in_the_axes_of_the_sensor():
    """Turned by 90 degrees about z, its x axis is the world's y; a further turn of 10 degrees makes 100."""
    with open_session(
        file_with("/World/Eye.mount_translate: choice([0.1, 0, 0])", "/World/Eye.mount_rotate: choice([0, 0, 10])")
    ).app as app:
        from pxr import UsdGeom

        pose = transforms.from_usd(UsdGeom.XformCache().GetLocalToWorldTransform(app.stage.GetPrimAtPath("/World/Eye")))
    assert pose[:3, 3] == pytest.approx([1, 2.1, 3], abs=1e-12)
    angle = math.radians(100)
    assert pose[:3, 0] == pytest.approx(np.array([math.cos(angle), math.sin(angle), 0]), abs=1e-12)


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        (
            "/World/Rock.mass: unifrm(1, 2)",
            'r.yaml:9:21: randomize: /World/Rock.mass: there is no distribution "unifrm"',
        ),
        ("mass: uniform(1, 2)", 'r.yaml:9:3: randomize: "mass" names nothing to draw'),
    ],
)
def test_mistakes_of_form_are_found_when_the_file_is_read(line, problem):
    with pytest.raises(UserError) as caught:
        file_with(line)
    assert str(caught.value).startswith(problem)


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("/World/Rok.mass: uniform(1, 2)", "r.yaml:9:3: randomize: /World/Rok.mass: there is no such prim"),
        ("/World/Rok.copies: integers(1, 2)", "r.yaml:9:3: randomize: /World/Rok.copies: there is no such prim"),
        ("/World/Rock.copies: uniform(1, 2)", "r.yaml:9:3: randomize: /World/Rock.copies: "),
        ("wat.duration: integers(1, 2)", "r.yaml:9:3: randomize: wat.duration: no node has that name"),
        ("/World/Rock.material: choice(wod)", "r.yaml:9:3: /World/Rock: material: there is no material base 'wod'"),
        ("/World/Rock.copies: choice(1000000000)", "r.yaml:9:3: randomize: /World/Rock.copies: /World/Rock: too many"),
    ],
)
def test_mistakes_of_what_is_drawn_name_their_line(line, problem):
    found = [str(one) for one in build_parts(file_with(line)).problems]
    assert len(found) == 1
    assert found[0].startswith(problem)
