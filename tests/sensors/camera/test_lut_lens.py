"""Lenses of look-up tables: the tables of a lens that has a formula give what the formula gives."""

import sys

import numpy as np
import pytest
from pxr import UsdGeom

from graph.base.errors import UserError
from graph.sim import App
from sensors.camera.config import read_config
from sensors.camera.lens import FisheyeLens
from tests.support.camera_worlds import add_camera, ahead, look

OpenEXR = pytest.importorskip("OpenEXR", reason="comes with the extra exr")

WIDTH, HEIGHT = 160, 120
FISHEYE = FisheyeLens(WIDTH, HEIGHT, 70.0, 70.0, 82.0, 58.0, (1.0, 0.05, 0.01, -0.003, -0.0005))
OCTAHEDRON = 512


def write(file, pixels):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": np.ascontiguousarray(pixels, np.float32)}) as image:
        image.write(str(file))


def enter():
    """(h, w, 3), in the axes of a USD camera."""
    return FISHEYE.unproject(FISHEYE.centres()).T.reshape(HEIGHT, WIDTH, 3) * (1, -1, -1)


def leave():
    """(o, o, 3): u, v, 0 of the directions of an octahedron with -z in its middle; -1 outside the image."""
    middles = (np.arange(OCTAHEDRON) + 0.5) / OCTAHEDRON * 2 - 1
    x, y = np.meshgrid(middles, middles)
    z = 1 - np.abs(x) - np.abs(y)
    back = z < 0
    sign_x, sign_y = np.where(x < 0, -1, 1), np.where(y < 0, -1, 1)
    x, y = np.where(back, (1 - np.abs(y)) * sign_x, x), np.where(back, (1 - np.abs(x)) * sign_y, y)
    optical = np.stack([x, -y, z]).reshape(3, -1)  # the octahedron's y is up, ahead is in its middle
    u, v = FISHEYE.project(optical)
    places = np.stack([u / WIDTH, v / HEIGHT, 0 * u], axis=1)
    return np.where(np.isfinite(places), places, -1).reshape(OCTAHEDRON, OCTAHEDRON, 3)


@pytest.fixture
def camera(tmp_path):
    """An App with a camera whose lens is that of the tables in tmp_path; `read` gives the lens."""
    write(tmp_path / "enter.exr", enter())
    write(tmp_path / "leave.exr", leave())
    with App() as app:
        app.product = add_camera(app, size=(WIDTH, HEIGHT))
        app.prim = app.stage.GetPrimAtPath("/World/Camera")
        app.prim.AddAppliedSchema("OmniLensDistortionLutAPI")
        app.prim.GetAttribute("omni:lensdistortion:lut:rayEnterDirectionTexture").Set(str(tmp_path / "enter.exr"))
        app.prim.GetAttribute("omni:lensdistortion:lut:rayExitPositionTexture").Set(str(tmp_path / "leave.exr"))
        app.read = lambda **options: read_config(app.prim, (WIDTH, HEIGHT), 1.0, **options).lens
        yield app


def test_pixels_look_where_the_table_says(camera):
    lens, every = camera.read(), FISHEYE.centres()
    np.testing.assert_allclose(lens.unproject(every), FISHEYE.unproject(every), atol=1e-6)
    assert lens.fx == pytest.approx(70.0, rel=0.01)  # in the middle, 2 px from its axis


def test_directions_go_where_the_other_table_says(camera):
    """Between texels 1 / 256 apart the places are off by their curvature: below a tenth of a pixel."""
    every = FISHEYE.centres()
    np.testing.assert_allclose(camera.read().project(FISHEYE.unproject(every)), every, atol=0.1)
    assert np.isnan(camera.read().project(np.array([[0.0], [0.0], [-1.0]]))).all()


def test_a_camera_casts_by_its_table(camera):
    """A wall at z 4 is 4 m from the image plane, whatever the lens; that it is reached differs by pixel."""
    wall = UsdGeom.Cube.Define(camera.stage, "/World/Wall")
    wall.GetSizeAttr().Set(2000.0)
    UsdGeom.XformCommonAPI(wall).SetTranslate(ahead(0, 0, 1004))
    plane, distance = look(camera, camera.product, "distance_to_image_plane", "distance_to_camera")
    ways = FISHEYE.unproject(FISHEYE.centres())[2].reshape(HEIGHT, WIDTH)
    forward = ways > 0.01
    np.testing.assert_allclose(plane[forward], 4.0, rtol=1e-4)
    np.testing.assert_allclose(distance[forward], 4 / ways[forward], rtol=1e-4)


def test_where_the_table_has_no_direction_a_pixel_shows_nothing(camera, tmp_path):
    table = enter()
    table[:, :20] = (0, 0, 1)
    write(tmp_path / "enter.exr", table)
    found = camera.read().unproject(FISHEYE.centres()).reshape(3, HEIGHT, WIDTH)
    assert not found[:, :, :20].any()
    assert found[:, :, 20:].any(axis=0).all()


def test_bad_tables_are_told_in_a_line(camera, tmp_path, monkeypatch):
    with pytest.raises(UserError, match=r"enter\.exr lies outside the scene's folders"):
        camera.read(folders=[tmp_path / "other"])
    camera.prim.GetAttribute("omni:lensdistortion:lut:opticalCenter").Set((10, 10))
    with pytest.raises(UserError, match="opticalCenter: tables hold the centre; give half the nominal size"):
        camera.read()
    camera.prim.GetAttribute("omni:lensdistortion:lut:opticalCenter").Clear()
    (tmp_path / "enter.exr").write_bytes(b"no image")
    with pytest.raises(UserError, match=r"rayEnterDirectionTexture: enter\.exr cannot be read"):
        camera.read()
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    with pytest.raises(UserError, match=r"is an OpenEXR file\. Run: .*pip install .*\[exr\]'"):
        camera.read()
