"""A helper on the product of another kind of sensor: an error in a graph file, a warning in a saved scene."""

import pytest
from pxr import Sdf, Usd

from graph.session.open import build_parts
from nodes.fitting_sensors import misfit
from tests.support.without_wing import MISSING_NAMES, needs_wing

NEEDS = {
    "ROS2CameraHelper": "Camera",
    "ROS2CameraInfoHelper": "Camera",
    "UCXCameraHelper": "Camera",
    "HSBCameraHelper": "Camera",
    "ROS2RtxRadarHelper": "OmniRadar",
    "ROS2RtxLidarHelper": "OmniLidar",
}
FILE = """\
tickgraph: 1
scene:
  prims:
    /World/Sensor: {sensor}
graphs:
  /World/G:
    {lenient}
    nodes:
      tick: OnPlaybackTick
      product: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: /World/Sensor{size}}}}}
      helper: {helper}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> helper.execIn
      - product.renderProductPath -> helper.renderProductPath
"""


@pytest.fixture
def opened(tmp_path):
    """A function: the problems and the warnings of opening a file with a sensor and a helper."""

    def open_file(sensor, helper, size="", *, lenient=False):
        file = tmp_path / "a.yaml"
        file.write_text(
            FILE.format(sensor=sensor, helper=helper, size=size, lenient="lenient: true" if lenient else "")
        )
        parts = build_parts(file)
        return [one.message for one in parts.problems], parts.warnings

    return open_file


@pytest.mark.parametrize("helper", [name for name in NEEDS if name not in MISSING_NAMES])
@pytest.mark.parametrize("sensor", ["Camera", "OmniRadar", "OmniLidar"])
def test_a_helper_takes_its_own_kind_only(opened, sensor, helper):
    problems = [one for one in opened(f"{{type: {sensor}}}", helper)[0] if "must be of type" in one]
    wrong = f"/World/Sensor is of type {sensor}; it must be of type {NEEDS[helper]}"
    assert problems == ([] if sensor == NEEDS[helper] else [f"/World/G/helper: nothing would be published: {wrong}"])


def test_in_a_saved_scene_it_is_a_warning_at_the_node(opened):
    problems, warnings = opened("{type: Camera}", "ROS2RtxRadarHelper", lenient=True)
    assert problems == []
    [(where, message)] = [(where, text) for code, where, text in warnings if code == "node-cannot-work"]
    assert where.endswith("a.yaml:11:7")
    assert "/World/Sensor is of type Camera; it must be of type OmniRadar" in message


@pytest.mark.parametrize(("kind", "type_name"), [("lidar", "OmniLidar"), ("radar", "OmniRadar")])
def test_a_camera_that_stood_for_a_lidar_or_radar_is_no_camera(kind, type_name):
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/Old", "Camera")
    prim.CreateAttribute("cameraSensorType", Sdf.ValueTypeNames.Token).Set(kind)
    wrong = "/Old is a Camera that stands for a sensor, as up to Isaac Sim 4 (cameraSensorType); make it an "
    assert {misfit(prim, "/Old", needed) for needed in ("Camera", type_name)} == {wrong + type_name}
    prim.GetAttribute("cameraSensorType").Set("camera")
    assert misfit(prim, "/Old", "Camera") is None


@pytest.mark.parametrize(
    ("size", "name", "wrong"),
    [
        (", height: 0", "height", "an image of 1280 x 0 has no pixels"),
        (
            ", width: 100000, height: 480",
            "width",
            "an image of 100,000 x 480 has 48,000,000 pixels; the limit is",
        ),
    ],
)
def test_the_size_of_a_camera_s_image_is_checked_before_the_run(opened, size, name, wrong):
    (problem,), _ = opened("{type: Camera}", "ROS2CameraHelper", size)
    assert problem.startswith(f"/World/G/product.inputs:{name}: /World/Sensor: {wrong}")
    assert opened("{type: OmniRadar}", "ROS2RtxRadarHelper", size)[0] == []


def test_a_missing_camera_is_reported_as_missing(opened, tmp_path):
    opened("{type: Camera}", "ROS2CameraHelper", ", width: 0")
    file = tmp_path / "a.yaml"
    file.write_text(file.read_text().replace("cameraPrim: /World/Sensor", "cameraPrim: /World/Gone"))
    (problem,) = build_parts(file).problems
    assert problem.message.startswith("/World/G/product.inputs:cameraPrim: there is no prim /World/Gone on the stage")


@needs_wing("physx")
@pytest.mark.parametrize(
    ("node", "name", "needed"),
    [
        ("IsaacReadLightBeam", "lightbeamPrim", "IsaacLightBeamSensor"),
        ("IsaacReadLidarBeams", "lidarPrim", "Lidar"),
        ("isaacsim.sensors.physx.IsaacReadLidarPointCloud", "lidarPrim", "Lidar"),
    ],
)
def test_a_node_that_polls_takes_its_own_kind_only(tmp_path, node, name, needed):
    file = tmp_path / "a.yaml"
    for kind in ("Camera", needed):
        file.write_text(
            f"tickgraph: 1\nscene: {{prims: {{/World/S: {{type: {kind}}}}}}}\n"
            f"graphs: {{/G: {{nodes: {{tick: OnPlaybackTick, read: {{type: {node}, inputs: {{{name}: /World/S}}}}}},"
            " connections: [tick.tick -> read.execIn]}}\n"
        )
        wrong = f"/G/read.inputs:{name}: /World/S is of type Camera; it must be of type {needed}"
        assert [one.message for one in build_parts(file).problems] == ([wrong] if kind == "Camera" else [])
