"""Light in pictures against closed forms: irradiance of each light, shadows, exposure and the bytes of sRGB."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade

from sensors.camera.shading import srgb
from sensors.replicator import get_annotator
from tests.support.camera_worlds import add_camera, ahead, look
from tests.support.lidar_worlds import add_box, weightless

SIZE = (33, 33)
MIDDLE = (16, 16)


def wall(app, color=(0.18, 0.18, 0.18), depth=2.0):
    """A wall straight ahead whose near side is `depth` m away."""
    box = add_box(app, "/World/Wall", 100.0, ahead(0, 0, depth + 50))
    UsdGeom.Gprim(box).CreateDisplayColorAttr([color])


def add_light(app, kind, name="Light", place=None, rotate=None, **inputs):
    light = getattr(UsdLux, kind).Define(app.stage, f"/World/{name}").GetPrim()
    for key, value in inputs.items():
        light.GetAttribute(f"inputs:{key}").Set(value)
    api = UsdGeom.XformCommonAPI(light)
    if place is not None:
        api.SetTranslate(Gf.Vec3d(*ahead(*place)))
    if rotate is not None:
        api.SetRotate(Gf.Vec3f(*rotate))
    return light


def light_ahead(app, **camera):
    """Linear light of the pixel in the middle, (3,)."""
    [found] = look(app, add_camera(app, size=SIZE, focal=50.0, aperture=1.0, **camera), "HdrColor")
    assert found.shape == (33, 33, 4)
    return found[MIDDLE][:3].astype(np.float64)


HALF = 2.0**-10
"""float16 has 11 binary digits: relative error of the output."""


@pytest.mark.parametrize(
    ("kind", "place", "inputs", "lux"),
    [
        # 1000 lux on a wall that faces it, from behind the camera: light shines along its -z.
        ("DistantLight", None, {"intensity": 1000.0}, 1000.0),
        # pi L (r / d)^2 = pi 10^4 (0.1 / 2)^2
        ("SphereLight", (0, 0, 0), {"intensity": 1e4, "radius": 0.1}, 78.5398),
        # 2 m to the side of 2 m: d = sqrt(8), cos = 2 / sqrt(8)
        ("SphereLight", (2, 0, 0), {"intensity": 1e4, "radius": 0.1}, 27.7680),
        # normalised: 10^4 / (4 pi r^2) times the same
        ("SphereLight", (0, 0, 0), {"intensity": 1e4, "radius": 0.1, "normalize": True}, 78.5398 / (0.04 * np.pi)),
        # 4 x 4 patches of a square of 1 m at 1 m; without end 752.2747
        ("RectLight", (0, 0, 1), {"intensity": 1000.0}, 761.36),
        ("RectLight", (0, 0, 1), {"intensity": 1000.0, "width": 2.0, "height": 0.5, "normalize": True}, None),
        ("DomeLight", None, {"intensity": 100.0}, 100 * np.pi),
    ],
)
def test_each_light_brings_what_usdlux_says(kind, place, inputs, lux):
    """A grey wall of 0.18, 2 m ahead, sends back 0.18 / pi of it."""
    with weightless() as app:
        wall(app)
        add_light(app, kind, place=place, **inputs)
        found = light_ahead(app)
    if lux is None:  # the sum over 4 x 4 patches, written out
        x, y = np.meshgrid((np.arange(4) - 1.5) / 2, (np.arange(4) - 1.5) / 8)
        lux = 1000.0 * np.mean(1 / (1 + x**2 + y**2) ** 2)
    np.testing.assert_allclose(found, 0.18 / np.pi * lux, rtol=2e-5 + HALF)


def test_a_disk_brings_nearly_what_its_closed_form_says():
    """pi L r^2 / (r^2 + d^2) = 1000 pi 0.25 / 1.25 = 628.3185 lux; four rings are 0.4 % off."""
    with weightless() as app:
        wall(app)
        add_light(app, "DiskLight", place=(0, 0, 1), intensity=1000.0, radius=0.5)
        found = light_ahead(app)
    np.testing.assert_allclose(found, 0.18 / np.pi * 628.3185, rtol=5e-3)


@pytest.mark.parametrize("normalize", [False, True])
def test_a_cylinder_shines_as_its_strips_do_and_not_from_its_ends(normalize):
    """1000 nit, r 0.05, 1 m long, 2 m from the wall: the integral of 2 r L sin(b) cos(a) / d^2 dl is 24.0136 lux, with
    both angles' factor 2 / d; normalised by the area 2 pi r l without its ends. Four points are 0.25 % off. From its
    end nothing comes.
    """
    lux = 24.0136 / (2 * np.pi * 0.05 if normalize else 1.0)
    for rotate, share in (((0, 0, 0), 1.0), ((0, 90, 0), 0.0)):
        with weightless() as app:
            wall(app)
            add_light(app, "CylinderLight", rotate=rotate, intensity=1000.0, radius=0.05, normalize=normalize)
            found = light_ahead(app)
        np.testing.assert_allclose(found, 0.18 / np.pi * lux * share, rtol=3e-3, atol=1e-6)


def test_a_distant_light_of_the_newer_usdlux_is_a_disk_of_radiance():
    """50000 pi sin^2(0.265 deg) = 3.36019 lux."""
    with weightless() as app:
        wall(app)
        light = add_light(app, "DistantLight", intensity=50000.0, angle=0.53)
        light.CreateAttribute("omni:rtx:usdluxVersion", Sdf.ValueTypeNames.Int).Set(2505)
        found = light_ahead(app)
    np.testing.assert_allclose(found, 0.18 / np.pi * 3.36019, rtol=2e-5 + HALF)


def test_exposure_and_srgb_make_bytes_of_light():
    """1000 lux on 0.18: 57.2958 nit; times 0.02 / 25 = 8e-4: 0.0458366, of sRGB 60."""
    with weightless() as app:
        wall(app)
        add_light(app, "DistantLight", intensity=1000.0)
        rgb, again, linear = look(app, add_camera(app, size=SIZE), "rgb", "LdrColor", "HdrColor")
    assert linear[MIDDLE][0] == pytest.approx(57.2958, rel=HALF)
    assert rgb.shape == (33, 33, 4)
    assert rgb.dtype == np.uint8
    assert rgb[MIDDLE].tolist() == [60, 60, 60, 255]
    np.testing.assert_array_equal(rgb, again)


def test_the_exposure_of_the_prim_counts_where_it_is_authored():
    """Two stops more and a fourth of the time are the same picture; f / 2.5 is four times the light of f / 5."""
    pictures = []
    for values in ({}, {"exposure": 2.0, "exposure__time": 0.005}, {"exposure__fStop": 2.5}):
        with weightless() as app:
            wall(app)
            add_light(app, "DistantLight", intensity=1000.0)
            pictures.append(look(app, add_camera(app, size=SIZE, **values), "rgb")[0][MIDDLE][0])
    assert pictures == [60, 60, srgb(np.float32(4 * 0.0458366))]


def test_colours_and_lights_that_change_while_playing_are_seen_in_the_next_picture():
    """E = 1000 lux on 0.18, then on 0.36, then 3000 lux on it: rho E / pi."""
    with weightless() as app:
        wall(app)
        color = app.stage.GetPrimAtPath("/World/Wall").GetAttribute("primvars:displayColor")
        light = add_light(app, "DistantLight", intensity=1000.0)
        annotator = get_annotator("HdrColor", app=app).attach(add_camera(app, size=SIZE))
        app.play()
        found = []
        for change in (
            lambda: None,
            lambda: color.Set([(0.36, 0.36, 0.36)]),
            lambda: light.GetAttribute("inputs:intensity").Set(3000.0),
        ):
            change()
            app.update()
            found.append(float(annotator.get_data()[MIDDLE][0]))
    assert found == pytest.approx([180 / np.pi, 360 / np.pi, 1080 / np.pi], rel=HALF)


def test_the_curve_of_srgb():
    linear = np.array([-1.0, 0.0, 0.0031308, 0.18, 0.5, 1.0, 2.0, np.nan], np.float32)[:-1]
    assert srgb(linear).tolist() == [0, 0, 10, 118, 188, 255, 255]


def test_a_shadow_lies_where_the_light_is_hidden():
    """A sphere light of 1 m radius above; a box between it and the floor; its shadow is black without a sky."""
    with weightless() as app:
        wall(app, depth=4.0)
        add_box(app, "/World/Box", 0.5, ahead(0.5, 0, 2.0))
        add_light(app, "SphereLight", place=(2.0, 0, 0), intensity=1e5, radius=0.1)
        lit = look(app, add_camera(app), "HdrColor", "instance_id_segmentation")
    light, number = lit[0][..., 0].astype(float), lit[1]["data"]
    # The line from the light (2, 0, 0) by the box's edges meets z = 4 at x of -0.727 .. and below.
    shaded = (light == 0) & (number == 3)
    columns = np.flatnonzero(shaded[240])
    left, right = (2 + 4 * (x - 2) / z for x, z in ((0.25, 1.75), (0.75, 2.25)))
    assert (left, right) == pytest.approx((-2.0, -2 / 9))
    assert columns[0] == np.ceil(320 + 500 * left / 4 - 0.5)
    assert columns[-1] == np.floor(320 + 500 * right / 4 - 0.5)
    assert (light[0] > 0).all()


def test_a_body_that_moves_takes_its_shadow_along():
    """6 m/s to the left for four updates are 0.4 m: on the wall 4 m ahead 50 px."""
    with weightless() as app:
        wall(app, depth=4.0)
        add_box(app, "/World/Body", 0.5, ahead(0, 0, 2.0), velocity=(-6.0, 0, 0))
        add_light(app, "DistantLight", rotate=(0, -30, 0), intensity=1000.0)
        product = add_camera(app)
        light, number = (
            get_annotator(name, app=app).attach(product) for name in ("HdrColor", "instance_id_segmentation")
        )
        app.play()
        middles = []
        for _ in range(2):
            app.update()
            dark = (light.get_data()[240, :, 0] == 0) & (number.get_data()["data"][240] == 3)
            middles.append(np.flatnonzero(dark).mean())
            app.update(steps=3)
    assert middles[1] - middles[0] == pytest.approx(-50.0, abs=1.0)


def test_a_bound_preview_surface_gives_the_colour_and_its_own_light():
    with weightless() as app:
        wall(app, color=(1, 1, 1))
        material = UsdShade.Material.Define(app.stage, "/World/Red")
        shader = UsdShade.Shader.Define(app.stage, "/World/Red/Shader")
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(0.5, 0.25, 0.0))
        shader.CreateInput("emissiveColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(0.0, 0.0, 3.0))
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        UsdShade.MaterialBindingAPI.Apply(app.stage.GetPrimAtPath("/World/Wall")).Bind(material)
        add_light(app, "DistantLight", intensity=100 * np.pi)
        found = light_ahead(app)
    np.testing.assert_allclose(found, [50.0, 25.0, 3.0], rtol=2e-5 + HALF)


def test_a_shader_that_is_not_known_is_grey_and_told_once():
    with weightless() as app:
        wall(app)
        material = UsdShade.Material.Define(app.stage, "/World/Glass")
        shader = UsdShade.Shader.Define(app.stage, "/World/Glass/Shader")
        shader.CreateIdAttr("FancyGlass")
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        UsdShade.MaterialBindingAPI.Apply(app.stage.GetPrimAtPath("/World/Wall")).Bind(material)
        add_light(app, "DistantLight", intensity=1000.0)
        found = light_ahead(app)
        codes = [(warning.code, warning.where) for warning in app.warnings]
    np.testing.assert_allclose(found, 57.2958, rtol=1e-5 + HALF)
    assert codes.count(("material-not-modelled", "/World/Glass")) == 1


def test_the_sky_is_seen_where_nothing_is_and_without_light_all_is_black():
    with weightless() as app:
        add_light(app, "DomeLight", intensity=100.0, color=(0.25, 0.5, 1.0))
        assert light_ahead(app).tolist() == [25.0, 50.0, 100.0]
    with weightless() as app:
        wall(app)
        assert light_ahead(app).tolist() == [0.0, 0.0, 0.0]
        assert "no-light" in {warning.code for warning in app.warnings}


def test_the_colour_of_a_temperature_is_usds():
    with weightless() as app:
        wall(app, color=(1, 1, 1))
        add_light(app, "DistantLight", intensity=np.pi, enableColorTemperature=True, colorTemperature=3000.0)
        found = light_ahead(app)
    np.testing.assert_allclose(found, list(UsdLux.BlackbodyTemperatureAsRgb(3000.0)), rtol=1e-5 + HALF)


def test_a_spot_lights_its_cone_only():
    """10 deg half angle at 4 m: 0.705 m."""
    with weightless() as app:
        wall(app, depth=4.0)
        light = add_light(app, "SphereLight", place=(0, 0, 0), intensity=1e5, radius=0.1)
        UsdLux.ShapingAPI.Apply(light).CreateShapingConeAngleAttr(10.0)
        [found] = look(app, add_camera(app), "HdrColor")
    columns = np.flatnonzero(found[240, :, 0] > 0)
    reach = 500 * np.tan(np.deg2rad(10.0))
    assert (columns[0], columns[-1]) == (np.ceil(320 - reach - 0.5), np.floor(320 + reach - 0.5))


def test_more_samples_smooth_the_edges_and_leave_depth_alone():
    """The edge of a black box before a white sky crosses pixels: with 16 rays a pixel there are greys."""

    def picture(samples):
        with weightless(camera_samples=samples) as app:
            box = add_box(app, "/World/Box", 1.0, ahead(1.0, 0, 5))
            UsdGeom.Gprim(box).CreateDisplayColorAttr([(0, 0, 0)])
            add_light(app, "DomeLight", intensity=1250.0)
            return look(app, add_camera(app), "rgb", "distance_to_image_plane")

    (plain, depth), (smooth, same) = picture(1), picture(16)
    assert set(np.unique(plain[..., 0]).tolist()) == {0, 255}
    greys = np.unique(smooth[..., 0]).tolist()
    assert 3 < len(greys) <= 17
    np.testing.assert_array_equal(depth, same)
    # The left edge lies at 320 + 500 x 0.5 / 5.5 = 365.4545 (its back): 0.4545 of column 365 is sky.
    share = float(np.mean(smooth[240, 365, 0] == srgb(np.arange(17, dtype=np.float32) / 16)))
    assert share > 0


def test_pictures_are_the_same_on_any_number_of_threads():
    def picture(threads):
        with weightless(settings={"/tickgraph/rayThreads": threads}) as app:
            wall(app)
            add_box(app, "/World/Body", 0.3, ahead(0.2, 0, 1), velocity=(1.0, 0, 0), spin=(20.0, 0, 90.0))
            add_light(app, "RectLight", place=(1, -1, 0), intensity=1e5)
            add_light(app, "DomeLight", "Sky", intensity=100.0)
            return look(app, add_camera(app), "rgb")[0].tobytes()

    assert picture(1) == picture(2)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("path", "name", "value"),
    [
        ("/World/Light", "inputs:intensity", 1e38),
        ("/World/Light", "inputs:exposure", 2000.0),
        ("/World/Light", "inputs:color", Gf.Vec3f(float("nan"), 1, 1)),
        ("/World/Camera", "exposure", 2000.0),
        ("/World/Wall", "primvars:displayColor", [(float("nan"), 0, 0)]),
    ],
)
def test_a_value_beyond_all_measure_makes_a_picture_all_the_same(path, name, value):
    with weightless() as app:
        wall(app)
        add_light(app, "DistantLight", intensity=1000.0)
        product = add_camera(app, size=SIZE)
        app.stage.GetPrimAtPath(path).GetAttribute(name).Set(value)
        rgb, linear = look(app, product, "rgb", "HdrColor")
    assert rgb[MIDDLE][3] == 255
    assert np.isfinite(linear).all()


@pytest.mark.parametrize("kind", ["DistantLight", "SphereLight"])
def test_a_light_that_is_nowhere_gives_no_light_and_says_so(kind):
    """The other light is the 1000 lux of the first case: 1000 * 0.18 / pi nit."""
    with weightless() as app:
        wall(app)
        add_light(app, "DistantLight", intensity=1000.0)
        add_light(app, kind, "Lost", rotate=(float("nan"), 0, 0), intensity=1000.0)
        assert light_ahead(app) == pytest.approx(1000 * 0.18 / np.pi, rel=HALF)
        assert [(one.code, one.where) for one in app.warnings] == [("bad-transform", "/World/Lost")]
