"""Units, clocks with execution, copies."""

import pytest

from graph import ComputeError
from graph.testing import run_node

SCALE = "OgnIsaacScaleToFromStageUnit"
TO_METERS = "Convert to meters"


@pytest.fixture
def centimetres(stage, world):
    from pxr import UsdGeom

    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    return world()


@pytest.mark.parametrize(
    ("kind", "value", "stage_units", "metres"),
    [
        ("double", 2.5, 250.0, 0.025),
        ("float", 0.5, 50.0, 0.005),
        ("int", 3, 300.0, 0.03),
        ("double[3]", [1.0, 2.0, 3.0], [100.0, 200.0, 300.0], [0.01, 0.02, 0.03]),
        ("vectord[3]", [1.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.01, 0.0, 0.0]),
        ("int[]", [1, 2], [100.0, 200.0], [0.01, 0.02]),
    ],
)
def test_lengths_go_to_stage_units_and_back_to_metres(centimetres, kind, value, stage_units, metres):
    inputs = {"value": {"type": kind, "value": value}}
    assert run_node(SCALE, inputs=inputs, app=centimetres).value("result") == pytest.approx(stage_units)
    inputs["conversion"] = TO_METERS
    assert run_node(SCALE, inputs=inputs, app=centimetres).value("result") == pytest.approx(metres)


@pytest.mark.parametrize(("kind", "result"), [("int", "double"), ("int[3]", "double[3]"), ("float", "float")])
def test_integers_come_out_as_doubles(centimetres, kind, result):
    trace = run_node(SCALE, inputs={"value": {"type": kind, "value": [1, 2, 3] if "[" in kind else 1}}, app=centimetres)
    assert trace.node.types["outputs:result"].name == result


def test_a_conversion_there_is_not_is_refused(centimetres):
    inputs = {"value": {"type": "double", "value": 1.0}, "conversion": lambda update: "Convert to feet"}
    with pytest.raises(ComputeError, match='conversion is "Convert to feet"; it is "Convert to stage units" or'):
        run_node(SCALE, inputs={**inputs}, connect={"conversion": "token"}, app=centimetres)


def test_the_annotator_clocks_read_now_and_the_time_of_a_frame(world):
    app = world(physics_hz=120, loop_hz=60)
    inputs = {
        "referenceTimeNumerator": lambda update: 0 if update < 3 else 2,
        "referenceTimeDenominator": lambda update: 0 if update < 3 else 60,
    }
    pulses = {"execIn": range(4)}
    trace = run_node("IsaacReadSimulationTimeAnnotator", inputs=inputs, pulses=pulses, updates=4, app=app)
    assert trace.values("simulationTime") == pytest.approx([1 / 60, 2 / 60, 3 / 60, 2 / 60])
    assert trace.fired("execOut") == [0, 1, 2, 3]


def test_the_system_time_of_a_past_frame_is_that_of_its_physics_step(world):
    app = world(physics_hz=60, loop_hz=60)
    start = app.simulation.system_time
    inputs = {"referenceTimeNumerator": 2, "referenceTimeDenominator": lambda update: 0 if update < 3 else 60}
    trace = run_node("IsaacReadSystemTimeAnnotator", inputs=inputs, pulses={"execIn": range(4)}, updates=4, app=app)
    read = trace.values("systemTime")
    assert [time - start for time in read[:3]] == pytest.approx([read[0] - start + k / 60 for k in range(3)], abs=1e-6)
    assert read[3] == pytest.approx(read[1], abs=1e-6)


def test_the_test_node_hands_its_text_on():
    assert run_node("IsaacTestNode", inputs={"input": "hello"}, pulses={"execIn": [0]}).value("output") == "hello"
