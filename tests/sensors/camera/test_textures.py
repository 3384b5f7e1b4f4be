"""Textures in pictures: which pixel of an image shows where, and how its numbers become light.

Under a dome of radiance 1 everywhere a surface sends back its base colour: pi x 1 lux x base / pi.
"""

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade, UsdUtils, Vt

from graph.base.limits import raised
from graph.sim import App
from sensors.camera.image_files import ImageFiles
from tests.support.camera_worlds import add_camera, ahead, look
from tests.support.lidar_worlds import add_box, weightless

TYPES = Sdf.ValueTypeNames
SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
SIZE = (100, 100)
HALF = 2.0**-11
"""float16 has 11 binary digits: relative error of the output, at most 2^-12 near 1."""


def picture(path, pixels):
    Image.fromarray(np.asarray(pixels, np.uint8)).save(path)
    return path


def quad(app, path="/World/Quad", st=SQUARE, interpolation="vertex", indices=None, centre=(0, 0, 2), scale=None):
    """A square of 2 m, 2 m ahead: it fills the image of `seen` to its edges. Points: below left, then to the right."""
    mesh = UsdGeom.Mesh.Define(app.stage, path)
    mesh.CreatePointsAttr([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateSubdivisionSchemeAttr("none")
    xform = UsdGeom.XformCommonAPI(mesh)
    xform.SetTranslate(Gf.Vec3d(*ahead(*centre)))
    if scale is not None:
        xform.SetScale(Gf.Vec3f(*scale))
    if st is not None:
        primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", TYPES.TexCoord2fArray, interpolation)
        primvar.Set(Vt.Vec2fArray([Gf.Vec2f(*each) for each in st]))
        if indices is not None:
            primvar.SetIndices(Vt.IntArray(indices))
    return mesh


def shader(app, path, kind, **inputs):
    node = UsdShade.Shader.Define(app.stage, path)
    node.CreateIdAttr(kind)
    for name, (type_name, value) in inputs.items():
        node.CreateInput(name, type_name).Set(value)
    return node


def textured(app, file, *, into="diffuseColor", output="rgb", transform=None, path="/World/Look", **inputs):
    """A material whose `into` is a texture at primvars:st, through a UsdTransform2d if given."""
    material = UsdShade.Material.Define(app.stage, path)
    surface = shader(app, f"{path}/Surface", "UsdPreviewSurface")
    reader = shader(app, f"{path}/Reader", "UsdPrimvarReader_float2", varname=(TYPES.String, "st"))
    texture = shader(app, f"{path}/Texture", "UsdUVTexture", file=(TYPES.Asset, str(file)), **inputs)
    place = reader
    if transform:
        place = shader(app, f"{path}/Place", "UsdTransform2d", **transform)
        place.CreateInput("in", TYPES.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
    texture.CreateInput("st", TYPES.Float2).ConnectToSource(place.ConnectableAPI(), "result")
    kind = TYPES.Color3f if output == "rgb" else TYPES.Float
    surface.CreateInput(into, kind).ConnectToSource(texture.ConnectableAPI(), output)
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    return material


def bind(prim, material):
    UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(material)


def sky(app, radiance=1.0):
    UsdLux.DomeLight.Define(app.stage, "/World/Sky").CreateIntensityAttr(radiance)


def seen(app, *names):
    """Linear colours of 100 x 100 pixels over the square, (100, 100, 3) float64: column j at s = (j + 0.5) / 100."""
    found = look(app, add_camera(app, size=SIZE, focal=20.0, aperture=20.0), "HdrColor", *names)
    light = found[0][..., :3].astype(np.float64)
    return (light, *found[1:]) if names else light


ACROSS, UP = (np.arange(100) + 0.5) / 100, (99.5 - np.arange(100)) / 100
RAW = {"sourceColorSpace": (TYPES.Token, "raw")}


def show(tmp_path, pixels, st=SQUARE, transform=None, interpolation="vertex", indices=None, **inputs):
    with weightless() as app:
        sky(app)
        mesh = quad(app, st=st, interpolation=interpolation, indices=indices)
        bind(mesh, textured(app, picture(tmp_path / "t.png", pixels), transform=transform, **{**RAW, **inputs}))
        return seen(app)


def test_s_runs_to_the_right_and_t_upwards_from_the_middles_of_the_outer_pixels(tmp_path):
    """Red is the column and green the row of 11 x 11 pixels, in tenths: between middles the value is linear."""
    rows, columns = np.mgrid[:11, :11]
    found = show(tmp_path, np.stack([columns * 25, rows * 25, 0 * rows], axis=-1))
    inside = slice(5, 95)  # 0.5 / 11 from the edges repeat sets in
    red, green = (np.clip(11 * ACROSS - 0.5, 0, 10) * 25 / 255, np.clip(11 * (1 - UP) - 0.5, 0, 10) * 25 / 255)
    np.testing.assert_allclose(found[inside, inside, 0], np.broadcast_to(red[inside], (90, 90)), atol=HALF)
    np.testing.assert_allclose(found[inside, inside, 1], np.broadcast_to(green[inside, None], (90, 90)), atol=HALF)


@pytest.mark.parametrize(
    ("wrap", "left", "right"),
    # st runs from -1 to 2 over the square: thirds. The image is black, then white, two pixels wide.
    [("repeat", (0, 1), (0, 1)), ("clamp", (0, 0), (1, 1)), ("mirror", (1, 0), (1, 0)), ("black", (0, 0), (0, 0))],
)
def test_beyond_the_image_is_what_the_wrap_says(tmp_path, wrap, left, right):
    st = [(-1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (-1.0, 1.0)]
    wraps = {"wrapS": (TYPES.Token, wrap), "wrapT": (TYPES.Token, wrap)}
    row = show(tmp_path, [[[0] * 3, [255] * 3]], st=st, **wraps)[50, :, 0]
    # Middles of the pixels of the three images, at -0.75, -0.25, 0.25 ... of s: columns 8.3, 25, 41.7, 58.3, 75, 91.7.
    for column, value in zip((8, 25, 41, 58, 75, 91), (*left, 0, 1, *right), strict=True):
        assert row[column] == pytest.approx(value, abs=0.06), column


@pytest.mark.parametrize(
    ("interpolation", "st", "indices", "corners"),
    [
        ("constant", [(0.75, 0.25)], None, [(0.75, 0.25)] * 4),
        ("uniform", [(0.25, 0.75)], None, [(0.25, 0.75)] * 4),
        ("vertex", SQUARE, None, SQUARE),
        ("varying", SQUARE, None, SQUARE),
        ("faceVarying", SQUARE, None, SQUARE),
        ("faceVarying", [(1.0, 1.0), (0.0, 0.0)], [1, 1, 0, 0], [(0, 0), (0, 0), (1, 1), (1, 1)]),
    ],
)
def test_coordinates_of_every_interpolation(tmp_path, interpolation, st, indices, corners):
    """Of an image whose red is s and green 1 - t, at the middle of the square and near its corners."""
    rows, columns = np.mgrid[:256, :256]
    found = show(
        tmp_path,
        np.stack([columns, rows, 0 * rows], axis=-1),
        st=st,
        interpolation=interpolation,
        indices=indices,
        wrapS=(TYPES.Token, "clamp"),
        wrapT=(TYPES.Token, "clamp"),
    )
    corners = np.array(corners, float)
    for row, column in ((98, 1), (98, 98), (1, 98), (1, 1)):
        x, y = ACROSS[column], UP[row]  # the square is cut from its first corner to its third
        weights = (1 - x, x - y, y, 0) if x >= y else (1 - y, 0, x, y - x)
        s, t = weights @ corners
        expected = np.clip([256 * s - 0.5, 256 * (1 - t) - 0.5], 0, 255) / 255
        np.testing.assert_allclose(found[row, column, :2], expected, atol=2 * HALF)


@pytest.mark.parametrize(
    ("space", "mode", "value"),
    [
        ("sRGB", "RGB", ((128 / 255 + 0.055) / 1.055) ** 2.4),  # 0.21586
        ("raw", "RGB", 128 / 255),
        ("auto", "RGB", ((128 / 255 + 0.055) / 1.055) ** 2.4),
        ("auto", "L", 128 / 255),
        ("sRGB", "L", ((128 / 255 + 0.055) / 1.055) ** 2.4),
    ],
)
def test_the_colour_space_says_what_numbers_mean(tmp_path, space, mode, value):
    pixels = np.full((4, 4) if mode == "L" else (4, 4, 3), 128)
    found = show(tmp_path, pixels, sourceColorSpace=(TYPES.Token, space))
    np.testing.assert_allclose(found[50, 50], value, rtol=2 * HALF)


def test_sixteen_bits_are_raw(tmp_path):
    with weightless() as app:
        sky(app)
        Image.fromarray(np.full((2, 2), 40000, np.uint16)).save(tmp_path / "t.png")
        bind(quad(app), textured(app, tmp_path / "t.png"))
        np.testing.assert_allclose(seen(app)[50, 50], 40000 / 65535, rtol=2 * HALF)


def test_scale_and_bias_count_after_the_colour_space(tmp_path):
    found = show(
        tmp_path,
        np.full((2, 2, 3), 51),  # 0.2
        scale=(TYPES.Float4, Gf.Vec4f(2, 1, 0.5, 1)),
        bias=(TYPES.Float4, Gf.Vec4f(0.1, 0, 0.25, 0)),
    )
    np.testing.assert_allclose(found[50, 50], [0.5, 0.2, 0.35], rtol=2 * HALF)


def test_a_transform_scales_then_turns_then_moves(tmp_path):
    """(0.5, 0.25) x 2, turned by 90 degrees, (-0.5, 1), moved by (0.75, -0.25): (0.25, 0.75)."""
    rows, columns = np.mgrid[:256, :256]
    found = show(
        tmp_path,
        np.stack([columns, rows, 0 * rows], axis=-1),
        st=[(0.5, 0.25)],
        interpolation="constant",
        transform={
            "scale": (TYPES.Float2, Gf.Vec2f(1, 2)),
            "rotation": (TYPES.Float, 90.0),
            "translation": (TYPES.Float2, Gf.Vec2f(0.75, 0.25)),
        },
    )
    # (0.5, 0.5) after the scale, (-0.5, 0.5) after the turn, (0.25, 0.75) after the move.
    expected = np.array([256 * 0.25 - 0.5, 256 * 0.25 - 0.5]) / 255
    np.testing.assert_allclose(found[50, 50, :2], expected, atol=HALF)


def test_a_mirrored_square_shows_its_texture_mirrored(tmp_path):
    columns = np.repeat(np.arange(256)[None, :, None], 2, axis=0) + np.zeros(3, int)
    with weightless() as app:
        sky(app)
        bind(quad(app, scale=(-1, 1, 1)), textured(app, picture(tmp_path / "t.png", columns), **RAW))
        found = seen(app)[50, :, 0]
    np.testing.assert_allclose(found[2:98], ((1 - ACROSS) * 256 - 0.5)[2:98] / 255, atol=HALF)


def test_subsets_show_their_own_textures(tmp_path):
    with weightless() as app:
        sky(app)
        mesh = quad(app, st=None)
        mesh.CreatePointsAttr([(-1, -1, 0), (0, -1, 0), (1, -1, 0), (1, 1, 0), (0, 1, 0), (-1, 1, 0)])
        mesh.CreateFaceVertexCountsAttr([4, 4])
        mesh.CreateFaceVertexIndicesAttr([0, 1, 4, 5, 1, 2, 3, 4])
        st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", TYPES.TexCoord2fArray, "uniform")
        st.Set(Vt.Vec2fArray([Gf.Vec2f(0.25, 0.5), Gf.Vec2f(0.75, 0.5)]))
        for name, face in (("left", 0), ("right", 1)):
            subset = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).CreateMaterialBindSubset(name, [face])
            image = picture(tmp_path / f"{name}.png", [[[51 + 51 * face] * 3, [153 + 51 * face] * 3]])
            bind(subset, textured(app, image, path=f"/World/{name}", **RAW))
        found = seen(app)[50, :, 0]
    # Left: the dark pixel of the first image, 51; right: the bright one of the second, 204.
    np.testing.assert_allclose(found[[10, 90]], [51 / 255, 204 / 255], rtol=2 * HALF)


def test_omni_pbr_shows_its_texture_tinted(tmp_path):
    with weightless() as app:
        sky(app)
        material = UsdShade.Material.Define(app.stage, "/World/Look")
        node = UsdShade.Shader.Define(app.stage, "/World/Look/Shader")
        node.SetSourceAsset("OmniPBR.mdl", "mdl")
        node.SetSourceAssetSubIdentifier("OmniPBR", "mdl")
        file = node.CreateInput("diffuse_texture", TYPES.Asset)
        file.Set(str(picture(tmp_path / "t.png", np.full((2, 2, 3), 255))))
        node.CreateInput("diffuse_tint", TYPES.Color3f).Set(Gf.Vec3f(0.5, 1, 0.25))
        material.CreateSurfaceOutput("mdl").ConnectToSource(node.ConnectableAPI(), "out")
        bind(quad(app), material)
        found = seen(app)
    np.testing.assert_allclose(found[50, 50], [0.5, 1.0, 0.25], rtol=2 * HALF)


def test_a_texture_gives_light(tmp_path):
    with weightless() as app:
        material = textured(app, picture(tmp_path / "t.png", np.full((2, 2, 3), 51)), into="emissiveColor", **RAW)
        bind(quad(app), material)
        np.testing.assert_allclose(seen(app)[50, 50], 0.2, rtol=2 * HALF)


def test_where_the_mask_is_clear_what_lies_behind_shows(tmp_path):
    """Alpha is 0 on the left and 255 on the right; the wall 1 m behind is white, the square grey."""
    pixels = np.zeros((2, 2, 4))
    pixels[:, 1, 3] = 255
    with weightless() as app:
        sky(app)
        wall = add_box(app, "/World/Wall", 20.0, ahead(0, 0, 13))
        UsdGeom.Gprim(wall).CreateDisplayColorAttr([(1, 1, 1)])
        material = textured(app, picture(tmp_path / "t.png", pixels), into="opacity", output="a")
        bind(quad(app), material)
        light, depth = seen(app, "distance_to_image_plane")
    assert light[50, 10, 0] == 1.0
    np.testing.assert_allclose(light[50, 90], 0.18, rtol=2 * HALF)
    np.testing.assert_allclose(depth, 2.0, rtol=1e-6)  # masks cut colours, not depth


def test_a_prim_without_opacity_is_looked_through(tmp_path):
    with weightless() as app:
        sky(app)
        UsdGeom.Gprim(add_box(app, "/World/Wall", 20.0, ahead(0, 0, 13))).CreateDisplayColorAttr([(0.5, 0.5, 0.5)])
        for number in range(3):
            UsdGeom.Gprim(quad(app, f"/World/Pane{number}", centre=(0, 0, 2 + number / 10))).CreateDisplayOpacityAttr(
                [0.2]
            )
        assert seen(app)[50, 50].tolist() == [0.5] * 3


def test_a_clear_pane_lets_the_sun_through():
    """The sun shines from behind the camera; pane and board stand side by side before a white wall."""
    with weightless() as app:
        UsdGeom.Gprim(add_box(app, "/World/Wall", 20.0, ahead(0, 0, 13))).CreateDisplayColorAttr([(1, 1, 1)])
        UsdLux.DistantLight.Define(app.stage, "/World/Sun").CreateIntensityAttr(np.pi)
        for name, opacity, left in (("Pane", 0.2, 0.5), ("Board", 0.8, -0.5)):
            mesh = quad(app, f"/World/{name}", st=None, centre=(left, 0, 2.5), scale=(0.5, 1, 1))
            UsdGeom.Gprim(mesh).CreateDisplayOpacityAttr([opacity])
        shadow = seen(app)[50, [30, 70], 0]
    # Behind the pane the wall is lit: 1 / pi x pi; the board is grey.
    assert shadow[1] == pytest.approx(1.0, rel=2 * HALF)
    assert shadow[0] == pytest.approx(0.18, rel=2 * HALF)


@pytest.mark.parametrize(
    ("interpolation", "colors"),
    [
        ("vertex", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]),
        ("faceVarying", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]),
        ("uniform", [(0.25, 0.5, 0.75)]),
    ],
)
def test_display_colours_of_corners_and_faces(interpolation, colors):
    with weightless() as app:
        sky(app)
        color = UsdGeom.Gprim(quad(app)).CreateDisplayColorPrimvar(interpolation)
        color.Set(Vt.Vec3fArray([Gf.Vec3f(*each) for each in colors]))
        found = seen(app)
    corners = np.array(colors * (1 if len(colors) == 4 else 4), float)
    x, y = ACROSS[80], UP[70]  # (0.805, 0.295): in the triangle of the first three corners
    np.testing.assert_allclose(found[70, 80], np.array([1 - x, x - y, y, 0]) @ corners, atol=2 * HALF)


def warned(app, code):
    return [(one.where, one.message) for one in app.warnings if one.code == code]


def test_a_missing_file_is_one_warning_and_the_fallback(tmp_path):
    with weightless() as app:
        sky(app)
        fallback = {"fallback": (TYPES.Float4, Gf.Vec4f(0.5, 0.25, 0, 1))}
        bind(quad(app), textured(app, tmp_path / "gone.png", **fallback))
        np.testing.assert_allclose(seen(app)[50, 50], [0.5, 0.25, 0])
        app.update(steps=3)
        [(where, message)] = warned(app, "texture-not-read")
    assert where == "/World/Look"
    assert message == "gone.png does not exist; its surfaces have one plain colour"


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"no image at all", "t.png is not an image of a kind that is read: PNG, JPEG, BMP, TGA, TIFF, WEBP"),
        (b"\x89PNG\r\n\x1a\n" + b"\0" * 50, "t.png"),
    ],
)
def test_a_file_that_is_no_image_is_one_warning(tmp_path, content, said):
    (tmp_path / "t.png").write_bytes(content)
    with weightless() as app:
        sky(app)
        bind(quad(app), textured(app, tmp_path / "t.png"))
        seen(app)
        [(_, message)] = warned(app, "texture-not-read")
    assert message.startswith(said)


def test_images_of_more_pixels_than_the_limit_are_not_read(tmp_path):
    """Together: 6 of one and 4 of the other."""
    first, second = picture(tmp_path / "a.png", np.zeros((2, 3, 3))), picture(tmp_path / "b.png", np.zeros((2, 2, 3)))
    with raised({"camera.texels": 9}), weightless() as app:
        sky(app)
        bind(quad(app), textured(app, first))
        bind(quad(app, "/World/Second"), textured(app, second, path="/World/Other"))
        seen(app)
        [(where, message)] = warned(app, "texture-not-read")
    assert where == "/World/Other"
    assert "--limit camera.texels=N" in message


def test_a_shape_without_coordinates_shows_one_pixel_and_says_so(tmp_path):
    with weightless() as app:
        sky(app)
        image = picture(tmp_path / "t.png", [[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [0, 0, 255]]])
        bind(
            add_box(app, "/World/Box", 2.0, ahead(0, 0, 3)),
            textured(app, image, **RAW, wrapS=(TYPES.Token, "clamp"), wrapT=(TYPES.Token, "clamp")),
        )
        found = seen(app)
        assert [where for where, _ in warned(app, "texture-without-st")] == ["/World/Box"]
    assert found[50, 50].tolist() == [0, 0, 1]  # the pixel below on the left


def test_no_texture_is_read_for_depth(tmp_path, monkeypatch):
    monkeypatch.setattr(ImageFiles, "read", lambda *rest: pytest.fail("read"))
    with weightless() as app:
        bind(quad(app), textured(app, picture(tmp_path / "t.png", np.zeros((2, 2, 3)))))
        [depth] = look(app, add_camera(app, size=SIZE), "distance_to_image_plane")
        assert depth[50, 50] == pytest.approx(2.0, rel=1e-6)


SCENE = """#usda 1.0
(
 metersPerUnit = 1
 upAxis = "Z"
)
def Mesh "Quad" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
 point3f[] points = [(-1, -1, -2), (1, -1, -2), (1, 1, -2), (-1, 1, -2)]
 int[] faceVertexCounts = [4]
 int[] faceVertexIndices = [0, 1, 2, 3]
 rel material:binding = </Look>
}}
def DomeLight "Sky" {{}}
def Material "Look" {{
 token outputs:surface.connect = </Look/Surface.outputs:surface>
 def Shader "Surface" {{
  uniform token info:id = "UsdPreviewSurface"
  color3f inputs:diffuseColor.connect = </Look/Texture.outputs:rgb>
  token outputs:surface
 }}
 def Shader "Texture" {{
  uniform token info:id = "UsdUVTexture"
  asset inputs:file = @{}@
  float3 outputs:rgb
 }}
}}
"""


@pytest.mark.parametrize(
    ("name", "allow", "said"),
    [
        ("./t.png", False, ""),
        ("../secret.png", False, "secret.png lies outside the scene's folders; allow its folder with --allow DIR"),
        ("./link.png", False, "link.png lies outside the scene's folders; allow its folder with --allow DIR"),
        ("../gone.png", False, "gone.png lies outside the scene's folders; allow its folder with --allow DIR"),
        ("../secret.png", True, ""),
    ],
)
def test_textures_are_read_from_the_scenes_folder_and_allowed_ones_only(tmp_path, name, allow, said):
    """What lies outside is refused whether or not it exists."""
    folder = tmp_path / "scene"
    folder.mkdir()
    for file in (folder / "t.png", tmp_path / "secret.png"):
        picture(file, np.full((2, 2, 3), 255))
    (folder / "link.png").symlink_to(tmp_path / "secret.png")
    (folder / "s.usda").write_text(SCENE.format(name))
    (folder / "g.yaml").write_text("tickgraph: 1\nscene: {usd: s.usda}\n")
    with App.from_file(folder / "g.yaml", allow=[tmp_path] if allow else []) as app:
        found = seen(app)[50, 50, 0]
        messages = [message for _, message in warned(app, "texture-not-read")]
    assert messages == ([f"{said}; its surfaces have one plain colour"] if said else [])
    assert found == pytest.approx(0.18 if said else 1.0, rel=2 * HALF)


def test_a_texture_in_a_package_is_read(tmp_path):
    picture(tmp_path / "t.png", np.full((2, 2, 3), 255))
    (tmp_path / "s.usda").write_text(SCENE.format("./t.png"))
    assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "s.usda"), str(tmp_path / "s.usdz"))
    (tmp_path / "t.png").unlink()
    with App(tmp_path / "s.usdz") as app:
        assert seen(app)[50, 50].tolist() == [1.0] * 3
        assert warned(app, "texture-not-read") == []
