"""Viewports, cameras of products, products that a scene holds."""

import pytest

from graph import ComputeError
from graph.testing import run_node
from tests.support.without_wing import needs_wing

ROOT = "/Render/OmniverseKit/HydraTextures"


def once(app, node, updates=1, **inputs):
    return run_node(node, inputs=inputs, pulses={"execIn": range(updates)}, updates=updates, app=app)


@pytest.mark.parametrize(
    ("inputs", "name"),
    [({}, "Viewport"), ({"viewportId": 3}, "3"), ({"name": "Left eye", "viewportId": 3}, "Left eye")],
)
def test_a_viewport_has_the_name_given_else_its_number(world, inputs, name):
    trace = once(world(), "IsaacCreateViewport", 2, **inputs)
    assert trace.values("viewport") == [name, name]
    assert trace.fired("execOut") == [0, 1]


def test_a_viewport_has_a_render_product_that_renders_nothing_yet(world):
    app = world()
    once(app, "IsaacCreateViewport", name="Left eye")
    trace = once(app, "IsaacGetViewportRenderProduct", 2, viewport="Left eye")
    assert trace.values("renderProductPath") == [f"{ROOT}/Left_eye"] * 2
    product = app.rendering.products[f"{ROOT}/Left_eye"]
    assert product.resolution == (1280, 720)
    app.update(5)
    assert product.frames == 0


def test_names_that_give_one_path_get_one_each(world):
    app = world()
    for name in ("a b", "a_b"):
        once(app, "IsaacCreateViewport", name=name)
    paths = [once(app, "IsaacGetViewportRenderProduct", viewport=n).value("renderProductPath") for n in ("a b", "a_b")]
    assert paths == [f"{ROOT}/a_b", f"{ROOT}/a_b_01"]


def test_a_viewport_there_is_not_warns_and_nothing_follows(world):
    app = world()
    for node in ("IsaacGetViewportRenderProduct", "IsaacSetViewportResolution"):
        trace = once(app, node, viewport="Gone")
        assert trace.fired("execOut") == []
        assert [one.code for one in trace.warnings] == ["viewport-missing"]


def test_the_default_viewport_is_always_there_and_its_size_can_be_set(world):
    app = world()
    once(app, "IsaacSetViewportResolution", width=640, height=480)
    path = once(app, "IsaacGetViewportRenderProduct").value("renderProductPath")
    assert app.rendering.products[path].resolution == (640, 480)
    assert tuple(app.stage.GetPrimAtPath(path).GetAttribute("resolution").Get()) == (640, 480)


def test_a_size_of_0_is_refused(world):
    with pytest.raises(ComputeError, match="0 x 720 pixels are not a size"):
        once(world(), "IsaacSetViewportResolution", width=0)


def test_a_sensor_set_on_a_viewport_renders_and_stays_through_a_new_size(lidar, world):
    camera = lidar()
    app = world(physics_hz=60, loop_hz=60)
    path = once(app, "IsaacGetViewportRenderProduct").value("renderProductPath")
    trace = once(app, "IsaacSetCameraOnRenderProduct", 2, renderProductPath=path, cameraPrim=[camera])
    assert trace.fired("execOut") == [0, 1]
    once(app, "IsaacSetViewportResolution", width=64, height=64)
    product = app.rendering.products[path]
    assert (product.camera_path, product.resolution) == (camera, (64, 64))
    app.update(60)
    assert product.frames > 0


@pytest.mark.parametrize("published", [False, True])
@pytest.mark.parametrize(
    ("node", "inputs"),
    [
        ("IsaacSetViewportResolution", {"width": 64, "height": 64}),
        ("IsaacSetCameraOnRenderProduct", {"renderProductPath": f"{ROOT}/Viewport", "cameraPrim": ["/World/Eye"]}),
        pytest.param(
            "omni.graph.ui_nodes.SetActiveViewportCamera",
            {"viewport": "Viewport", "primPath": "/World/Eye"},
            marks=needs_wing("ui"),
        ),
    ],
)
def test_what_publishes_a_product_that_is_replaced_is_warned_of(lidar, stage, world, node, inputs, published):
    camera = lidar()
    stage.DefinePrim("/World/Eye", "Camera")
    app = world()
    path = once(app, "IsaacGetViewportRenderProduct").value("renderProductPath")
    once(app, "IsaacSetCameraOnRenderProduct", renderProductPath=path, cameraPrim=[camera])
    app.rendering.products[path].writers += [print] * published
    once(app, node, **inputs)
    told = [(one.code, one.where) for one in app.warnings]
    assert told.count(("render-product-replaced", path)) == published


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"cameraPrim": []}, "input cameraPrim names 0 prims"),
        ({"renderProductPath": "/Render/Gone"}, "there is no render product /Render/Gone"),
        ({"cameraPrim": ["/World/Ahead"]}, "a Cube is not a sensor"),
    ],
)
def test_a_camera_that_cannot_be_set_is_reported(lidar, world, inputs, message):
    camera = lidar()
    app = world()
    path = once(app, "IsaacGetViewportRenderProduct").value("renderProductPath")
    with pytest.raises(ComputeError, match=message):
        once(app, "IsaacSetCameraOnRenderProduct", **{"renderProductPath": path, "cameraPrim": [camera], **inputs})


@pytest.fixture
def product_prim(stage, lidar):
    """/Render/Mine: a RenderProduct prim of the lidar, 320 x 240 pixels."""
    from pxr import Gf, UsdRender

    prim = UsdRender.Product.Define(stage, "/Render/Mine")
    prim.CreateCameraRel().SetTargets([lidar()])
    prim.CreateResolutionAttr().Set(Gf.Vec2i(320, 240))
    return prim


def test_a_product_of_the_scene_renders_once_attached(product_prim, world):
    app = world(physics_hz=60, loop_hz=60)
    inputs = {"renderProductPrim": ["/Render/Mine"], "renderVars": ["LdrColor", "GenericModelOutput", "LdrColor"]}
    trace = once(app, "IsaacAttachHydraTexture", 2, **inputs)
    assert trace.value("renderProductPath") == "/Render/Mine"
    assert trace.fired("execOut") == [0, 1]
    product = app.rendering.products["/Render/Mine"]
    assert (product.camera_path, product.resolution) == ("/World/Lidar", (320, 240))
    targets = [str(path) for path in product_prim.GetOrderedVarsRel().GetTargets()]
    assert targets == ["/Render/Vars/LdrColor", "/Render/Vars/GenericModelOutput"]
    app.update(60)
    assert product.frames > 0


def test_a_disabled_attachment_stops_the_product(product_prim, world):
    app = world()
    inputs = {"renderProductPrim": ["/Render/Mine"], "enabled": lambda update: update == 0}
    trace = once(app, "IsaacAttachHydraTexture", 2, **inputs)
    assert trace.fired("execOut") == [0]
    assert not app.rendering.products["/Render/Mine"].enabled


@pytest.mark.parametrize(
    ("prims", "message"),
    [
        ([], "renderProductPrim names 0 prims"),
        (["/World/Lidar"], "/World/Lidar is not a RenderProduct prim"),
    ],
)
def test_what_is_not_a_product_is_reported(product_prim, world, prims, message):
    with pytest.raises(ComputeError, match=message):
        once(world(), "IsaacAttachHydraTexture", renderProductPrim=prims)


@pytest.fixture
def camera(stage):
    """/World/Eye, a camera of 24 mm on a film of 36 x 15.2908 mm, and a product of it, 400 x 200 pixels."""
    from pxr import Gf, UsdGeom, UsdRender

    eye = UsdGeom.Camera.Define(stage, "/World/Eye")
    eye.GetFocalLengthAttr().Set(24.0)
    eye.GetHorizontalApertureAttr().Set(36.0)
    eye.GetHorizontalApertureOffsetAttr().Set(0.5)
    prim = UsdRender.Product.Define(stage, "/Render/Eye")
    prim.CreateCameraRel().SetTargets(["/World/Eye"])
    prim.CreateResolutionAttr().Set(Gf.Vec2i(400, 200))
    return eye.GetPrim()


def test_the_camera_of_a_product_is_read(camera, world):
    trace = run_node("IsaacReadCameraInfo", inputs={"renderProductPath": "/Render/Eye"}, app=world())
    assert [trace.value(name) for name in ("width", "height")] == [400, 200]
    names = ("focalLength", "horizontalAperture", "verticalAperture", "horizontalOffset", "verticalOffset")
    assert [trace.value(name) for name in names] == [24, 36, 18, 0.5, 0]
    assert trace.value("projectionType") == "pinhole"
    assert trace.value("cameraFisheyeParams").tolist() == [0.0] * 19
    assert trace.value("physicalDistortionModel") == ""


def test_a_lens_is_read_in_the_order_of_the_original(camera, world):
    from pxr import Sdf

    def author(name, kind, value):
        camera.CreateAttribute(name, getattr(Sdf.ValueTypeNames, kind)).Set(value)

    author("cameraProjectionType", "Token", "fisheyePolynomial")
    author("fthetaWidth", "Float", 1936.0)
    author("fthetaPolyB", "Float", 0.25)
    author("fisheyeFrontFaceResolutionScale", "Float", 1.5)
    author("physicalDistortionModel", "String", "plumb_bob")
    author("physicalDistortionCoefficients", "FloatArray", [0.5, 0.25])
    trace = run_node("IsaacReadCameraInfo", inputs={"renderProductPath": "/Render/Eye"}, app=world())
    lens = trace.value("cameraFisheyeParams").tolist()
    assert {index: value for index, value in enumerate(lens) if value} == {0: 1936.0, 6: 0.25, 18: 1.5}
    assert trace.value("projectionType") == "fisheyePolynomial"
    assert trace.value("physicalDistortionModel") == "plumb_bob"
    assert trace.value("physicalDistortionCoefficients").tolist() == [0.5, 0.25]


def test_a_product_of_a_lidar_has_no_camera_info(product_prim, world):
    with pytest.raises(ComputeError, match="/Render/Mine renders /World/Lidar, which is not a Camera prim"):
        run_node("IsaacReadCameraInfo", inputs={"renderProductPath": "/Render/Mine"}, app=world())
