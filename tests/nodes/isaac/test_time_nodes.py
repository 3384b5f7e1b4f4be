"""The time nodes over a world: a test for each row of their table, in both profiles."""

from __future__ import annotations

from fractions import Fraction

import pytest

from graph.sim import App, VirtualClock
from graph.sim import settings as keys
from graph.testing import run_node

PRODUCT = "isaacsim-6.0.1"
EPOCH = 1_700_000_000


@pytest.fixture(params=["documented", PRODUCT])
def app(request):
    """In its second play: 10 updates, 1 in the play before; the wall clock began at EPOCH. A node's run adds one."""
    with App(parity=request.param, settings={keys.WARM_UP_STEPS: 0}, wall_clock=VirtualClock(EPOCH)) as app:
        app.play()
        app.update()
        app.stop()
        app.play()
        app.update(10)
        yield app


def read(app, node="IsaacReadSimulationTime", output="simulationTime", **inputs):
    return run_node(node, inputs=inputs, app=app).value(output)


AT = {"referenceTimeNumerator": 1, "referenceTimeDenominator": 10}
BETWEEN = {"referenceTimeNumerator": 21, "referenceTimeDenominator": 200}  # 0.105 s, in the seventh update
FAR = {"referenceTimeNumerator": 5, "referenceTimeDenominator": 1}


def test_row_isaac_read_simulation_time_now(app):
    assert read(app) == 11 / 60


def test_row_isaac_read_simulation_time_monotonic(app):
    assert read(app, resetOnStop=False) == 12 / 60


def test_row_isaac_read_simulation_time_at_a_reference_time(app):
    assert read(app, **AT) == 0.1
    assert read(app, resetOnStop=False, **AT) == 7 / 60
    assert read(app, **BETWEEN) == pytest.approx(0.105)
    assert read(app, resetOnStop=False, **BETWEEN) == pytest.approx(0.105 + 1 / 60, abs=1e-6)


def test_row_isaac_read_simulation_time_at_a_time_never_simulated(app):
    assert read(app, **FAR) == (5.0 if app.parity == PRODUCT else 11 / 60)
    assert read(app, resetOnStop=False, **FAR) == app.simulation.get_simulation_time_monotonic()


@pytest.mark.parametrize("inputs", [{}, {"referenceTimeNumerator": 3}])
def test_row_isaac_read_simulation_time_without_a_denominator_is_now(app, inputs):
    assert read(app, **inputs) == 11 / 60


def annotator(app, node, output, **inputs):
    trace = run_node(node, inputs=inputs, pulses={"execIn": [0, 2]}, updates=3, app=app)
    assert trace.fired("execOut") == [0, 2]
    return trace.value(output)


def test_row_isaac_read_simulation_time_annotator(app):
    node = "IsaacReadSimulationTimeAnnotator"
    assert annotator(app, node, "simulationTime", **AT) == 0.1
    assert annotator(app, node, "simulationTime", resetOnStop=False, **AT) == 7 / 60
    assert annotator(app, node, "simulationTime") == app.simulation.get_simulation_time()


def test_row_isaac_read_system_time_and_its_annotator(app):
    # step 6 of this play ran in update 6: 1 update of the first play and 5 of this one had then ended
    for found in (
        read(app, "IsaacReadSystemTime", "systemTime", **AT),
        annotator(app, "IsaacReadSystemTimeAnnotator", "systemTime", **AT),
    ):
        assert found - EPOCH == pytest.approx((1 + 5) / (60 if app.parity == "documented" else 120), abs=1e-6)
    assert read(app, "IsaacReadSystemTime", "systemTime") == app.simulation.system_time
    assert read(app, "IsaacReadSystemTime", "systemTime", **FAR) == app.simulation.system_time


def test_system_time_stands_while_paused(app):
    before = app.simulation.system_time
    app.pause()
    app.update(10)
    assert app.simulation.system_time == before


def test_row_isaac_time_splitter():
    trace = run_node("IsaacTimeSplitter", inputs={"time": 1.25})
    assert [trace.value(name) for name in ("seconds", "milliseconds", "microseconds", "nanoseconds")] == [
        1,
        250,
        250_000,
        250_000_000,
    ]
    below = run_node("IsaacTimeSplitter", inputs={"time": -0.25})
    assert (below.value("seconds"), below.value("nanoseconds")) == (-1, 750_000_000)
    whole = run_node("IsaacTimeSplitter", inputs={"time": 7})
    assert (whole.value("seconds"), whole.value("nanoseconds")) == (7, 0)


@pytest.mark.parametrize(("step", "fired"), [(0, []), (1, [0, 1, 2, 3, 4, 5]), (2, [1, 3, 5]), (4, [3])])
def test_row_isaac_simulation_gate(step, fired):
    trace = run_node("IsaacSimulationGate", inputs={"step": step}, pulses={"execIn": range(6)}, updates=6)
    assert trace.fired("execOut") == fired


@pytest.mark.parametrize(("options", "rtf"), [({}, 1.0), ({"loop_hz": 30, "experience": "full"}, 0.5)])
def test_row_isaac_real_time_factor(options, rtf):
    with App(**options) as app:
        trace = run_node("IsaacRealTimeFactor", updates=6, app=app)
        assert trace.values("rtf") == pytest.approx([0.0] + [rtf] * 5)


def test_row_isaac_real_time_factor_without_progress_gives_nothing_new():
    with App(physics_hz=20, loop_hz=60) as app:
        # steps of 1/20 s in updates 2, 5, 8: 2/60, 3/60 and 3/60 s of wall time after the reading before
        trace = run_node("IsaacRealTimeFactor", updates=9, app=app)
        assert trace.values("rtf") == pytest.approx([0, 0, 1.5, 1.5, 1.5, 1, 1, 1, 1])


def test_row_ogn_isaac_run_one_simulation_frame():
    with App() as app:
        for _ in range(2):
            trace = run_node("OgnIsaacRunOneSimulationFrame", pulses={"execIn": range(3)}, updates=3, app=app)
            assert trace.fired("step") == [0]
            app.stop()


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
def test_row_on_physics_step_warm_up_included(tmp_path, parity):
    file = tmp_path / "g.yaml"
    file.write_text(f"""\
tickgraph: 1
clock: {{physics_hz: 120, loop_hz: 60, parity: {parity}}}
graphs:
  /World/G:
    pipeline_stage: on_demand
    nodes:
      step: OnPhysicsStep
      count: Counter
    connections:
      - step.step -> count.execIn
""")
    with App.from_file(file) as app:
        app.play()
        assert app.graphs["/World/G"].nodes["count"].get("count") == (2 if parity == PRODUCT else 0)
        app.update(3)
        nodes = app.graphs["/World/G"].nodes
        assert nodes["count"].get("count") == app.simulation.get_num_physics_steps()
        assert nodes["step"].get("deltaSimulationTime") == 1 / 120


def test_row_isaac_create_render_product_reuses_one_of_equal_camera_and_size(tmp_path):
    file = tmp_path / "g.yaml"
    file.write_text("""\
tickgraph: 1
scene:
  prims:
    /World/Lidar: {type: OmniLidar, config: Example_Rotary_2D}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      first: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      second: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      other: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar, width: 640}}
    connections:
      - tick.tick -> [first.execIn, second.execIn, other.execIn]
""")
    with App.from_file(file) as app:
        app.play()
        app.update()
        nodes = app.graphs["/World/G"].nodes
        paths = [nodes[name].get("renderProductPath") for name in ("first", "second", "other")]
        assert paths[0] == paths[1] != paths[2]
        assert len(app.rendering.products) == 2
        assert {product.created_at for product in app.rendering.products.values()} == {Fraction(0)}
