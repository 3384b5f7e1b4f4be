"""Domes with an image: where it shows, how it lights, which files are read."""

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, UsdGeom, UsdLux

from sensors.camera.image_files import Image as Pixels
from sensors.camera.radiance_hdr import decoded
from sensors.camera.sky import Sky, sky_image
from sensors.camera.textures import Texture, linear_table
from tests.support.camera_worlds import add_camera, ahead, look
from tests.support.lidar_worlds import add_box, weightless

SIZE = (101, 101)


def sky(pixels, turn=None, color=(1.0, 1.0, 1.0)):
    image = Pixels(np.ascontiguousarray(np.moveaxis(pixels, 2, 0), np.uint8))
    ones = np.ones(4, np.float32)
    texture = Texture(image, linear_table(image, "raw"), ("repeat", "clamp"), ones, 0 * ones)
    return Sky(sky_image(texture), np.array(color, np.float32), np.eye(3) if turn is None else turn)


@pytest.mark.parametrize(
    ("way", "column", "row"),
    [
        ((0, 0, 1), 0.5, 0.5),  # the middle of the image
        ((1, 0, 0), 0.25, 0.5),
        ((-1, 0, 0), 0.75, 0.5),
        ((0, np.sqrt(0.5), np.sqrt(0.5)), 0.5, 0.25),
        ((0, -np.sqrt(0.5), np.sqrt(0.5)), 0.5, 0.75),
    ],
)
def test_where_an_image_shows(way, column, row):
    """Red is the column of 256, green the row of 128."""
    rows, columns = np.mgrid[:128, :256]
    found = sky(np.stack([columns, rows, 0 * rows], axis=-1)).radiance(np.array(way, np.float32)[:, None])[0]
    np.testing.assert_allclose(found[:2], [(256 * column - 0.5) / 255, (128 * row - 0.5) / 255], atol=1e-4)


def test_a_sky_of_one_colour_brings_pi_times_it():
    found = sky(np.full((10, 20, 3), 255), color=(1, 2, 3)).irradiance(np.eye(3, dtype=np.float32))
    np.testing.assert_allclose(found, np.pi * np.array([[1], [2], [3]]) + np.zeros((3, 3)), rtol=3e-4)


@pytest.mark.parametrize("rows", [2, 64, 500])
def test_half_a_sky_lights_a_leaning_surface_by_its_share(rows):
    """The upper half at 1: E = pi (1 + cos) / 2, which nine harmonics hold exactly."""
    pixels = np.zeros((rows, 2 * rows, 3))
    pixels[: rows // 2] = 255
    lean = np.deg2rad([0, 30, 90, 150, 180])
    ways = np.stack([np.sin(lean), np.cos(lean), 0 * lean]).astype(np.float32)
    found = sky(pixels).irradiance(ways)[0]
    np.testing.assert_allclose(found, np.pi * (1 + np.cos(lean)) / 2, atol=2e-3)


def dome(app, file, turn=(0, 0, 0), **inputs):
    light = UsdLux.DomeLight.Define(app.stage, "/World/Sky")
    light.CreateTextureFileAttr(str(file))
    for name, value in inputs.items():
        light.GetPrim().GetAttribute(f"inputs:{name}").Set(value)
    UsdGeom.XformCommonAPI(light).SetRotate(Gf.Vec3f(*turn))
    return light


def test_a_camera_sees_the_image_upright_and_not_mirrored(tmp_path):
    """Turned by 180 degrees about y the dome has the middle of its image ahead; 45 degrees to the right are 1/8."""
    rows, columns = np.mgrid[:128, :256]
    Image.fromarray(np.stack([columns, rows], axis=-1)[..., [0, 1, 1]].astype(np.uint8)).save(tmp_path / "s.png")
    with weightless() as app:
        dome(app, tmp_path / "s.png", (0, 180, 0), intensity=100.0)
        [light] = look(app, add_camera(app, size=SIZE, focal=10.0, aperture=20.0 * 101 / 100), "HdrColor")

    def linear(number):
        x = number / 255
        return 100 * ((x + 0.055) / 1.055) ** 2.4

    middle, right, below = light[50, 50].astype(float), light[50, 100].astype(float), light[100, 50].astype(float)
    np.testing.assert_allclose(middle[:2], [linear(127.5), linear(63.5)], rtol=5e-3)
    np.testing.assert_allclose(right[0], linear(127.5 + 32), rtol=5e-3)
    np.testing.assert_allclose(below[1], linear(63.5 + 32), rtol=5e-3)


def test_surfaces_are_lit_by_the_image(tmp_path):
    """A grey wall that faces the camera is lit by the half of the sky behind it, +z: white there, black elsewhere."""
    pixels = np.zeros((64, 128, 3), np.uint8)
    pixels[:, 32:96] = 255
    Image.fromarray(pixels).save(tmp_path / "s.png")
    with weightless() as app:
        dome(app, tmp_path / "s.png", intensity=10.0)
        add_box(app, "/World/Wall", 100.0, ahead(0, 0, 52))
        [light] = look(app, add_camera(app, size=SIZE), "HdrColor")
    np.testing.assert_allclose(light[50, 50, :3].astype(float), 0.18 * 10, rtol=5e-3)  # 0.18 / pi x pi 10


def hdr(width, height, rows, header=b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n"):
    return header + f"-Y {height} +X {width}\n".encode() + rows


def test_radiance_pictures_are_read_packed_and_flat(tmp_path):
    """(128, 64, 0) with the exponent 129: x 2^(129 - 136), (1, 0.5, 0); in runs of 8 pixels, or each by itself."""
    packed = b"".join(
        bytes([2, 2, 0, 8]) + b"".join(bytes([128 + 8, each]) for each in (128, 64, 0, 129)) for _ in "ab"
    )
    mixed = b"".join(
        bytes([2, 2, 0, 8]) + b"".join(bytes([3, each, each, each, 128 + 5, each]) for each in (128, 64, 0, 129))
        for _ in "ab"
    )
    flat = bytes((128, 64, 0, 129)) * 8
    for width, height, rows in ((8, 2, packed), (8, 2, mixed), (4, 2, flat)):
        np.testing.assert_array_equal(decoded(hdr(width, height, rows)), np.full((height, width, 4), (128, 64, 0, 129)))
    (tmp_path / "s.hdr").write_bytes(hdr(8, 2, packed))
    with weightless() as app:
        dome(app, tmp_path / "s.hdr", intensity=50.0)
        [light] = look(app, add_camera(app, size=SIZE), "HdrColor")
    np.testing.assert_allclose(light[50, 50, :3], [50, 25, 0])


@pytest.mark.parametrize(
    "content",
    [
        hdr(8, 2, bytes([2, 2, 0, 8, 136, 1])),
        hdr(8, 2, bytes([2, 2, 0, 9]) * 9),
        hdr(8, 2, bytes([2, 2, 0, 8, 200, 1]) * 9),
        hdr(8, 2, bytes([2, 2, 0, 8, 0, 1]) * 9),
        hdr(4, 4, b""),
        hdr(999999, 999999, b""),
        b"#?RADIANCE\n\n+Y 2 +X 2\n" + bytes(16),
        b"not an image",
    ],
)
def test_a_damaged_sky_is_one_warning_and_a_plain_colour(tmp_path, content):
    (tmp_path / "s.hdr").write_bytes(content)
    with weightless() as app:
        dome(app, tmp_path / "s.hdr", intensity=50.0, color=Gf.Vec3f(1, 0.5, 0))
        [light] = look(app, add_camera(app, size=SIZE), "HdrColor")
        [said] = [one.message for one in app.warnings if one.code == "texture-not-read"]
    assert light[50, 50, :3].tolist() == [50, 25, 0]
    assert said.endswith("; the sky has one plain colour")
    assert said.startswith("s.hdr")
