"""Shipped cameras: names, fields of view, lenses, and what a stereo camera tells its render product."""

import math

import numpy as np
import pytest

from graph.base.errors import UserError
from graph.cli.main import main
from graph.sim import App
from sensors import SUPPORTED_CAMERA_CONFIGS, RtxCamera, SingleViewDepthCameraSensor
from sensors.camera.config import read_config
from sensors.camera.lens import BrownLens, FisheyeLens
from sensors.configs import author_config
from sensors.configs.cameras import camera_assets, find_camera

ASSETS = camera_assets()


@pytest.fixture
def app():
    with App() as app:
        yield app


def configured(app, config, variant=None, size=None):
    prim = app.stage.DefinePrim("/World/Camera", "Camera")
    author_config(prim, config, variant)
    imager = find_camera(config).imager(variant)
    return read_config(prim, size or imager.resolution, app.meters_per_unit)


def test_the_table_has_the_26_assets_of_the_product():
    assert len(SUPPORTED_CAMERA_CONFIGS) == 26
    assert SUPPORTED_CAMERA_CONFIGS["/Isaac/Sensors/RealSense/D455/rsd455.usd"] == {
        "display_name": "Realsense D455",
        "is_depth_sensor": True,
    }
    assert sum(one.get("is_depth_sensor", False) for one in SUPPORTED_CAMERA_CONFIGS.values()) == 15


@pytest.mark.parametrize("asset", ASSETS, ids=lambda asset: asset.short_name)
def test_every_imager_is_a_camera_with_its_field_of_view_and_says_where_its_figures_are_from(asset):
    """The ray through the middle of the right edge is half the field of view off the axis, without distortion."""
    assert len(asset.source) > 30
    for name in asset.imagers:
        with App() as app:
            config = configured(app, asset.short_name, name)
        imager = asset.imager(name)
        assert config.size == imager.resolution
        width, height = config.size
        if imager.lens is None:
            edge = config.lens.unproject(np.array([[float(width)], [height / 2]]))[:, 0]
            assert math.degrees(2 * math.atan2(edge[0], edge[2])) == pytest.approx(imager.fov_deg, rel=1e-5)
        assert config.near == pytest.approx(0.01)


def test_a_field_of_view_counts_the_distortion():
    """Of the D455's colours: x g(x^2) + p2 3 x^2 is (1280 - 628.95) / 629.56 on the right, -628.95 / 629.56 on the
    left, by hand.
    """
    imager = find_camera("D455").imager("color")
    ends = []
    for to in (-628.95 / 629.56, 651.05 / 629.56):
        roots = np.roots([-0.0161, 0, 0.0603, 0, -0.0557, -0.00085 * 3, 1, -to])
        ends.append(min((root.real for root in roots if abs(root.imag) < 1e-9), key=lambda x: abs(x - to)))
    expected = math.degrees(math.atan(ends[1]) - math.atan(ends[0]))
    assert imager.fields_deg[0] == pytest.approx(expected, abs=0.01)  # the middle row is 2.5 px from the lens's axis
    assert find_camera("SG8-H120YA").imager().fields_deg[0] == pytest.approx(120)


@pytest.mark.parametrize(
    ("name", "variant", "across"),
    [
        ("SG2-H100F1A", None, 100),
        ("SG2-H60YA", None, 60),
        ("SG3-H190XA", None, 190),
        ("SG8-H30YA", None, 30),
        ("Femto Mega", "narrow", 75),
        ("Femto Mega", "wide", 120),
        ("Femto Mega", "color", 80),
        ("Gemini 2", "color", 86),
        ("D555", "color", 90),
    ],
)
def test_focal_length_film_and_distortion_of_an_asset_give_the_field_that_its_maker_names(name, variant, across):
    """The figures are those of Isaac Sim's page; the fields are in the makers' data and in the products' names."""
    assert find_camera(name).imager(variant).fields_deg[0] == pytest.approx(across, abs=1.5)


@pytest.mark.parametrize("name", ["/Isaac/Sensors/RealSense/D455/rsd455.usd", "rsd455", "Realsense D455", "D455"])
def test_a_camera_is_found_by_any_spelling(name):
    assert find_camera(name).path == "/Isaac/Sensors/RealSense/D455/rsd455.usd"


def test_the_hawk_has_the_public_lens(app):
    config = configured(app, "hawk_v1.1_nominal", "left")
    assert isinstance(config.lens, BrownLens)
    assert config.lens.fx == pytest.approx(957.81)
    # The optical centre is that of the page, not the middle of the image (960, 600).
    assert (config.lens.cx, config.lens.cy) == pytest.approx((957.85107, 589.53766), rel=1e-6)
    assert config.lens.k == pytest.approx((0.147811, -0.032313, 0.008823, 0.517913, -0.06708, 0.01695))
    assert config.focal_length / config.apertures[0] * 1920 == pytest.approx(957.81, rel=1e-5)


def test_a_wide_camera_is_a_fisheye_that_sees_beyond_its_side(app):
    lens = configured(app, "SG3-H190XA").lens
    assert isinstance(lens, FisheyeLens)
    angle = math.radians(94)
    squared = angle**2
    bent = angle * (
        1 + squared * (0.132158875 + squared * (-0.031036589 + squared * (-0.004391152 + squared * 0.001811683)))
    )
    beside = np.array([[math.sin(angle)], [0.0], [math.cos(angle)]])
    assert lens.project(beside)[:, 0] == pytest.approx([960.60822 + 1.51 / 5.76 * 1920 * bent, 768], rel=1e-6)


def test_the_two_cameras_of_the_hawk_have_lenses_of_their_own(app):
    """By the same page: 2.87798 mm on 5.76 mm are 959.327 px."""
    right = configured(app, "hawk_v1.1_nominal", "right").lens
    assert right.fx == pytest.approx(959.3266, rel=1e-6)
    assert (right.cx, right.cy) == pytest.approx((954.70923, 588.3736), rel=1e-6)
    assert right.k == pytest.approx((6.815791, 5.172144, 0.353267, 7.180808, 7.640372, 1.596375))


def test_the_owl_sees_behind_itself_on_both_sides():
    """Its edges are 943.99 and 976.01 px of 454.87 px from the axis: radii 2.0753 and 2.1457 rad, within its fold."""
    across, _ = find_camera("Owl").imager().fields_deg
    ends = []
    for to in (943.99462890625, 1920 - 943.99462890625):
        roots = np.roots([-0.000472, 0, -0.002978, 0, 0.012671, 0, 0.057225, 0, 1, -to / 454.8684359])
        ends.append(min(root.real for root in roots if abs(root.imag) < 1e-9 and root.real > 0))
    assert across == pytest.approx(math.degrees(sum(ends)), abs=1e-3)


def test_a_configured_camera_is_scaled_to_the_image(app):
    lens = configured(app, "D455", "color", (640, 400)).lens
    assert (lens.fx, lens.cy) == pytest.approx((314.78, 198.735))


def test_unknown_names_and_imagers_are_told_with_similar_ones(app):
    with pytest.raises(UserError, match="no camera config 'D456'; did you mean"):
        configured(app, "D456")
    with pytest.raises(UserError, match="has no variant 'colour'; did you mean"):
        configured(app, "D455", "colour")
    with pytest.raises(ValueError, match="no camera config 'D456'"):
        RtxCamera.create("/World/Other", config="D456", app=app)


def test_a_stereo_camera_brings_its_baseline_to_the_depth_sensor(app):
    """87 deg across 1280 px: f = 640 / tan 43.5 deg = 674.42 px; f b / Z = 674.42 x 0.095 / 0.52 = 123.2 px."""
    camera = RtxCamera.create("/World/Camera", config="D455", variant="depth", app=app)
    stereo = SingleViewDepthCameraSensor(camera, resolution=(72, 128), app=app).stereo
    assert (stereo.baseline_mm, stereo.sensor_size_pixel, stereo.max_disparity_pixel) == (95, 1280, 124)
    assert stereo.focal_length_pixel == pytest.approx(640 / math.tan(math.radians(43.5)))
    assert (stereo.min_distance, stereo.max_distance) == pytest.approx((0.52, 20))


def test_a_graph_file_takes_a_camera_by_name(tmp_path, capsys):
    path = tmp_path / "camera.yaml"
    path.write_text(
        "tickgraph: 1\nscene:\n  prims:\n    /World/Cam: {type: Camera, config: ZED_X, variant: right}\n"
        "    /World/Bad: {type: Camera, config: ZED_Y}\n"
    )
    assert main(["check", str(path)]) == 2
    said = capsys.readouterr().err
    assert said.count("camera.yaml:") == 1
    assert "camera.yaml:5:" in said
    assert "did you mean" in said


def test_the_list_of_configurations_has_cameras_and_a_page_for_each(capsys):
    assert main(["sensors"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 21 + 26 + 1
    assert main(["sensors", "hawk"]) == 0
    page = capsys.readouterr().out
    assert "1920 x 1200 pixels" in page
    assert "baseline" in page
    assert "variant: left" in page
