"""Normals and shading of curved surfaces against their equations, however coarse the triangles are."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdPhysics, Vt

from sensors.camera.smooth import smooth_surfaces
from sensors.raycast.shared import cast_world
from tests.support.camera_worlds import add_camera, ahead, look
from tests.support.lidar_worlds import add_box, weightless

COARSE = 0.02
"""Tolerance [m]: a sphere of 1 m has bands of 11 degrees."""
CENTRE = np.array(ahead(0, 0, 5))


def solid(app, kind, axis="Z", scale=None, **sizes):
    prim = getattr(UsdGeom, kind).Define(app.stage, "/World/Solid")
    for name, value in sizes.items():
        prim.GetPrim().GetAttribute(name).Set(value)
    if kind != "Sphere":
        prim.GetAxisAttr().Set(axis)
    xform = UsdGeom.XformCommonAPI(prim)
    xform.SetTranslate(Gf.Vec3d(*CENTRE.tolist()))
    xform.SetRotate(Gf.Vec3f(30, 20, 0))
    if scale is not None:
        xform.SetScale(Gf.Vec3f(*scale))
    return prim


def ends(app):
    """Normals (480, 640, 3), and where the rays end, (480, 640, 3), infinite where nothing is."""
    normals, distance = look(app, add_camera(app), "normals", "distance_to_camera")
    x, y = np.meshgrid((np.arange(640) + 0.5 - 320) / 500, (np.arange(480) + 0.5 - 240) / 500)
    ways = np.stack([x, -y, -np.ones_like(x)], axis=-1)
    ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
    return normals[..., :3].astype(float), distance[..., None] * ways


def in_its_space(app, prim, points, normals):
    """Points in the prim's space, and normals as gradients there."""
    frame = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0)).T
    local = (points - frame[:3, 3]) @ np.linalg.inv(frame[:3, :3]).T
    gradients = normals @ frame[:3, :3]
    return local, gradients / np.linalg.norm(gradients, axis=1, keepdims=True)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def sphere(p):
    return p


def cylinder(p):
    """Radius 0.5, height 1.5, along z."""
    side = np.stack([p[:, 0], p[:, 1], 0 * p[:, 0]], axis=1)
    return np.where((np.abs(p[:, 2]) > 0.75 - 1e-5)[:, None], np.sign(p[:, 2:]) * (0, 0, 1.0), side)


def cone(p):
    """x^2 + y^2 = r(z)^2 with r from 0.8 to 0 over a height of 1.5."""
    radius = 0.8 * (0.5 - p[:, 2] / 1.5)
    side = np.stack([p[:, 0], p[:, 1], radius * 0.8 / 1.5], axis=1)
    return np.where((p[:, 2] < -0.75 + 1e-5)[:, None], (0, 0, -1.0), side)


def capsule(p):
    """Radius 0.5 about a line of 1 m."""
    return p - np.clip(p[:, 2:], -0.5, 0.5) * (0, 0, 1.0)


@pytest.mark.parametrize(
    ("kind", "sizes", "scale", "gradient"),
    [
        ("Sphere", {"radius": 1.0}, None, sphere),
        ("Sphere", {"radius": 1.0}, (0.5, 1.0, 0.75), sphere),
        ("Cylinder", {"radius": 0.5, "height": 1.5}, None, cylinder),
        ("Cone", {"radius": 0.8, "height": 1.5}, None, cone),
        ("Cone", {"radius": 0.8, "height": 1.5}, (1.0, 1.0, -1.0), cone),
        ("Capsule", {"radius": 0.5, "height": 1.0}, None, capsule),
    ],
)
def test_normals_of_a_solid_are_those_of_its_equation_where_the_ray_ends(kind, sizes, scale, gradient):
    with weightless(mesh_tolerance=COARSE) as app:
        prim = solid(app, kind, scale=scale, **sizes)
        normals, places = ends(app)
        hit = np.isfinite(places).all(axis=-1)
        local, found = in_its_space(app, prim, places[hit], normals[hit])
    assert hit.sum() > 3000
    difference = np.abs(found - unit(gradient(local))).max(axis=1)
    # Where the end of a capsule begins, triangles and the equation differ by a pixel or two.
    assert np.quantile(difference, 0.97) < 2e-4
    assert difference.max() < (2e-4 if kind == "Sphere" else 1.5)


def test_the_axis_of_a_solid_counts():
    with weightless(mesh_tolerance=COARSE) as app:
        prim = solid(app, "Cylinder", axis="X", radius=0.5, height=1.5)
        normals, places = ends(app)
        hit = np.isfinite(places).all(axis=-1)
        local, found = in_its_space(app, prim, places[hit], normals[hit])
    side = np.abs(local[:, 0]) < 0.74
    assert side.sum() > 1000
    np.testing.assert_allclose(found[side], unit(local[side] * (0, 1, 1)), atol=2e-4)


def test_the_sphere_of_the_reference():
    """Radius 1 at 5 m, pixel (400, 240): normal (0.688192, 0.004274, -0.725516) in right, down, forward."""
    with weightless() as app:
        ball = UsdGeom.Sphere.Define(app.stage, "/World/Ball")
        UsdGeom.XformCommonAPI(ball).SetTranslate(Gf.Vec3d(*ahead(0, 0, 5)))
        [normals] = look(app, add_camera(app), "normals")
    # The place differs by a triangle's distance from the sphere, at most 1 mm.
    np.testing.assert_allclose(normals[240, 400, :3], (0.688192, -0.004274, 0.725516), atol=2e-3)


def test_a_sphere_is_lit_as_one_up_to_the_edge_of_its_shadow():
    """Sun from the side: L = 0.18 / pi 1000 cos; the facets cast no shadows on one another."""
    with weightless(mesh_tolerance=COARSE) as app:
        solid(app, "Sphere", radius=1.0)
        UsdLux.DistantLight.Define(app.stage, "/World/Sun").CreateIntensityAttr(1000.0)
        UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Sun")).SetRotate(Gf.Vec3f(0, 90, 0))  # shines to -x
        light, normals = look(app, add_camera(app), "HdrColor", "normals")
    hit = np.abs(normals).max(axis=2) > 0
    cosine = np.maximum(normals[hit][:, 0].astype(float), 0)
    np.testing.assert_allclose(light[hit][:, 0], 0.18 / np.pi * 1000 * cosine, rtol=1e-3, atol=0.05)
    assert cosine.min() == 0
    assert cosine.max() > 0.5


def test_normals_of_a_solid_that_moves_are_its_own():
    with weightless() as app:
        prim = solid(app, "Cylinder", radius=0.5, height=1.5)
        UsdPhysics.RigidBodyAPI.Apply(prim.GetPrim())
        normals, places = ends(app)
        hit = np.isfinite(places).all(axis=-1)
        local, found = in_its_space(app, prim, places[hit], normals[hit])
    np.testing.assert_allclose(found, unit(cylinder(local)), atol=1e-4)


def test_an_area_light_fades_around_a_sphere_without_an_edge():
    """Sum of 4 x 4 patches of 2 x 2 m, 3 m to the left, wherever some of them are above the horizon."""
    with weightless() as app:
        ball = UsdGeom.Sphere.Define(app.stage, "/World/Ball")
        UsdGeom.XformCommonAPI(ball).SetTranslate(Gf.Vec3d(*CENTRE.tolist()))
        light = UsdLux.RectLight.Define(app.stage, "/World/Light")
        light.CreateIntensityAttr(1e4)
        light.CreateWidthAttr(2.0)
        light.CreateHeightAttr(2.0)
        UsdGeom.XformCommonAPI(light).SetTranslate(Gf.Vec3d(-3, 0, -5))
        UsdGeom.XformCommonAPI(light).SetRotate(Gf.Vec3f(0, -90, 0))  # shines to +x
        shown, normals, distance = look(app, add_camera(app), "HdrColor", "normals", "distance_to_camera")
    hit = np.isfinite(distance)
    x, y = np.meshgrid((np.arange(640) + 0.5 - 320) / 500, (np.arange(480) + 0.5 - 240) / 500)
    points = (distance[..., None] * unit(np.stack([x, -y, -np.ones_like(x)], axis=-1)))[hit]
    expected = np.zeros(len(points))
    for j in (-0.75, -0.25, 0.25, 0.75):
        for k in (-0.75, -0.25, 0.25, 0.75):
            way = np.array([-3, j, -5 + k]) - points
            squared = (way**2).sum(axis=1)
            cosines = np.maximum((way * normals[hit][:, :3]).sum(axis=1), 0) * np.maximum(-way[:, 0], 0)
            expected += 1e4 * 0.25 * cosines / squared**2
    np.testing.assert_allclose(shown[hit][:, 0], 0.18 / np.pi * expected, rtol=2e-3, atol=0.02)


def quad(app, normals, interpolation, attribute="normals", path="/World/Quad"):
    mesh = UsdGeom.Mesh.Define(app.stage, path)
    mesh.CreatePointsAttr([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateSubdivisionSchemeAttr("none")
    values = Vt.Vec3fArray([Gf.Vec3f(*each) for each in normals])
    if attribute == "normals":
        mesh.CreateNormalsAttr(values)
        mesh.SetNormalsInterpolation(interpolation)
    else:
        UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("normals", Sdf.ValueTypeNames.Normal3fArray, interpolation).Set(values)
    UsdGeom.XformCommonAPI(mesh).SetTranslate(Gf.Vec3d(*ahead(0, 0, 2)))
    return mesh


@pytest.mark.parametrize("attribute", ["normals", "primvars:normals"])
@pytest.mark.parametrize("interpolation", ["vertex", "faceVarying"])
def test_authored_normals_are_taken_between_the_corners(interpolation, attribute):
    with weightless() as app:
        quad(app, [(-0.6, 0, 0.8), (0.6, 0, 0.8), (0.6, 0, 0.8), (-0.6, 0, 0.8)], interpolation, attribute)
        [normals] = look(app, add_camera(app, size=(100, 100), focal=20.0, aperture=20.0), "normals")
    x = (np.arange(100) + 0.5) / 50 - 1
    np.testing.assert_allclose(normals[50, :, :3], unit(np.stack([0.6 * x, 0 * x, 0 * x + 0.8], axis=1)), atol=1e-5)


def test_authored_normals_turn_and_scale_with_their_body():
    """Vectors (0.6 x, 0, 0.8), squeezed to half in x: (1.2 x, 0, 0.8); then turned about z."""
    with weightless() as app:
        mesh = quad(app, [(-0.6, 0, 0.8), (0.6, 0, 0.8), (0.6, 0, 0.8), (-0.6, 0, 0.8)], "vertex")
        UsdGeom.XformCommonAPI(mesh).SetScale(Gf.Vec3f(0.5, 1, 1))
        UsdGeom.XformCommonAPI(mesh).SetRotate(Gf.Vec3f(0, 0, 90))
        [normals] = look(app, add_camera(app, size=(100, 100), focal=20.0, aperture=20.0), "normals")
    # Row 34 is (50 - 34.5) / 50 = 0.31 m above the middle, of 0.5 m to the corners: x = 0.62 before the turn.
    np.testing.assert_allclose(normals[34, 50, :3], unit(np.array([0, 1.2 * 0.62, 0.8])), atol=1e-5)


def test_what_is_flat_costs_nothing():
    """Boxes, and meshes whose normals are those of their faces, are not smooth surfaces."""
    with weightless() as app:
        add_box(app, "/World/Box", 1.0, ahead(0, 0, 5))
        quad(app, [(0, 0, 1)] * 4, "vertex")
        app.play()
        assert smooth_surfaces(cast_world(app.world)) == {}


@pytest.mark.parametrize("normals", [[(0, 0, 1)], [(0, 0, 0)] * 4, [(float("nan"), 0, 1)] * 4])
def test_normals_that_do_not_fit_leave_the_surface_flat(normals):
    with weightless() as app:
        quad(app, normals, "vertex")
        [found] = look(app, add_camera(app, size=(10, 10), focal=20.0, aperture=20.0), "normals")
    np.testing.assert_allclose(found[5, 5, :3], (0, 0, 1), atol=1e-6)
