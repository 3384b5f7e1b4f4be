"""The articulation of a prim: the same links from its root, a link, a joint or a prim above, and no others."""

import pytest

from graph.sim.scene.mechanisms import Mechanisms, Tie, mechanisms_of
from graph.sim.scene.stage import open_stage
from tests.support.jointed_robots import ROOTS, define_ball, define_robot


@pytest.fixture
def yard():
    """Two robots of each kind, and a free ball beside and one below each."""
    stage = open_stage()
    for number, place in enumerate(ROOTS):
        name = place.title().replace(" ", "")
        define_robot(stage, f"/World/{name}", place, (10.0 * number, 0, 0))
        define_ball(stage, f"/World/{name}/ball", (10.0 * number, 0, 5))
        define_robot(stage, f"/World/Other{name}", place, (10.0 * number, 50, 0))
    define_ball(stage, "/World/ball", (0, 100, 5))
    return mechanisms_of(stage)


@pytest.mark.parametrize("name", ["Link", "Joint", "Above", "StaticBase"])
def test_it_is_found_from_each_of_its_prims_and_holds_its_links_alone(yard, name):
    root = f"/World/{name}"
    links = {f"{root}/base": "", f"{root}/arm": f"{root}/base"}
    starts = [f"{root}/base", f"{root}/arm", f"{root}/hinge"]
    starts += [] if name == "StaticBase" else [f"{root}/mount"]
    for start in starts:
        assert yard.carriers(start) == links, start
        assert list(yard.carriers(start)) == list(links)  # the root link first
    # a prim above without the root API stands for everything below it, the ball included
    below = yard.carriers(root)
    assert below == (links if name == "Above" else links | {f"{root}/ball": ""})


@pytest.mark.parametrize(
    ("name", "stands"),
    [
        ("Link", ["", "base", "mount", "hinge"]),
        ("Joint", ["", "mount", "hinge"]),
        ("Above", ["", "mount", "hinge"]),
        ("StaticBase", ["", "base", "hinge"]),
    ],
)
def test_roots_joints_and_prims_above_one_root_stand_for_all_links_and_links_for_themselves(yard, name, stands):
    root = f"/World/{name}"
    for part in ("", "base", "arm", "mount", "hinge", "ball"):
        path = f"{root}/{part}".rstrip("/")
        expected = [f"{root}/base", f"{root}/arm"] if part in stands else []
        if name == "StaticBase" and part == "mount":
            continue
        assert list(yard.standing_for(path)) == expected, path
    assert yard.standing_for("/World") == {}  # above several


def test_what_no_joint_connects_has_no_links_in_common():
    ties = [
        Tie("/a", (None, "/A")),
        Tie("/ab", ("/A", "/B")),
        Tie("/cd", ("/C", "/D")),
        Tie("/loose", ("/B", "/C"), False),
    ]
    found = Mechanisms(ties, ["/D"], ["/A", "/B", "/C", "/D", "/E"])
    assert found.carriers("/B") == {"/A": "", "/B": "/A"}
    assert found.carriers("/C") == {"/D": "", "/C": "/D"}  # the link with the root API carries the others
    assert found.carriers("/E") == {"/E": ""}
    assert found.carriers("/Nowhere") == {}
    assert found.joints(found.carriers("/A")) == ["/a", "/ab"]
    # a joint that is excluded from articulations connects none, but stands between two
    assert set(found.carriers("/loose")) == {"/A", "/B", "/C", "/D"}


def test_two_arms_on_one_table_are_two_articulations():
    from pxr import UsdGeom

    stage = open_stage()
    UsdGeom.Cube.Define(stage, "/World/Table")
    for name in ("Left", "Right"):
        define_robot(stage, f"/World/{name}", "link")
        stage.GetPrimAtPath(f"/World/{name}/mount").GetRelationship("physics:body0").SetTargets(["/World/Table"])
    found = mechanisms_of(stage)
    assert list(found.carriers("/World/Left/arm")) == ["/World/Left/base", "/World/Left/arm"]


def test_they_are_kept_until_the_stage_changes():
    stage, other = open_stage(), open_stage()
    define_robot(stage, "/World/Arm", "link")
    found = mechanisms_of(stage)
    assert mechanisms_of(stage) is found
    assert mechanisms_of(other).carriers("/World/Arm") == {}
    assert list(mechanisms_of(stage).carriers("/World/Arm")) == ["/World/Arm/base", "/World/Arm/arm"]
    kept = mechanisms_of(stage)
    stage.DefinePrim("/Render/Product", "RenderProduct")
    assert mechanisms_of(stage) is kept
    stage.RemovePrim("/World/Arm/hinge")
    assert list(mechanisms_of(stage).carriers("/World/Arm/base")) == ["/World/Arm/base"]
