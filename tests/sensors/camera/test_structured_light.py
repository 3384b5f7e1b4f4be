"""Structured light against triangles: where a pattern falls, how bright it is, and when it is shown.

A projector of 64 x 48 px with a focal length of 64 px stands 0.2 m to the right of camera C (500 px, 640 x 480).
"""

from fractions import Fraction

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, UsdGeom, UsdLux

from sensors import CameraSensor, RtxCamera, StructuredLightCamera
from sensors.camera.image_files import Image as Picture
from sensors.camera.light_images import Slide
from sensors.camera.structured_light import pattern_schedule, write_directions
from sensors.camera.textures import Texture, linear_table
from sensors.errors import SensorValueError
from sensors.replicator import get_annotator
from tests.support.camera_worlds import ahead
from tests.support.lidar_worlds import add_box, weightless

pytest.importorskip("OpenEXR", reason="comes with the extra exr")

SIZE, FOCAL, BASELINE = (64, 48), 64.0, 0.2
LENS = {"focalLength": 16.0, "horizontalAperture": 20.48, "clippingRange": Gf.Vec2f(0.01, 100)}


def pattern(folder, name, pixels):
    """A grey picture of 8 bits, whose numbers count as they are."""
    file = folder / f"{name}.png"
    Image.fromarray(np.asarray(pixels, np.uint8)).save(file)
    return file


def stripe(folder, column):
    pixels = np.zeros(SIZE[::-1])
    pixels[:, column] = 255
    return pattern(folder, f"stripe_{column}", pixels)


def rig(app, folder, patterns, **options):
    """The camera at the origin with its projector beside it: 1000 nit, a lens of 0.1 x 0.1 m."""
    write_directions(folder / "directions.exr", SIZE, FOCAL)
    values = {"projector_intensity": 1000.0, "projector_width": 0.1, "projector_height": 0.1}
    return StructuredLightCamera(
        "/World/Camera",
        patterns,
        folder / "directions.exr",
        projector_position=(BASELINE, 0, 0),
        attributes=LENS,
        app=app,
        **{**values, **options},
    )


def wall(app, depth):
    """A grey wall of 0.18."""
    box = add_box(app, "/World/Wall", 100.0, ahead(0, 0, depth + 50))
    UsdGeom.Gprim(box).CreateDisplayColorAttr([(0.18, 0.18, 0.18)])


def light(camera, app):
    """Linear light (480, 640) of the next picture: the first of three equal colours."""
    sensor = CameraSensor(camera, resolution=(480, 640), app=app)
    found = get_annotator("HdrColor", app=app).attach(sensor.render_product)
    app.play()
    app.update()
    return found.get_data()[..., 0].astype(np.float64)


@pytest.mark.parametrize("depth", [2.0, 4.0])
def test_a_stripe_falls_where_its_plane_meets_the_wall(tmp_path, depth):
    """Column 40 leaves at the tangent t = (40.5 - 32) / 64; it meets the wall at 0.2 + t z, seen at
    320 + 500 (t + 0.2 / z): 411.41 at 4 m, 436.41 at 2 m. From this follows the depth, 500 x 0.2 / (u - 320 - 500 t).
    """
    with weightless() as app:
        wall(app, depth)
        row = light(rig(app, tmp_path, [stripe(tmp_path, 40)]), app)[240]
    column = float((row * (np.arange(640) + 0.5)).sum() / row.sum())
    tangent = 8.5 / 64
    assert column == pytest.approx(320 + 500 * (tangent + BASELINE / depth), abs=0.05)
    assert 500 * BASELINE / (column - 320 - 500 * tangent) == pytest.approx(depth, rel=3e-3)


def test_the_first_row_of_a_pattern_is_on_top_and_beyond_the_pattern_it_is_dark(tmp_path):
    """The pattern ends 0.5 z beside the axis of the projector: at 4 m, at 320 + 500 x (0.2 +- 2) / 4 = 95 and 595, and
    0.375 z above and below: rows 52.5 and 427.5. Its upper half is white.
    """
    with weightless() as app:
        wall(app, 4.0)
        found = light(rig(app, tmp_path, [pattern(tmp_path, "half", [[255] * 64] * 24 + [[0] * 64] * 24)]), app)
    lit = found > 0
    assert np.flatnonzero(lit[100]).tolist() == list(range(95, 595))
    assert not lit[:52].any()
    assert lit[53, 345]
    assert not lit[245:].any()


@pytest.mark.parametrize(("grey", "share"), [(255, 1.0), (51, 0.2)])
def test_the_lens_is_as_bright_as_the_pattern_where_it_goes(tmp_path, grey, share):
    """On the axis E = L A / z^2 = 1000 x 0.01 / 16 = 0.625 lux, times the pattern; seen at column 345. 30 degrees
    aside would be outside; at 0.3 z aside, cos^4 = (1 / 1.09)^2.
    """
    with weightless() as app:
        wall(app, 4.0)
        found = light(rig(app, tmp_path, [pattern(tmp_path, "grey", np.full(SIZE[::-1], grey))]), app)[240]
    expected = 0.18 / np.pi * 0.625 * share
    assert found[345] == pytest.approx(expected, rel=2e-3)
    assert found[345 + 150] == pytest.approx(expected / 1.09**2, rel=2e-3)


def test_what_stands_in_the_way_throws_a_shadow_along_the_rays_of_the_projector(tmp_path):
    """A box from x = 0.1 to 0.3 at 1 m: its shadow at 4 m ends at 0.2 +- 0.4, seen at 295 and 395 behind the box's own
    332.5 to 470, so that 295 to 332 are dark.
    """
    with weightless() as app:
        wall(app, 4.0)
        add_box(app, "/World/Bar", 0.2, ahead(0.2, 0, 1.1))
        found = light(rig(app, tmp_path, [pattern(tmp_path, "white", np.full(SIZE[::-1], 255))]), app)[240]
    assert (found[200:294] > 0).all()
    assert (found[296:332] == 0).all()
    assert (found[472:590] > 0).all()


def test_a_table_is_turned_around_at_its_texels_whatever_its_distortion():
    rows, columns = np.meshgrid(np.arange(30.0), np.arange(40.0), indexing="ij")
    x, y = (columns - 19.5) / 40, (rows - 14.5) / 40
    bent = 1 + 0.3 * (x * x + y * y)
    grey = Picture(np.zeros((1, 2, 2), np.uint8))
    ones = np.ones(4, np.float32)
    slide = Slide(Texture(grey, linear_table(grey, "raw"), ("clamp",) * 2, ones, ones), np.stack([x * bent, y * bent]))
    across, down = slide.places((x * bent).ravel(), (y * bent).ravel())
    np.testing.assert_allclose(across * 40 - 0.5, columns.ravel(), atol=1e-5)
    np.testing.assert_allclose(down * 30 - 0.5, rows.ravel(), atol=1e-5)


def test_each_update_shows_the_last_pattern_that_began(tmp_path):
    """At 60 Hz; patterns begin at 0, 1/60 and 3/60 s, over and over after 4/60 s: time t shows that of t mod 4/60."""
    patterns = [stripe(tmp_path, column) for column in (10, 20, 30)]
    with weightless() as app:
        wall(app, 4.0)
        camera = rig(app, tmp_path, patterns, projector_timestamps=[(0, 1), (1, 60), (1, 20)])
        assert camera.get_projector_cycle_period() == (1, 15)
        shown = []
        app.play()
        for _ in range(8):
            app.update()
            lights = [
                UsdGeom.Imageable(prim).ComputeVisibility() == "inherited" for prim in camera.get_rect_light_prims()
            ]
            assert lights == [number == camera.get_active_pattern_index() for number in range(3)]
            shown.append(camera.get_active_pattern_index())
        app.stop()
        assert shown == [1, 1, 2, 0, 1, 1, 2, 0]
        assert camera.get_active_pattern_index() == 0
        assert not any(warning.code == "pattern-skipped" for warning in app.warnings)


def test_updates_that_pass_over_patterns_are_reported(tmp_path):
    """Three patterns of 1 ms each, updates at 16.67, 33.33, 50 and 66.67 ms, or 1.67, 0.33, 2 and 0.67 ms into 3 ms:
    from 1 to 0 and from 0 to 2 one is passed over.
    """
    stripes = [stripe(tmp_path, each) for each in (1, 2, 3)]
    with weightless() as app:
        camera = rig(app, tmp_path, stripes, projector_timestamps=[(0, 1), (1, 1000), (2, 1000)])
        app.play()
        shown = []
        for _ in range(4):
            app.update()
            shown.append(camera.get_active_pattern_index())
        codes = {warning.code for warning in app.warnings}
        camera.destroy()
    assert shown == [1, 0, 2, 0]
    assert {"projector-too-fast", "pattern-skipped"} <= codes


def test_the_prims_are_those_of_the_original(tmp_path):
    with weightless() as app:
        patterns = ["omniverse://server/p0.png", "missing/p1.png"]
        camera = StructuredLightCamera("/World/Camera", patterns, "omniverse://server/d.exr", app=app)
        lights = camera.get_rect_light_prims()
        assert [str(prim.GetPath()) for prim in lights] == [f"/World/Camera/projectors/RectLight_0{n}" for n in (0, 1)]
        assert all(prim.IsA(UsdLux.RectLight) and prim.HasAPI(UsdLux.ShapingAPI) for prim in lights)
        assert [prim.GetAttribute("inputs:texture:file").Get().path for prim in lights] == patterns
        values = {"isProjector": True, "visibleInPrimaryRay": False, "inputs:intensity": 150000.0, "inputs:width": 1.0}
        assert {name: lights[1].GetAttribute(name).Get() for name in values} == values
        assert camera.get_projector_timestamps() == [(0, 1), (1, 30)]
        assert camera.get_projector_cycle_period() == (1, 15)
        with pytest.raises(IndexError, match="pattern 2: there are 0 to 1"):
            camera.set_active_pattern_manual(2)
        camera.set_projector_cycle_period((1, 2))
        camera.set_projector_timestamps([(0, 1), (2, 10)])
        assert (camera.get_projector_timestamps(), camera.get_projector_cycle_period()) == ([(0, 1), (1, 5)], (1, 2))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"projector_light_patterns": []}, "projector_light_patterns: give a list of at least one image file"),
        ({"projector_direction_texture": None}, "projector_direction_texture: give an OpenEXR file of directions"),
        ({"projector_intensity": float("nan")}, "projector_intensity is nan; give a finite number from 0"),
        ({"projector_timestamps": [(0, 1)]}, "give 2 (numerator, denominator) [s]"),
        ({"projector_timestamps": [(1, 9), (2, 9)]}, "projector_timestamps[0] is 1/9 s; the first pattern begins"),
        ({"projector_timestamps": [(0, 1), (0, 9)]}, "projector_timestamps[1] is 0 s, not after 0 s"),
        ({"projector_timestamps": [(0, 1), (0.5, 1)]}, "projector_timestamps[1] is (0.5, 1); give two whole numbers"),
        ({"projector_timestamps": [(0, 1), (1, 0)]}, "projector_timestamps[1] is (1, 0); give two whole numbers"),
        ({"projector_cycle_period": (1, 30)}, "projector_cycle_period is 1/30; the last pattern begins at 1/30 s"),
    ],
)
def test_a_projector_that_cannot_be_is_refused_in_a_line(values, message):
    given = {"projector_light_patterns": ["a.png", "b.png"], "projector_direction_texture": "d.exr", **values}
    with weightless() as app:
        with pytest.raises(SensorValueError) as told:
            StructuredLightCamera("/World/Camera", app=app, **given)
        assert not app.stage.GetPrimAtPath("/World/Camera")
    assert message in str(told.value)
    assert "\n" not in str(told.value)


def test_times_are_exact():
    """0.1 + 0.2 in floats would be past 0.3: pattern 1 begins at 3/10 to the last bit."""
    schedule = pattern_schedule([(0, 1), (3, 10)], (6, 10), 2, "here")
    assert schedule.active(Fraction(3, 10) - Fraction(1, 10**18)) == 0
    assert schedule.active(Fraction(3, 10)) == 1
    assert schedule.active(Fraction(6, 10)) == 0
    assert schedule.shortest == Fraction(3, 10)


def test_a_pattern_that_is_not_there_leaves_the_projector_dark_with_a_warning(tmp_path):
    with weightless() as app:
        wall(app, 4.0)
        found = light(rig(app, tmp_path, [tmp_path / "none.png"]), app)
        told = [str(warning) for warning in app.warnings if warning.code == "texture-not-read"]
    assert not found.any()
    assert told
    assert "RectLight_00" in told[0]
    assert "none.png does not exist; it stays dark" in told[0]


def test_a_textured_rectangle_shines_as_its_mean_does(tmp_path):
    """Half of it black, half white: 0.5 x 1000 nit of 0.1 x 0.1 m at 4 m is 0.3125 lux."""
    file = pattern(tmp_path, "half", [[255, 0]])
    with weightless() as app:
        wall(app, 4.0)
        lamp = UsdLux.RectLight.Define(app.stage, "/World/Lamp")
        lamp.CreateIntensityAttr(1000.0)
        lamp.CreateWidthAttr(0.1)
        lamp.CreateHeightAttr(0.1)
        lamp.CreateTextureFileAttr(str(file))
        found = light(RtxCamera("/World/Camera", attributes=LENS, app=app), app)
    assert found[240, 320] == pytest.approx(0.18 / np.pi * 0.3125, rel=2e-3)
