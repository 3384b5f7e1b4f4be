"""When a frame is of: the annotators of its reference time, and the outputs of clock nodes in a post-render graph."""

from __future__ import annotations

from fractions import Fraction

import pytest

import sensors.replicator as rep
from graph.sim import App, VirtualClock
from graph.sim import settings as keys
from tests.support.lidar_worlds import add_box, define_lidar, rotary, weightless
from tests.support.without_wing import needs_wing

EPOCH = 1_700_000_000
PRODUCT = "isaacsim-6.0.1"


def attached(product, name, **options):
    return rep.AnnotatorRegistry.get_annotator(name).initialize(**options).attach([product])


def look_up(app, found):
    return found["referenceTimeNumerator"], found["referenceTimeDenominator"]


@pytest.fixture(params=["documented", PRODUCT])
def app(request):
    """A 10 Hz lidar in a room; physics and loop at 60 Hz; a wall clock that began at EPOCH."""
    with App(parity=request.param, settings={keys.WARM_UP_STEPS: 0}, wall_clock=VirtualClock(EPOCH)) as app:
        add_box(app, "/World/Room", 10.0, (0, 0, 0))
        define_lidar(app)
        yield app


def test_a_frames_times_are_those_that_look_ups_give_at_its_reference_time(app):
    product = rep.create.render_product("/World/Lidar", (32, 32))
    reference = attached(product, "ReferenceTime")
    since_play = attached(product, "IsaacReadSimulationTime", resetOnStop=True)
    monotonic = attached(product, "IsaacReadSimulationTime", resetOnStop=False)
    system = attached(product, "IsaacReadSystemTime")
    app.play()
    app.update()
    app.stop()
    app.play()
    app.update(10)

    # The tick at 0.1 s is that of step 6 of this play; one step was made in the play before. Frames between ticks stay.
    at = look_up(app, reference.get_data())
    assert Fraction(*at) == Fraction(1, 10)
    assert since_play.get_data() == {"simulationTime": 0.1}
    assert monotonic.get_data()["simulationTime"] == pytest.approx(7 / 60, abs=1e-15)
    # Step 6 ran in update 6 of this play: after 1 update of the first play and 5 of this one.
    each = 1 / 60 if app.parity == "documented" else 1 / 120
    assert system.get_data()["systemTime"] - EPOCH == pytest.approx(6 * each, abs=1e-6)
    simulation = app.simulation
    assert simulation.get_simulation_time_at_time(at) == since_play.get_data()["simulationTime"]
    assert simulation.get_simulation_time_monotonic_at_time(at) == monotonic.get_data()["simulationTime"]
    assert simulation.get_system_time_at_time(at) == system.get_data()["systemTime"]


def test_before_the_first_frame_the_keys_are_there_and_the_reference_time_stands_for_now(app):
    product = rep.create.render_product("/World/Lidar", (32, 32))
    names = ("ReferenceTime", "IsaacReadSimulationTime", "IsaacReadSystemTime")
    found = [attached(product, name).get_data() for name in names]
    assert found == [
        {"referenceTimeNumerator": 0, "referenceTimeDenominator": 0},
        {"simulationTime": 0.0},
        {"systemTime": 0.0},
    ]
    app.play()
    app.update(3)
    assert app.simulation.get_simulation_time_at_time(look_up(app, found[0])) == 3 / 60


def test_the_product_keeps_reference_times_in_whole_microseconds_and_echoes_them():
    with App(parity=PRODUCT, settings={keys.WARM_UP_STEPS: 0}) as app:
        define_lidar(app, config=rotary(scan_hz=Fraction(15)))
        product = rep.create.render_product("/World/Lidar", (32, 32))
        reference, time = attached(product, "ReferenceTime"), attached(product, "IsaacReadSimulationTime")
        app.play()
        app.update(5)  # the frame of 4/60 s = 1/15 s comes an update later
        assert Fraction(*look_up(app, reference.get_data())) == Fraction(66_666, 10**6)
        assert time.get_data() == {"simulationTime": 0.066666}


def test_a_frame_older_than_all_samples_keeps_its_time():
    # 10 Hz in 60 updates a second: after 40 updates without a tick (disabled) the sample of 0.1 s is gone.
    with weightless(physics_hz=60) as app:
        define_lidar(app)
        product = rep.create.render_product("/World/Lidar", (32, 32))
        time = attached(product, "IsaacReadSimulationTime")
        app.play()
        app.update(6)
        product.enabled = False
        app.update(40)
        assert time.get_data() == {"simulationTime": 0.1}
        assert "time-sample-missing" not in app.warnings.codes()


def test_clock_nodes_of_a_post_render_graph_give_the_frames_reference_time(tmp_path):
    file = tmp_path / "g.yaml"
    file.write_text(
        """\
tickgraph: 1
scene:
  prims:
    /World/Room: {type: Cube, size: 10.0}
    /World/Lidar: {type: OmniLidar, config: Example_Rotary_2D}
clock: {physics_hz: 240, loop_hz: 24}
graphs:
  /World/Make:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
    connections: [tick.tick -> product.execIn]
  /World/Frames:
    pipeline_stage: post_render
    nodes:
      cloud: OgnIsaacExtractRTXSensorPointCloud
      time: IsaacReadSimulationTimeAnnotator
      gate: RationalTimeSyncGate
    connections:
      - /World/Make/product.outputs:renderProductPath -> cloud.renderProductPath
      - cloud.exec -> time.execIn
      - time.execOut -> gate.execIn
      - time.referenceTimeNumerator -> gate.rationalTimeNumerator
      - time.referenceTimeDenominator -> gate.rationalTimeDenominator
"""
    )
    with App.from_file(file) as app:
        app.play()
        app.update(3)  # to 0.125 s; the scan is of the state of step 24, at 0.1 s
        gate = app.graphs["/World/Frames"].nodes["gate"]
        found = gate.get("outputs:rationalTimeNumerator"), gate.get("outputs:rationalTimeDenominator")
        assert found == (1, 10)
        assert app.graphs["/World/Frames"].nodes["time"].get("outputs:simulationTime") == 0.1


@needs_wing("replicator")
def test_clocks_of_a_graph_that_any_frame_starts_give_the_time_of_that_frame(tmp_path):
    file = tmp_path / "g.yaml"
    file.write_text(
        """\
tickgraph: 1
scene:
  prims:
    /World/Room: {type: Cube, size: 10.0}
    /World/Lidar: {type: OmniLidar, config: Example_Rotary_2D}
clock: {physics_hz: 240, loop_hz: 24}
graphs:
  /World/Make:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
    connections: [tick.tick -> product.execIn]
  /World/Frames:
    pipeline_stage: post_render
    nodes:
      entry: GpuInteropRenderProductEntry
      time: IsaacReadSimulationTimeAnnotator
    connections: [entry.exec -> time.execIn]
"""
    )
    with App.from_file(file) as app:
        app.play()
        app.update(3)  # to 0.125 s; the scan is of the state of step 24, at 0.1 s
        nodes = app.graphs["/World/Frames"].nodes
        assert nodes["time"].get("outputs:simulationTime") == nodes["entry"].get("outputs:simTime") == 0.1
