"""Which prims have closed forms, and where they are."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from graph.base import limits
from graph.base.errors import UserError
from graph.sim.geometry.closed_forms import closed_form
from graph.sim.geometry.collect import collect_geometry
from graph.sim.geometry.surfaces import Mesh, Solid


def stage_with(kind, body=False, **attributes):
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    prim = stage.DefinePrim("/World/S", kind)
    for name, value in attributes.items():
        prim.GetAttribute(name).Set(value)
    if body:
        UsdPhysics.RigidBodyAPI.Apply(prim)
    return stage, prim


@pytest.mark.parametrize("kind", ["Sphere", "Cylinder", "Cone", "Capsule", "Cylinder_1"])
@pytest.mark.parametrize("body", [False, True])
def test_curved_solids_have_a_closed_form_whether_they_move_or_not(kind, body):
    (found,) = collect_geometry(stage_with(kind, body)[0], 1e-2, exact=True)
    assert isinstance(found, Solid)
    (triangles,) = collect_geometry(stage_with(kind, body)[0], 1e-2)
    assert type(triangles) is Mesh
    assert found.vertices.tobytes() == triangles.vertices.tobytes()
    assert found.triangles.tobytes() == triangles.triangles.tobytes()
    low, high = found.form.bounds()
    assert (low <= found.vertices.min(axis=0) + 1e-9).all()
    assert (high >= found.vertices.max(axis=0) - 1e-9).all()


def test_a_cube_has_one_only_where_it_moves():
    # Its triangles are exact, and faster in a scene that stands.
    found = [collect_geometry(stage_with("Cube", body)[0], 1e-2, exact=True)[0] for body in (False, True)]
    assert [isinstance(one, Solid) for one in found] == [False, True]


@pytest.mark.parametrize(
    ("kind", "sizes"),
    [
        ("Plane", {"width": 1.0, "length": 1.0}),
        ("Capsule_1", {"radiusBottom": 1.0, "radiusTop": 0.5, "height": 1.0}),
        ("Cylinder", {"radius": 1.0, "height": 0.0}),
        ("Sphere", {"radius": 0.0}),
    ],
)
def test_what_is_flat_or_not_convex_has_none(kind, sizes):
    assert closed_form(kind, sizes, "Z") is None


def test_bounds_of_a_sheared_and_mirrored_ball():
    # p = A u with |u| <= 1 reaches the length of a row of A along that axis.
    matrix = np.eye(4)
    matrix[:3] = [[2.0, 1.0, 0.0, 5.0], [0.0, -3.0, 0.0, 6.0], [0.0, 0.0, 0.5, 7.0]]
    low, high = closed_form("Sphere", {"radius": 2.0}, "Z").placed(matrix).bounds()
    reach = 2 * np.array([np.sqrt(5.0), 3.0, 0.5])
    assert np.allclose(np.add(low, reach), [5, 6, 7])
    assert np.allclose(np.subtract(high, reach), [5, 6, 7])


def test_a_cone_stands_as_usd_has_it():
    # UsdGeomCone: apex at +height / 2 along the axis.
    form = closed_form("Cone", {"radius": 0.5, "height": 3.0}, "X")
    along = form.frame[:3, 2]
    assert along.tolist() == [1.5, 0.0, 0.0]
    assert (form.low, form.high) == (1.0, 0.0)
    assert np.allclose(form.bounds(), [[-1.5, -0.5, -0.5], [1.5, 0.5, 0.5]])


def test_triangles_of_moving_solids_do_not_count_until_they_are_made():
    with limits.raised({"scene.triangles": 100}):
        assert len(collect_geometry(stage_with("Sphere", True)[0], 1e-3, exact=True)) == 1
        with pytest.raises(UserError, match="too many triangles"):
            collect_geometry(stage_with("Sphere", False)[0], 1e-3, exact=True)


def test_a_scale_of_the_prim_is_part_of_the_form():
    stage, prim = stage_with("Sphere", False, radius=2.0)
    UsdGeom.Xformable(prim).AddScaleOp().Set(Gf.Vec3f(1.0, 0.5, -3.0))
    (found,) = collect_geometry(stage, 1e-2, exact=True)
    assert np.allclose(found.form.bounds(), [[-2, -1, -6], [2, 1, 6]])
