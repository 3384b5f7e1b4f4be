"""Viewports that nodes and scripts share, gates that thin out what helpers publish, the former class LidarRtx."""

import re

import pytest

CAMERA = """from isaacsim import SimulationApp
app = SimulationApp({"headless": True})
import omni.graph.core as og, omni.timeline, omni.usd, usdrt.Sdf
import omni.syntheticdata
import omni.syntheticdata._syntheticdata as sd
from omni.kit.viewport.utility import get_active_viewport, get_viewport_from_window_name
stage = omni.usd.get_context().get_stage()
stage.DefinePrim("/Camera", "Camera")
keys = og.Controller.Keys
on_demand = og.GraphPipelineStage.GRAPH_PIPELINE_STAGE_ONDEMAND
graph, _, _, _ = og.Controller.edit(
    {"graph_path": "/G", "evaluator_name": "push", "pipeline_stage": on_demand},
    {
        keys.CREATE_NODES: [
            ("tick", "omni.graph.action.OnTick"),
            ("view", "isaacsim.core.nodes.IsaacCreateViewport"),
            ("product", "isaacsim.core.nodes.IsaacGetViewportRenderProduct"),
            ("size", "isaacsim.core.nodes.IsaacSetViewportResolution"),
            ("camera", "isaacsim.core.nodes.IsaacSetCameraOnRenderProduct"),
            ("depth", "isaacsim.ros2.bridge.ROS2CameraHelper"),
            ("info", "isaacsim.ros2.bridge.ROS2CameraInfoHelper"),
        ],
        keys.CONNECT: [
            ("tick.outputs:tick", "view.inputs:execIn"),
            ("view.outputs:execOut", "size.inputs:execIn"),
            ("view.outputs:viewport", "size.inputs:viewport"),
            ("size.outputs:execOut", "product.inputs:execIn"),
            ("view.outputs:viewport", "product.inputs:viewport"),
            ("product.outputs:execOut", "camera.inputs:execIn"),
            ("product.outputs:renderProductPath", "camera.inputs:renderProductPath"),
            ("camera.outputs:execOut", "depth.inputs:execIn"),
            ("camera.outputs:execOut", "info.inputs:execIn"),
            ("product.outputs:renderProductPath", "depth.inputs:renderProductPath"),
            ("product.outputs:renderProductPath", "info.inputs:renderProductPath"),
        ],
        keys.SET_VALUES: [
            ("view.inputs:name", VIEWPORT),
            ("size.inputs:width", 8),
            ("size.inputs:height", 6),
            ("camera.inputs:cameraPrim", [usdrt.Sdf.Path("/Camera")]),
            ("depth.inputs:type", "depth"),
            ("depth.inputs:topicName", "depth"),
            ("info.inputs:topicName", "info"),
        ],
    },
)
og.Controller.evaluate_sync(graph)
timeline = omni.timeline.get_timeline_interface()
"""


def test_a_viewport_without_a_camera_of_its_own_shows_the_perspective(run_script):
    code, out, err = run_script(
        """from isaacsim import SimulationApp
app = SimulationApp({"headless": True})
import omni.graph.core as og, omni.timeline, omni.usd
from pxr import UsdRender
keys = og.Controller.Keys
og.Controller.edit(
    {"graph_path": "/G", "evaluator_name": "execution"},
    {
        keys.CREATE_NODES: [
            ("tick", "omni.graph.action.OnPlaybackTick"),
            ("product", "isaacsim.core.nodes.IsaacGetViewportRenderProduct"),
        ],
        keys.CONNECT: [("tick.outputs:tick", "product.inputs:execIn")],
    },
)
omni.timeline.get_timeline_interface().play()
app.update()
stage = omni.usd.get_context().get_stage()
product = UsdRender.Product(stage.GetPrimAtPath(og.Controller.get("/G/product.outputs:renderProductPath")))
print(product.GetCameraRel().GetTargets(), product.GetResolutionAttr().Get())
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == ["[Sdf.Path('/OmniverseKit_Persp')] (1280, 720)"]


@pytest.mark.parametrize("name", ["", "Second"])
def test_a_viewport_of_nodes_is_the_one_that_a_script_finds_by_its_name(name, run_script):
    code, out, err = run_script(
        CAMERA.replace("VIEWPORT", repr(name))
        + f"""
found = get_viewport_from_window_name({name or "Viewport"!r})
print(found.render_product_path == og.Controller.get("/G/product.outputs:renderProductPath"))
print(found.camera_path, found.resolution, (found is get_active_viewport()) == {not name})
found.set_active_camera("/OmniverseKit_Top")
found.resolution = (4, 2)
from pxr import UsdRender
product = UsdRender.Product(stage.GetPrimAtPath(found.render_product_path))
print(product.GetCameraRel().GetTargets(), product.GetResolutionAttr().Get())
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == ["True", "/Camera (8, 6) True", "[Sdf.Path('/OmniverseKit_Top')] (4, 2)"]


def test_the_step_of_a_gate_thins_out_what_is_published_behind_it(run_script):
    """Ten frames after the gate is set: every second depth image; every camera info."""
    code, _, err = run_script(
        CAMERA.replace("VIEWPORT", '""')
        + """
data = omni.syntheticdata.SyntheticData
rendervar = data.convert_sensor_type_to_rendervar(sd.SensorType.DistanceToImagePlane.name)
gate = data._get_node_path(rendervar + "IsaacSimulationGate", get_active_viewport().get_render_product_path())
og.Controller.attribute(gate + ".inputs:step").set(2)
color = data._get_node_path("LdrColorIsaacSimulationGate", get_active_viewport().get_render_product_path())
og.Controller.attribute(color + ".inputs:step").set(3)
timeline.play()
for _ in range(11):  # physics does not step before the first frame
    app.update()
timeline.stop()
app.update()
app.close()
"""
    )
    assert code == 0, err
    depth, info = (int(re.search(rf"/{name} +(\d+) ", err)[1]) for name in ("depth", "info"))
    assert info >= 10
    assert depth == info // 2
    assert "gate-without-writer" in err  # nothing publishes colours
    assert "product-not-made" not in err  # the stop empties the output


def test_the_former_lidar_gives_what_its_flat_scan_says(run_script):
    """A wall 2 m from the lidar, in front: the scan of 3600 rays a turn has a ray each 0.1 degrees."""
    code, out, err = run_script("""
from isaacsim import SimulationApp
app = SimulationApp({"headless": True})
import numpy as np
from isaacsim.core.api import World
from isaacsim.core.api.objects import FixedCuboid
from isaacsim.sensors.rtx import LidarRtx
world = World(stage_units_in_meters=1.0)
world.scene.add(FixedCuboid(prim_path="/Wall", name="wall", position=np.array([2.5, 0, 0]), size=1.0))
lidar = world.scene.add(LidarRtx(prim_path="/Lidar", name="lidar", config_file_name="Example_Rotary_2D"))
world.reset()
print(lidar.get_horizontal_resolution(), lidar.get_num_cols(), lidar.get_depth_range(), lidar.get_rotation_frequency())
lidar.attach_annotator("IsaacComputeRTXLidarFlatScan")
for _ in range(8):
    world.step()
frame = lidar.get_current_frame()
depth = frame["linear_depth_data"]
print(round(float(depth[depth > 0].min()), 4), depth.shape, frame["rendering_frame"])
print(lidar.get_num_rows(), lidar.get_num_cols(), round(lidar.get_horizontal_resolution(), 4))
print(lidar.get_rotation_frequency(), lidar.is_paused())
world.pause()
print(lidar.is_paused())
print(lidar.get_horizontal_fov(), round(frame["horizontal_resolution"], 4), len(lidar.get_azimuth_range()))
app.close()
""")
    assert code == 0, err
    assert "isaac-inert" not in err
    assert out.splitlines() == [
        "None None None None",
        "2.0 (3600,) (2, 15)",
        "1 3600 0.1",
        "10.0 False",
        "True",
        "360.0 0.1 2",
    ]
