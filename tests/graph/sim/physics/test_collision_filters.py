import numpy as np
import pytest

from tests.support.physics_worlds import GROUND, physics_of, steps

BALL = {"type": "Sphere", "radius": 0.2, "rigid_body": True}


@pytest.fixture
def grouped():
    """Three balls, one above the other, and whatever `author(stage)` adds: grouped(author) -> (z, warnings)."""
    from graph.sim.scene.prims import author_prims
    from graph.sim.scene.stage import open_stage

    def build(author, prims=None):
        stage = open_stage()
        stack = {f"/{name}": {**BALL, "translate": [0, 0, 0.2 + 0.5 * n]} for n, name in enumerate("ABC")}
        author_prims(stage, {**GROUND, **stack, **(prims or {})})
        author(stage)
        physics, warnings = physics_of(stage)
        steps(physics, 480)
        return physics.positions[:, 2], warnings

    return build


def group(stage, path, members, filtered=(), inverted=False, merge=""):
    from graph.sim.usd import UsdPhysics

    made = UsdPhysics.CollisionGroup.Define(stage, path)
    for member in members:
        made.GetCollidersCollectionAPI().CreateIncludesRel().AddTarget(member)
    for other in filtered:
        made.CreateFilteredGroupsRel().AddTarget(other)
    if inverted:
        made.CreateInvertFilteredGroupsAttr(True)
    if merge:
        made.CreateMergeGroupNameAttr(merge)


def test_without_groups_balls_stack(grouped):
    z, warnings = grouped(lambda stage: None)
    assert z == pytest.approx([0.2, 0.6, 1.0], abs=5e-3)
    assert warnings == []


def test_groups_that_filter_each_other_pass_through(grouped):
    def author(stage):
        group(stage, "/G1", ["/A"], filtered=["/G2"])
        group(stage, "/G2", ["/B"])

    z, _ = grouped(author)
    assert z == pytest.approx([0.2, 0.2, 0.6], abs=5e-3)


def test_a_group_that_filters_itself(grouped):
    z, _ = grouped(lambda stage: group(stage, "/G", ["/A", "/B"], filtered=["/G"]))
    assert z == pytest.approx([0.2, 0.2, 0.6], abs=5e-3)


def test_an_inverted_filter_is_all_but_what_it_names(grouped):
    """B collides with A's group alone, neither with the ground's nor with C's: C falls through B and lies on A."""

    def author(stage):
        group(stage, "/Floor", ["/Ground"])
        group(stage, "/G1", ["/A"])
        group(stage, "/G2", ["/B"], filtered=["/G1"], inverted=True)
        group(stage, "/G3", ["/C"])

    z, _ = grouped(author)
    assert z == pytest.approx([0.2, 0.6, 0.6], abs=5e-3)


def test_merged_groups_filter_as_one(grouped):
    def author(stage):
        group(stage, "/G1", ["/A"], merge="m")
        group(stage, "/G2", ["/B"], merge="m")
        group(stage, "/G3", ["/C"], filtered=["/G1"])

    z, _ = grouped(author)
    assert z == pytest.approx([0.2, 0.6, 0.2], abs=5e-3)


def test_a_body_and_something_static_can_be_filtered(grouped):
    shelf = {"/Shelf": {"type": "Cube", "size": 1.0, "translate": [0, 0, 2.5]}}

    def author(stage):
        from graph.sim.usd import UsdPhysics

        prim = stage.GetPrimAtPath("/A")
        UsdPhysics.FilteredPairsAPI.Apply(prim).CreateFilteredPairsRel().AddTarget("/Ground")

    z, warnings = grouped(author, shelf)
    assert z[0] < -5  # it fell through the ground
    assert z[1:] == pytest.approx([0.2, 0.6], abs=5e-3)
    assert warnings == []


def test_links_of_an_articulation_without_self_collisions_pass_through(grouped):
    """Two sliding links on one post, one above the other, fall to their lower limits and overlap there."""

    def author(stage):
        from graph.sim.usd import Gf, Sdf, UsdGeom, UsdPhysics

        root = UsdGeom.Xform.Define(stage, "/Robot").GetPrim()
        UsdPhysics.ArticulationRootAPI.Apply(root)
        root.CreateAttribute("physxArticulation:enabledSelfCollisions", Sdf.ValueTypeNames.Bool).Set(False)
        for name, height in (("Low", 1.0), ("High", 2.0)):
            ball = UsdGeom.Sphere.Define(stage, f"/Robot/{name}")
            ball.CreateRadiusAttr(0.2)
            ball.AddTranslateOp().Set(Gf.Vec3d(5, 0, height))
            UsdPhysics.RigidBodyAPI.Apply(ball.GetPrim())
            UsdPhysics.CollisionAPI.Apply(ball.GetPrim())
        for name, first, height in (("J1", None, 1.0), ("J2", "/Robot/Low", 1.0)):
            rail = UsdPhysics.PrismaticJoint.Define(stage, f"/Robot/{name}")
            if first:
                rail.CreateBody0Rel().AddTarget(first)
            rail.CreateBody1Rel().AddTarget("/Robot/High" if first else "/Robot/Low")
            rail.CreateLocalPos0Attr(Gf.Vec3f(0 if first else 5, 0, height))
            rail.CreateAxisAttr("Z")
            rail.CreateLowerLimitAttr(-1.0 if first else 0.0)
            rail.CreateCollisionEnabledAttr(True)

    z, warnings = grouped(author)
    assert z[3:] == pytest.approx([1.0, 1.0], abs=2e-2)
    assert warnings == []


def test_many_groups_are_distinguished_up_to_the_masks_there_are(grouped):
    def author(stage):
        for number in range(40):
            stage.DefinePrim(f"/X{number}")
            group(stage, f"/G{number}", [f"/P{number}"], filtered=[f"/G{(number + 1) % 40}"])

    prims = {f"/P{n}": {"type": "Cube", "size": 0.1, "translate": [5 + n, 0, 0]} for n in range(40)}
    z, warnings = grouped(author, prims)
    assert [code for code, *_ in warnings] == ["collision-groups"]
    assert "40 kinds" in warnings[0][2] or "41 kinds" in warnings[0][2]
    assert np.isfinite(z).all()


def test_several_scenes_are_reported(grouped):
    scenes = {"/S1": {"type": "PhysicsScene"}, "/S2": {"type": "PhysicsScene"}}
    _, warnings = grouped(lambda stage: None, scenes)
    assert [(code, where) for code, where, _ in warnings] == [("several-physics-scenes", "/S1")]
    assert "/S2 has no effect" in warnings[0][2]
