"""The two profiles: a test for each row of the table of differences, in both, and for each setting of its own."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

from graph.base.errors import RunError, UserError
from graph.sim import App, MemorySink
from graph.sim import settings as keys
from graph.sim.settings import DEFAULTS, DOCUMENTED, PRODUCT, PRODUCT_DEFAULTS
from tests.support.lidar_texts import lidar_graph
from tests.support.noting_sensor import NotingSensor, add
from tests.support.without_wing import needs_wing

SCENE = """\
tickgraph: 1
scene:
  prims:
    /World/Wall: {type: Cube, size: 2.0, translate: [6, 0, 0]}
    /World/Lidar: {type: OmniLidar, config: Example_Rotary_2D}
    /World/Bare: {type: OmniLidar, translate: [0, 0, 3]}
    /World/Tall: {type: OmniLidar, config: XT32, translate: [0, 3, 3]}
"""
LIDAR = lidar_graph("type: laser_scan, topicName: scan, fullScan: FULL")
COUNTDOWN = """\
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      wait: {type: Countdown, inputs: {duration: 5}}
      note: {type: Counter}
    connections:
      - tick.tick -> wait.execIn
      - wait.finished -> note.execIn
"""
FAILS = """\
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      fails: {type: ROS2PublishLaserScan, inputs: {horizontalFov: 0}}
      note: {type: Counter}
    connections:
      - tick.tick -> fails.execIn
      - tick.tick -> note.execIn
"""
BODIES = """\
    /World/Ground: {type: Plane, collision: true}
    /World/Box: {type: Cube, size: 1.0, translate: [20, 0, 0.5], rigid_body: true, collision: true, mass: 1.0}
"""
AT_REST = """\
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      imu: {type: IsaacReadIMU, inputs: {imuPrim: /World/Box}}
      contact: {type: IsaacReadContactSensor, inputs: {csPrim: /World/Box}}
    connections:
      - tick.tick -> imu.execIn
      - tick.tick -> contact.execIn
"""
FLAT_3D = """\
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Tall}}
    connections: [tick.tick -> product.execIn]
  /World/Frames:
    pipeline_stage: post_render
    nodes: {scan: IsaacComputeRTXLidarFlatScan}
    connections: [/World/G/product.outputs:renderProductPath -> scan.renderProductPath]
"""
DRIVES = """\
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      drive: {type: DifferentialController, inputs: {wheelRadius: 0.1, wheelDistance: 0.5, linearVelocity: 1.0}}
      around: {type: HolonomicController, inputs: {inputVelocity: [1, 2, 3]}}
      joints: {type: IsaacArticulationController, inputs: {velocityCommand: [5]}}
    connections:
      - tick.tick -> drive.execIn
"""


@pytest.fixture
def run(tmp_path):
    """Opens the App of a graph file with this text after the scene: run(text, parity, settings)."""
    opened = []

    def open_app(text="", parity=DOCUMENTED, settings=None, *, scene=SCENE, **clock):
        file = tmp_path / f"{len(opened)}.yaml"
        clock = ", ".join(f"{key}: {value}" for key, value in {"parity": parity, **clock}.items())
        file.write_text(f"{scene}clock: {{{clock}}}\n{text.replace('FULL', 'true')}")
        app = App.from_file(file, settings=settings)
        app.sink = MemorySink()
        app.bus.subscribe(app.sink)
        opened.append(app)
        return app

    yield open_app
    for app in opened:
        app.close()


def both(setting):
    """(parity, settings, value): each profile's default, and each value set by itself against the other profile."""
    documented, product = DEFAULTS[setting], PRODUCT_DEFAULTS[setting]
    return pytest.mark.parametrize(
        ("parity", "settings", "value"),
        [
            (DOCUMENTED, {}, documented),
            (PRODUCT, {}, product),
            (DOCUMENTED, {setting: product}, product),
            (PRODUCT, {setting: documented}, documented),
        ],
        ids=["documented", "product", "set in documented", "set in product"],
    )


def test_the_documented_profile_is_the_default():
    with App() as app:
        assert app.parity == DOCUMENTED
        assert {path: app.settings.get(path) for path in DEFAULTS} == DEFAULTS


def test_every_difference_is_a_difference():
    assert all(product != DEFAULTS[path] for path, product in PRODUCT_DEFAULTS.items())


@both(keys.WARM_UP_STEPS)
def test_row_warm_up_steps_on_play(parity, settings, value):
    with App(parity=parity, settings=settings) as app:
        app.play()
        assert app.simulation.get_num_physics_steps() == value


@both(keys.MIN_FRAME_RATE)
def test_row_catch_up_cap(parity, settings, value):
    with App(loop_hz=10, parity=parity, settings={keys.WARM_UP_STEPS: 0, **settings}) as app:
        app.play()
        app.update()
        assert app.simulation.get_num_physics_steps() == (2 if value == 30 else 6)


@both(keys.TRUNCATE_STEPS)
@pytest.mark.parametrize(
    ("dt", "exact", "whole"),
    [
        (1 / 93, Fraction(93), 92),
        (0.0167, Fraction(10000, 167), 59),
        (0.03, Fraction(100, 3), 33),
        (0.7, Fraction(10, 7), 1),
    ],
)
def test_row_steps_per_second_from_a_dt(parity, settings, value, dt, exact, whole):
    with App(parity=parity, settings=settings) as app:
        app.simulation.setup_simulation(dt=dt)
        assert app.simulation.steps_per_second == (whole if value else exact)


@both(keys.TRUNCATE_STEPS)
def test_row_steps_per_second_a_rate_that_is_not_a_whole_number(parity, settings, value):
    with App(physics_hz=59.94, parity=parity, settings=settings) as app:
        assert app.simulation.steps_per_second == (59 if value else Fraction(5994, 100))
        assert [warning.code for warning in app.warnings] == (["physics-rate-truncated"] if value else [])


def test_row_steps_per_second_141_steps_of_up_to_2000_lose_one():
    with App(parity=PRODUCT) as app:
        lost = []
        for rate in range(1, 2001):
            app.simulation.setup_simulation(dt=1 / rate)
            if app.simulation.steps_per_second != rate:
                assert app.simulation.steps_per_second == rate - 1
                lost.append(rate)
        assert (len(lost), lost[:9]) == (141, [93, 99, 105, 117, 123, 186, 198, 210, 211])


@both(keys.SAMPLE_SUBSTEPS)
def test_row_time_samples(parity, settings, value):
    with App(physics_hz=120, parity=parity, settings={keys.WARM_UP_STEPS: 0, **settings}) as app:
        app.play()
        app.update(2)
        samples = app.simulation.get_all_samples()
        if value:
            assert [sample.key for sample in samples] == [Fraction(n, 10**6) for n in (8333, 16666, 25000, 33333)]
        else:
            assert [sample.key for sample in samples] == [Fraction(1, 60), Fraction(2, 60)]
        assert samples[-1].simulation == Fraction(2, 60)
        # "time at t": an echo, or what was simulated around then
        assert app.simulation.get_simulation_time_at_time((5, 1)) == (5.0 if value else 2 / 60)
        assert app.simulation.get_simulation_time_at_time((1, 40)) == pytest.approx(1 / 40)


@both(keys.SET_DT_RATE_LIMIT)
@pytest.mark.parametrize("limited", [False, True])
def test_row_set_dt(parity, settings, value, limited):
    given = {keys.RATE_LIMIT_ENABLED: limited, keys.RATE_LIMIT_FREQUENCY: 77, keys.TARGET_FRAMERATE: 77}
    with App(parity=parity, settings={**given, **settings, keys.MANUAL_MODE: False}) as app:
        app.rendering.set_dt(1 / 50)
        follows = 50 if value or limited else 77
        assert app.settings.get(keys.RATE_LIMIT_FREQUENCY) == follows
        assert app.timeline.get_target_framerate() == follows
        assert app.timeline.get_time_codes_per_second() == app.stage.GetTimeCodesPerSecond() == 50
        assert app.run_loop.manual_mode
        assert app.run_loop.manual_step == Fraction(1, 50)
        assert app.settings.get("/app/settings/fabricDefaultSimPeriodDenominator") == 50
        assert app.simulation.steps_per_second == 60


@both(keys.RATE_LIMIT_FREQUENCY)
def test_row_rate_limit_frequency(parity, settings, value):
    with App(parity=parity, settings=settings) as app:
        assert app.settings.get(keys.RATE_LIMIT_FREQUENCY) == value
        app.update()
        assert app.wall_clock.now() == Fraction(1, value)


def test_row_rate_limit_frequency_an_explicit_loop_rate_beats_both():
    for parity in (DOCUMENTED, PRODUCT):
        with App(loop_hz=50, parity=parity) as app:
            assert app.settings.rate(keys.RATE_LIMIT_FREQUENCY) == 50


def test_row_rate_limit_frequency_get_dt_with_the_limit_on():
    for parity, dt in ((DOCUMENTED, 1 / 60), (PRODUCT, 1 / 120)):
        with App(parity=parity, settings={keys.RATE_LIMIT_ENABLED: True}) as app:
            assert app.rendering.get_dt() == dt


@both(keys.REWRITE_RATE_LIMIT)
def test_row_play_in_fixed_stepping(parity, settings, value):
    given = {keys.RATE_LIMIT_FREQUENCY: 45, keys.TARGET_FRAMERATE: 100}
    with App(experience="full", parity=parity, settings={**given, **settings}) as app:
        app.play()
        assert app.settings.get(keys.RATE_LIMIT_FREQUENCY) == (120 if value else 45)
    with App(parity=parity, settings={**given, **settings}) as app:  # variable stepping: never
        app.play()
        assert app.settings.get(keys.RATE_LIMIT_FREQUENCY) == 45


@both(keys.AUTOTRIGGER_IDLE)
def test_row_update_in_which_the_physics_clock_did_not_move(parity, settings, value):
    given = {keys.WARM_UP_STEPS: 0, keys.FRAMES_LATER: False}
    with App(physics_hz=20, loop_hz=60, parity=parity, settings={**given, **settings}) as app:
        auto, due = add(app, NotingSensor(), "auto"), add(app, NotingSensor(10), "due")
        app.play()
        app.update(6)
        assert len(due.ticks) == 1
        assert [tick.time * 20 for tick in auto.ticks] == ([0, 0, 1, 1, 1, 2] if value else [1, 2])
        assert [tick.end - tick.start for tick in auto.ticks if tick.time == tick.start] == [0] * (4 if value else 0)
        count = len(auto.ticks)
        app.settings.set(keys.PLAY_SIMULATIONS, False)
        app.update()
        assert len(auto.ticks) - count == (1 if value else 0)
        assert len(due.ticks) == 1
        app.pause()
        app.update(3)  # data appear only while the timeline plays
        assert len(auto.ticks) - count == (1 if value else 0)


@both(keys.AUTOTRIGGER_IDLE)
@pytest.mark.parametrize("motion", ["frozen", "update", "continuous"])
def test_row_update_in_which_the_physics_clock_did_not_move_a_lidar_has_fired_nothing(
    run, parity, settings, value, motion
):
    given = {keys.WARM_UP_STEPS: 0, keys.FRAMES_LATER: False}
    app = run(parity=parity, settings={**given, **settings}, physics_hz=30, loop_hz=60)
    object.__setattr__(app.fidelity, "lidar_motion", motion)
    from pxr import UsdGeom

    from sensors import Lidar, LidarSensor

    UsdGeom.Cube.Define(app.stage, "/World/Room").GetSizeAttr().Set(8)
    sensor = LidarSensor(Lidar("/World/Lidar", tick_rate=0, app=app), annotators=["generic-model-output"])
    counts = []
    app.on("post_render_graphs", lambda: counts.append(sensor.render_product.frame.count))
    app.play()
    app.update(4)
    assert [count > 0 for count in counts] == ([False, True, False, True] if value else [True, True])


@both(keys.BARE_LIDAR_TICK_RATE)
def test_row_tick_rate_of_a_bare_lidar(run, parity, settings, value):
    app = run(parity=parity, settings=settings)
    from sensors.products import render_product

    assert render_product(app, "/World/Bare").sensor.rate == value
    assert render_product(app, "/World/Lidar").sensor.rate == 10  # its config authors it


@both(keys.FRAMES_LATER)
def test_row_frames_delivered(parity, settings, value):
    with App(parity=parity, settings={keys.WARM_UP_STEPS: 0, **settings}) as app:
        camera = add(app, NotingSensor(20))
        product = camera.product
        told, fresh = [], []
        app.on("post_render_graphs", lambda: told.append((app.update_index, product.frame.time)))
        app.on("end", lambda: fresh.append(product.new_frame))
        app.play()
        app.update(7)
        rendered = [tick.time for tick in camera.ticks]
        assert rendered == [Fraction(1, 20), Fraction(2, 20)]
        assert told == [(update + (1 if value else 0), time) for update, time in zip((2, 5), rendered, strict=True)]
        assert fresh == [update in dict(told) for update in range(7)]
        assert not app.rendering.pending_frames


def test_row_frames_delivered_a_pause_delivers_what_was_rendered_and_a_stop_drops_it():
    with App(parity=PRODUCT) as app:
        product = add(app, NotingSensor()).product
        app.play()
        app.update()
        assert (app.rendering.pending_frames, product.frames) == (True, 0)
        app.pause()
        app.update()
        assert (app.rendering.pending_frames, product.frames) == (False, 1)
        app.play()
        app.update()
        app.stop()
        app.update()
        assert (app.rendering.pending_frames, product.frames) == (False, 0)


def test_row_frames_delivered_a_product_taken_away_gets_nothing():
    with App(parity=PRODUCT) as app:
        product = add(app, NotingSensor()).product
        app.play()
        app.update()
        app.rendering.remove(product.path)
        app.update()
        assert product.frames == 0


@pytest.mark.parametrize("parity", [DOCUMENTED, PRODUCT])
def test_row_trigger_reaching_a_latent_node_while_it_sleeps_is_ignored(run, parity):
    app = run(COUNTDOWN, parity)
    fired = []
    wait = app.graphs["/World/G"].nodes["wait"]
    app.on("end", lambda: fired.append(wait.fired.get("finished", 0)))
    app.play()
    app.update(18)
    assert [update for update in range(18) if fired[update] > (fired[update - 1] if update else 0)] == [5, 11, 17]


@pytest.mark.parametrize("parity", [DOCUMENTED, PRODUCT])
def test_row_trigger_reaching_a_latent_node_interrupts_where_that_is_set(run, parity):
    app = run(COUNTDOWN, parity, {keys.INTERRUPTS_OFF: False})
    app.play()
    app.update(18)
    assert app.graphs["/World/G"].nodes["wait"].fired.get("finished", 0) == 0


@both(keys.FULL_SCAN_WARNS)
@pytest.mark.parametrize("full", [False, True])
def test_row_full_scan_deprecation(run, parity, settings, value, full):
    app = run(LIDAR.replace("FULL", str(full).lower()), parity, settings)
    app.play()
    app.update()
    assert ("full-scan-deprecated" in [warning.code for warning in app.warnings]) == (full == value)


@both(keys.SCAN_EMPTY_MINUS_ONE)
def test_row_laser_scan_empty_beam(run, parity, settings, value):
    app = run(LIDAR, parity, settings)
    app.play()
    app.update(14)
    ranges = app.sink.messages["/scan"][0].message.ranges
    assert set(ranges[ranges < 0]) == ({-1.0} if value else set())
    assert set(ranges[ranges > 100]) == (set() if value else {math.inf})
    assert ((ranges > 0) & (ranges < 10)).any()


@both(keys.SCAN_END_BEYOND)
def test_row_laser_scan_end_angle(run, parity, settings, value):
    app = run(LIDAR, parity, settings)
    app.play()
    app.update(14)
    scan = app.sink.messages["/scan"][0].message
    last = scan.angle_min + (len(scan.ranges) - 1) * scan.angle_increment
    assert scan.angle_max == pytest.approx(last + (scan.angle_increment if value else 0), abs=1e-9)


@both(keys.LIDAR_HEADER)
def test_row_header_of_lidar_messages(run, parity, settings, value):
    # 10 updates of 1/24 s at 240 Hz: the tick at 0.1 s is step 24, in update 3, which ends at 0.125 s.
    still = {keys.WARM_UP_STEPS: 0, keys.MIN_FRAME_RATE: 0}
    app = run(lidar_graph(), parity, {**still, **settings}, physics_hz=240, loop_hz=24)
    app.play()
    app.update(10)
    stamp = app.sink.messages["/points"][0].message.header.stamp
    assert stamp.sec == 0
    assert stamp.nanosec == {keys.HEADER_FRAME: 100_000_000, keys.HEADER_UPDATE: 125_000_000}[value]


@both(keys.FRAME_ID_AS_GIVEN)
def test_row_frame_of_a_cloud_in_the_world(run, parity, settings, value):
    # Under the default frameId, which is that of the sensor.
    app = run(lidar_graph(), parity, settings)
    app.stage.GetPrimAtPath("/World/Lidar").GetAttribute("omni:sensor:Core:outputFrameOfReference").Set("WORLD")
    app.play()
    app.update(14)
    assert app.sink.messages["/points"][0].message.header.frame_id == ("sim_lidar" if value else "world")


@both(keys.SCAN_BINS)
def test_row_cells_of_a_laser_scan(run, parity, settings, value):
    # A clockwise lidar of 3600 beams: 0.1 deg from beam to beam, falling as it fires, or ascending bins.
    app = run(LIDAR, parity, settings)
    app.play()
    app.update(14)
    scan = app.sink.messages["/scan"][0].message
    assert len(scan.ranges) == 3600
    assert scan.angle_increment == pytest.approx(math.radians(0.1 if value else -0.1), rel=1e-6)


@both(keys.FLAT_SCAN_NEEDS_2D)
def test_row_flat_scan_of_a_3d_lidar(run, parity, settings, value):
    if value:
        with pytest.raises(UserError, match="/World/Tall: a flat or laser scan needs a 2D lidar"):
            run(FLAT_3D, parity, settings)
        return
    app = run(FLAT_3D, parity, settings)
    app.play()
    app.update(40)
    scan = app.graphs["/World/Frames"].nodes["scan"]
    assert (scan.get("outputs:numRows"), scan.get("outputs:numCols")) == (1, 0)
    assert scan.computes > 3
    assert [one.count for one in app.warnings if one.code == "flat-scan-3d"] == [1]


@needs_wing("robots")
@both(keys.STOP_CLEARS_COMMANDS)
def test_row_commands_of_controllers_at_stop(run, parity, settings, value):
    # v / r = 1 / 0.1 rad/s on both wheels.
    app = run(DRIVES, parity, settings)
    nodes = app.graphs["/World/G"].nodes
    for drives in (True, not value):
        app.play()
        app.update()
        assert list(nodes["drive"].get("outputs:velocityCommand")) == ([10.0, 10.0] if drives else [0.0, 0.0])
        app.stop()
        assert list(nodes["drive"].get("outputs:velocityCommand")) == [0.0, 0.0]
    assert nodes["drive"].get("inputs:linearVelocity") == (0.0 if value else 1.0)
    assert nodes["drive"].get("inputs:wheelRadius") == 0.1
    assert list(nodes["around"].get("inputs:inputVelocity")) == ([0, 0, 0] if value else [1, 2, 3])
    assert list(nodes["joints"].get("inputs:velocityCommand")) == ([] if value else [5])


@both(keys.ODOMETRY_WORLD_TURN)
def test_row_axes_of_odometrys_turn_rate(parity, settings, value):
    """60 deg/s about the world's z is a turn about the body's y, if the body is rolled by 90 deg about x."""
    from pxr import UsdGeom, UsdPhysics

    from graph.testing import run_node

    with App(parity=parity, settings=settings) as app:
        UsdPhysics.Scene.Define(app.stage, "/World/Physics").GetGravityMagnitudeAttr().Set(0.0)
        cube = UsdGeom.Cube.Define(app.stage, "/World/Cube")
        cube.AddRotateXOp().Set(90)
        UsdPhysics.RigidBodyAPI.Apply(cube.GetPrim()).GetAngularVelocityAttr().Set((0, 0, 60))
        inputs = {"chassisPrim": "/World/Cube"}
        trace = run_node("IsaacComputeOdometry", inputs=inputs, pulses={"execIn": [0]}, updates=1, app=app)
    rate = math.radians(60)
    assert trace.value("angularVelocity") == pytest.approx([0, 0, rate] if value else [0, rate, 0], abs=1e-6)


@both(keys.NODE_ERRORS_STOP)
def test_row_compute_that_raises(run, parity, settings, value):
    app = run(FAILS, parity, settings)
    app.play()
    if value:
        with pytest.raises(RunError, match="horizontalFov"):
            app.update(3)
        return
    app.update(3)
    assert app.graphs["/World/G"].nodes["note"].get("count") == 3
    assert [warning.count for warning in app.warnings if warning.code == "compute-failed"] == [3]


@both(keys.SENSOR_NODES_TAKE_BODIES)
@pytest.mark.parametrize("node", ["imu", "contact"])
def test_row_prims_of_sensor_nodes(run, node, parity, settings, value):
    # 1 kg at rest on the ground: 9.81 m/s^2 up, 9.81 N; without a sensor's prim the outputs keep their zeros.
    app = run(AT_REST, parity, {keys.NODE_ERRORS_STOP: False, **settings}, scene=SCENE + BODIES)
    app.play()
    app.update(60)
    read = app.graphs["/World/G"].nodes
    felt = {"imu": read["imu"].get("outputs:linAcc")[2], "contact": read["contact"].get("outputs:value")}[node]
    assert felt == pytest.approx(9.81 if value else 0.0, rel=1e-2)
    assert sum(one.count for one in app.warnings if one.code == "compute-failed") == (0 if value else 120)


@both(keys.RADAR_IGNORES_TICK_RATE)
def test_row_rate_of_a_radar(parity, settings, value):
    from sensors import Radar, RadarSensor

    given = {keys.FRAMES_LATER: False, keys.MOTION_BVH: True}
    with App(parity=parity, settings={**given, **settings}, physics_hz=60, loop_hz=60) as app:
        sensor = RadarSensor(Radar("/World/Radar", tick_rate=20.0, app=app))
        app.play()
        app.update(12)
        assert sensor.render_product.frames >= 12 if value else sensor.render_product.frames == 4
        assert ("radar-tick-rate-ignored" in {one.code for one in app.warnings}) is value


@both(keys.RADAR_NEEDS_MOTION_BVH)
def test_row_motion_bvh_of_a_radar(parity, settings, value):
    from sensors import Radar

    with App(parity=parity, settings=settings) as app:
        if value:
            with pytest.raises(RuntimeError, match="a radar needs Motion BVH"):
                Radar("/World/Radar", app=app)
            app.settings.set(keys.MOTION_BVH, True)
        assert Radar("/World/Radar", app=app).paths == ["/World/Radar"]


@both(keys.CAMERA_TONE)
def test_row_tone_of_pictures(parity, settings, value):
    """A dome of 1250 nit is 1 at 0.02 s and f/5: white, or 2.54 / 3.16 = 0.8038, of sRGB 232 (231.6)."""
    from pxr import UsdGeom, UsdLux

    from sensors.replicator import get_annotator, render_product

    with App(parity=parity, settings={keys.FRAMES_LATER: False, **settings}) as app:
        UsdGeom.Camera.Define(app.stage, "/World/Camera")
        UsdLux.DomeLight.Define(app.stage, "/World/Sky").CreateIntensityAttr(1250.0)
        found = get_annotator("rgb", app=app).attach(render_product(app, "/World/Camera", (2, 2)))
        app.play()
        app.update()
        assert found.get_data()[0, 0].tolist() == ([232] * 3 if value == keys.TONE_ACES else [255] * 3) + [255]


@both(keys.ID_MAP_EXTENSION)
def test_row_ids_without_a_map_entry(tmp_path, parity, settings, value):
    from pxr import UsdGeom

    from graph.sim.scene.stage import open_stage
    from sensors import Lidar, LidarSensor, parse_stable_id_map_data

    stage = open_stage()
    rocks = UsdGeom.PointInstancer.Define(stage, "/World/Rocks")
    rock = UsdGeom.Cube.Define(stage, "/World/Rocks/Rock")
    rocks.CreatePrototypesRel().SetTargets([rock.GetPath()])
    rocks.CreateProtoIndicesAttr().Set([0, 0])
    rocks.CreatePositionsAttr().Set([(4, 0, 0), (0, 4, 0)])
    given = {"/rtx-transient/stableIds/enabled": True}
    with App(stage, parity=parity, settings={**given, **settings}) as app:
        sensor = LidarSensor(
            Lidar.create("/World/Lidar", config="Example_Rotary_2D", app=app), annotators=["stable-id-map"]
        )
        app.play()
        app.update(8)
        data, _ = sensor.get_data("stable-id-map")
        assert parse_stable_id_map_data(data) == {}
        assert len(parse_stable_id_map_data(data, resolve_all=True)) == (2 if value else 0)


def test_parity_of_a_file_reaches_every_part(run):
    app = run(LIDAR, PRODUCT)
    assert app.parity == PRODUCT
    assert {path: app.settings.get(path) for path in PRODUCT_DEFAULTS} == PRODUCT_DEFAULTS


def test_what_a_user_sets_wins_over_the_profile(run):
    app = run(parity=PRODUCT, settings={keys.WARM_UP_STEPS: 1})
    app.play()
    assert app.simulation.get_num_physics_steps() == 1
