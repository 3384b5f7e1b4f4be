"""Nodes of rendering pipelines: new frames, their numbers and times, and render variables as data."""

import numpy as np
import pytest

from graph import ComputeError
from sensors.handles import resolve

SCENE = """
tickgraph: 1
scene:
  prims:
    /World/Camera: {type: Camera, attributes: {"omni:sensor:tickRate": %s}, schemas: [OmniSensorAPI]}
    /World/Wall: {type: Cube, size: 2, translate: [0, 0, -5]}
    /World/Sky: {type: DomeLight, attributes: {inputs:intensity: 1250}}
clock: {physics_hz: 60, loop_hz: 60}
graphs:
  /World/Make:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Camera, width: 8, height: 6}}
    connections: [tick.tick -> product.execIn]
"""

PIPELINE = """
  /World/Pipeline:
    pipeline_stage: %s
    nodes:
      frame: omni.syntheticdata.SdOnNewFrame
      dispatch: omni.syntheticdata.SdOnNewRenderProductFrame
      number: omni.syntheticdata.SdFrameIdentifier
      depth: {type: omni.syntheticdata.SdRenderVarPtr, inputs: {renderVar: DistanceToImagePlaneSDbuff}}
      colours: {type: omni.syntheticdata.SdRenderVarToRawArray, inputs: {renderVar: LdrColorSDhost}}
      count: {type: omni.graph.action.Counter}
    connections:
      - /World/Make/product.outputs:renderProductPath -> dispatch.renderProductPath
      - frame.exec -> dispatch.exec
      - frame.renderProductPaths -> dispatch.renderProductPaths
      - frame.renderProductDataPtrs -> dispatch.renderProductDataPtrs
      - dispatch.outputs:exec -> [number.exec, depth.exec, colours.exec]
      - dispatch.renderResults -> [number.renderResults, depth.renderResults, colours.renderResults]
      - depth.exec -> count.execIn
"""


@pytest.fixture
def opened(tmp_path):
    from graph.sim import App

    apps = []

    def open_file(text, updates):
        path = tmp_path / "pipeline.yaml"
        path.write_text(text)
        app = App.from_file(path)
        apps.append(app)
        app.play()
        app.update(updates)
        return app, app.graphs["/World/Pipeline"].nodes

    yield open_file
    for app in apps:
        app.close()


@pytest.mark.parametrize("stage", ["post_render", "on_demand"])
def test_a_pipeline_follows_every_frame_of_its_product(opened, stage):
    """The wall's near side is 4 m ahead. The first frame comes before anything reads it: two have data."""
    _app, nodes = opened(SCENE % 0 + PIPELINE % stage, 3)
    assert nodes["number"].get("outputs:frameNumber") == 2
    assert nodes["number"].get("outputs:type") == "FrameNumber"
    assert (
        nodes["number"].get("outputs:rationalTimeOfSimNumerator"),
        nodes["number"].get("outputs:rationalTimeOfSimDenominator"),
        nodes["frame"].get("outputs:referenceTimeNumerator"),
        nodes["number"].get("outputs:externalTimeOfSimNs"),
    ) == (1, 20, 1, 50_000_000)
    depth = resolve(nodes["depth"].get("outputs:dataPtr"))
    assert depth == pytest.approx(np.full((6, 8), 4.0), rel=1e-6)
    assert [nodes["depth"].get(f"outputs:{name}") for name in ("width", "height", "bufferSize", "format")] == [
        8,
        6,
        192,
        33,
    ]
    data = nodes["colours"].get("outputs:data").reshape(6, 8, 4)
    assert data[3, 4].tolist() == [118, 118, 118, 255]  # grey 0.18 under a sky of 1250 nit, 8e-4 of which is 1
    assert nodes["colours"].get("outputs:format") == 11
    assert nodes["count"].get("outputs:count") == 2


def test_in_a_graph_of_the_simulation_it_follows_one_update_later(opened):
    _app, nodes = opened(SCENE % 0 + PIPELINE % "simulation", 3)
    assert nodes["number"].get("outputs:frameNumber") == 1


def test_a_camera_of_a_rate_has_frames_of_a_constant_time(opened):
    """20 Hz in a loop of 60 Hz: of ten updates the 3rd, 6th and 9th render; the third frame is at 3 / 20 s."""
    _app, nodes = opened(SCENE % 20 + PIPELINE % "post_render", 10)
    number = nodes["number"]
    assert number.get("outputs:type") == "ConstantFramerateFrameNumber"
    assert [number.get(f"outputs:duration{part}") for part in ("Numerator", "Denominator")] == [1, 20]
    assert [number.get(f"outputs:rationalTimeOfSim{part}") for part in ("Numerator", "Denominator")] == [3, 20]


def test_frames_of_other_products_do_not_pass(opened):
    _app, nodes = opened(
        (SCENE % 0 + PIPELINE % "post_render").replace(
            "      - /World/Make/product.outputs:renderProductPath -> dispatch.renderProductPath\n", ""
        ),
        3,
    )
    assert nodes["number"].get("outputs:frameNumber") == -1


def test_an_unknown_render_variable_is_told_with_the_known_ones(opened):
    with pytest.raises(ComputeError, match=r'renderVar is "DistanceToImagePlainSD".*did you mean'):
        opened(
            (SCENE % 0 + PIPELINE % "post_render").replace("DistanceToImagePlaneSDbuff", "DistanceToImagePlainSD"), 3
        )


def test_copies_of_render_variables_are_named_and_passed_on():
    from graph.testing import run_node

    for kind, name in (
        ("SdPostRenderVarToHost", "LdrColorSDhost"),
        ("SdPostRenderVarTextureToBuffer", "LdrColorSDbuffer"),
    ):
        trace = run_node(f"omni.syntheticdata.{kind}", inputs={"renderVar": "LdrColorSD"}, pulses={"exec": [0]})
        assert trace.value("renderVar") == name
        assert trace.fired("exec") == [0]
