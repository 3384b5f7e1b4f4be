"""`camera.backend=gl`: OpenGL draws what rays find; what it cannot draw is cast; without it a run is refused."""

import os
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade

from graph.base.errors import UserError
from graph.base.extras import install_command
from graph.sim import App
from sensors.replicator import get_annotator
from tests.support.camera_worlds import FX, add_camera, ahead, look
from tests.support.lidar_worlds import add_box, weightless
from wings.opengl import require

LUX = 5000.0


def missing():
    try:
        require()
    except UserError as error:
        return str(error)
    return ""


needs_opengl = pytest.mark.skipif(bool(missing()), reason=missing())


@pytest.fixture(params=[pytest.param("gl", marks=needs_opengl), "rays"])
def app(request):
    with App(fidelity={"camera.backend": request.param}) as app:
        yield app


@pytest.fixture
def gl():
    with App(fidelity={"camera.backend": "gl"}) as app:
        yield app


def cube(app, name, place, size=1.0, color=(0.18, 0.18, 0.18)):
    found = UsdGeom.Cube.Define(app.stage, f"/World/{name}")
    found.GetSizeAttr().Set(size)
    UsdGeom.XformCommonAPI(found).SetTranslate(Gf.Vec3d(*ahead(*place)))
    found.CreateDisplayColorAttr([Gf.Vec3f(*color)])
    return found


def sun(app, lux=LUX, rotate=(0, 0, 0)):
    """It shines along the camera's view unless it is turned."""
    light = UsdLux.DistantLight.Define(app.stage, "/World/Sun")
    light.CreateIntensityAttr(lux)
    UsdGeom.XformCommonAPI(light).SetRotate(Gf.Vec3f(*rotate))


@needs_opengl
def test_depth_and_boxes_are_those_of_the_closed_form(app):
    """A cube of 1 m at z 5: its front at 4.5 m covers columns 264 to 375, rows 184 to 295 (55.6 px each way)."""
    cube(app, "A", (0, 0, 5))
    plane, away = look(app, add_camera(app), "distance_to_image_plane", "distance_to_camera")
    rows, columns = np.nonzero(np.isfinite(plane))
    assert (columns.min(), rows.min(), columns.max(), rows.max()) == (264, 184, 375, 295)
    assert plane[np.isfinite(plane)] == pytest.approx(4.5, rel=1e-5)
    x, y = (264.5 - 320) / FX, (184.5 - 240) / FX
    assert away[184, 264] == pytest.approx(4.5 * np.sqrt(1 + x * x + y * y), rel=1e-5)


@needs_opengl
@pytest.mark.parametrize("distance", [0.0, 1e6])
def test_segmentations_and_points_agree_with_rays_anywhere(distance):
    """At 1000 km a float32 is 0.06 m wide: everything is drawn about the camera."""
    found = []
    for backend in ("gl", "rays"):
        with App(fidelity={"camera.backend": backend}) as app:
            product = add_camera(app)
            for name, place, size in (("A", (0, 0, 5), 1.0), ("B", (0.5, 0, 7), 1.0), ("C", (-1, 0.5, 4), 0.5)):
                x, y, z = place
                cube(app, name, (x + distance, y, z), size)
            camera = UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Camera"))
            camera.SetTranslate(Gf.Vec3d(distance, 0, 0))
            found.append(look(app, product, "instance_id_segmentation", "pointcloud", "distance_to_image_plane"))
    (drawn, _, depth), (cast, _, true) = found
    assert drawn["info"]["idToLabels"] == cast["info"]["idToLabels"]
    assert np.count_nonzero(drawn["data"] != cast["data"]) < 20  # pixels whose middle an edge touches
    same = np.isfinite(depth) & np.isfinite(true) & (drawn["data"] == cast["data"])
    assert depth[same] == pytest.approx(true[same], rel=2e-5)


@needs_opengl
def test_what_moves_is_drawn_where_it_is_and_has_motion():
    """1.2 m/s is 0.02 m an update of 1/60 s; 500 px x 0.02 / 4.5 to the right: previous less present is negative."""
    with weightless(camera_backend="gl") as app:
        add_box(app, "/World/Body", 1.0, ahead(0, 0, 5), velocity=(1.2, 0, 0))
        motion = get_annotator("motion_vectors", app=app).attach(add_camera(app))
        app.play()
        app.update(2)
        assert motion.get_data()[240, 320, :2] == pytest.approx([-FX * 0.02 / 4.5, 0], abs=1e-3)


@needs_opengl
def test_colours_follow_the_formula_in_steps_of_a_255th_of_linear_light(app):
    """5000 lux on 0.18: 5000 x 0.18 / pi x 8e-4 = 0.229; within half a step of 1 / 255 sRGB makes it 132 to 133."""
    cube(app, "A", (0, 0, 5))
    sun(app)
    [picture] = look(app, add_camera(app), "rgb")
    assert set(np.unique(picture[184:296, 264:376, :3])) <= {131, 132, 133}
    assert not picture[0, 0, :3].any()


@needs_opengl
def test_a_surface_is_lit_from_either_side_and_throws_a_shadow(app):
    """A card 1 m wide at 4 m, seen from behind its normal; the sun, 45 degrees from the left, puts its shadow on a wall
    at 6 m from x = 1.5 to 2.5 m: columns 445 to 528, of which it does not hide any (its own end at 382).
    """
    cube(app, "Wall", (0, 0, 11), 10.0, (0.5, 0.5, 0.5))
    card = UsdGeom.Mesh.Define(app.stage, "/World/Card")
    card.GetPointsAttr().Set(
        [Gf.Vec3f(*ahead(x, y, 4)) for x, y in ((-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5))]
    )
    card.GetFaceVertexCountsAttr().Set([4])
    card.GetFaceVertexIndicesAttr().Set([0, 1, 2, 3])
    card.CreateDisplayColorAttr([Gf.Vec3f(0.5, 0.5, 0.5)])
    sun(app, 3000, (0, -45, 0))
    [picture] = look(app, add_camera(app), "rgb")
    row = picture[240, :, 0].astype(int)
    lit = row[600]
    assert lit > 100
    assert row[320] == pytest.approx(lit, abs=1)  # the card, as bright as the wall: it faces the sun as the wall does
    assert row[460:515].max() == 0
    assert row[425] == row[545] == lit


@needs_opengl
def test_textures_are_the_right_way_up_and_repeat(app, tmp_path):
    """A square that fills columns 195 to 445 with an image of four pixels, twice over: their middles, at 1/8, 3/8 ...

    of the square, show them alone.
    """
    colors = np.array([[(255, 0, 0), (0, 255, 0)], [(0, 0, 255), (255, 255, 255)]], np.uint8)
    Image.fromarray(colors).save(tmp_path / "four.png")
    square = UsdGeom.Mesh.Define(app.stage, "/World/Square")
    corners = ((-1, 1), (1, 1), (1, -1), (-1, -1))  # in the optical frame: from below on the left, round
    square.GetPointsAttr().Set([Gf.Vec3f(*ahead(x, y, 4)) for x, y in corners])
    square.GetFaceVertexCountsAttr().Set([4])
    square.GetFaceVertexIndicesAttr().Set([0, 1, 2, 3])
    st = UsdGeom.PrimvarsAPI(square).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex")
    st.Set([(0, 0), (2, 0), (2, 2), (0, 2)])
    UsdShade.MaterialBindingAPI.Apply(square.GetPrim()).Bind(textured(app.stage, tmp_path / "four.png"))
    UsdLux.DomeLight.Define(app.stage, "/World/Sky").CreateIntensityAttr(1250.0)  # white shows white
    [picture] = look(app, add_camera(app), "rgb")
    middles = [195 + round(250 * (2 * n + 1) / 8) for n in range(4)]
    found = picture[np.ix_([row - 80 for row in middles], middles)][..., :3].astype(int)
    assert (
        np.abs(found - np.tile(colors, (2, 2, 1))).max() <= 35
    )  # half a pixel from a middle is 1 / 62 of the next: 34 in sRGB


def textured(stage, file):
    material = UsdShade.Material.Define(stage, "/World/Look")
    surface, image, reader = (UsdShade.Shader.Define(stage, f"/World/Look/{name}") for name in ("S", "I", "R"))
    for shader, kind in ((surface, "UsdPreviewSurface"), (image, "UsdUVTexture"), (reader, "UsdPrimvarReader_float2")):
        shader.CreateIdAttr(kind)
    kinds = Sdf.ValueTypeNames
    reader.CreateInput("varname", kinds.String).Set("st")
    image.CreateInput("file", kinds.Asset).Set(str(file))
    for name in ("wrapS", "wrapT"):
        image.CreateInput(name, kinds.Token).Set("repeat")
    image.CreateInput("st", kinds.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
    surface.CreateInput("diffuseColor", kinds.Color3f).ConnectToSource(image.ConnectableAPI(), "rgb")
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    return material


@needs_opengl
@pytest.mark.parametrize("name", ["normals", "bounding_box_2d_loose", "HdrColor"])
def test_other_channels_are_cast(gl, name):
    cube(gl, "A", (0, 0, 5))
    [found] = look(gl, add_camera(gl), name)
    assert found is not None


@needs_opengl
def test_a_lens_that_bends_lines_is_cast_with_a_warning(gl):
    product = add_camera(gl)
    prim = gl.stage.GetPrimAtPath("/World/Camera")
    prim.AddAppliedSchema("OmniLensDistortionOpenCvFisheyeAPI")
    cube(gl, "A", (0, 0, 5))
    [depth] = look(gl, product, "distance_to_image_plane")
    assert np.isfinite(depth).any()
    [warning] = [one for one in gl.warnings if one.code == "camera-by-rays"]
    assert "bends straight lines" in warning.message


def test_without_opengl_a_run_ends_before_play_with_the_reason_and_the_remedy(tmp_path):
    """In a process of its own, in which no driver is found."""
    file = tmp_path / "g.yaml"
    file.write_text("tickgraph: 1\nfidelity: {camera.backend: gl}\n")
    code = f"from graph.cli.main import main; raise SystemExit(main(['run', {str(file)!r}, '--updates', '1']))"
    given = {"env": {**os.environ, "MUJOCO_GL": "osmesa"}, "capture_output": True, "text": True}
    done = subprocess.run([sys.executable, "-c", code], timeout=120, check=False, **given)
    if done.returncode == 0:
        pytest.skip("OSMesa is installed")
    assert done.returncode == 2
    [line] = done.stderr.strip().splitlines()
    assert "camera.backend" in line
    assert install_command("gl") in line or "Unset the environment variable MUJOCO_GL" in line
