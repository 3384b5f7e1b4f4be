"""Lidars in a running App: which scans come when, and what they hold."""

import gc
from dataclasses import replace

import numpy as np
import pytest
from pxr import Gf, UsdGeom

from graph.sim import App
from sensors import (
    Lidar,
    LidarSensor,
    parse_generic_model_output_data,
    parse_object_ids,
    parse_stable_id_map_data,
)
from sensors.lidar.config import EmitterState
from sensors.raycast.triangles import alive
from sensors.raycast.world import CastWorld
from tests.support.lidar_worlds import NORMALS, add_box, add_lidar, frames_of, rotary, stare, weightless


def test_five_seconds_at_ten_hertz_are_fifty_whole_scans():
    with weightless() as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        product = add_lidar(app)

        frames = frames_of(app, product, 300)

        assert [frame.timestamp_ns for frame in frames] == [k * 100_000_000 for k in range(50)]
        assert all(frame.count == 360 and frame.scan_complete for frame in frames)
        assert [frame.frame_id for frame in frames] == list(range(50))
        assert frames[3].start.timestamp_ns == 300_000_000
        assert frames[3].end.timestamp_ns == 400_000_000


def test_angles_times_and_ids_of_a_whole_scan():
    with weightless() as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        product = add_lidar(app)

        [frame] = frames_of(app, product, 6)

        assert frame.channel("tickId").tolist() == list(range(360))
        assert frame.channel("timeOffsetNs").tolist() == [round(i * 1e8 / 360) for i in range(360)]
        assert frame.channel("azimuth")[:3].tolist() == [0.0, -1.0, -2.0]
        assert np.all(frame.channel("flags") == 64)
        assert not frame.channel("echoId").any()


def without_memory(cast):
    """`CastWorld.cast` of rays that remember nothing."""
    return lambda world, rays, *given, **more: cast(world, replace(rays, memory=None), *given, **more)


@pytest.mark.parametrize("motion", ["frozen", "update", "continuous"])
@pytest.mark.parametrize("tick_rate", [10, 7, 0])
@pytest.mark.parametrize("origin", [0.0, 0.1])
def test_a_lidar_that_stops_and_turns_again_sees_what_it_would_see_without_a_memory(
    motion, tick_rate, origin, monkeypatch
):
    state = EmitterState(azimuth_deg=[0, 0], elevation_deg=[-5, 5], hor_offset_m=[0, origin])

    def frames():
        with weightless(lidar_motion=motion) as app:
            add_box(app, "/World/Room", 20.0, (0, 0, 0))
            add_box(app, "/World/Body", 1.0, (4, 0, 0), velocity=(1, 0.5, 0), spin=(50, 60, 70))
            product = add_lidar(app, config=rotary(emitter_states=(state,)), tick_rate=tick_rate)
            found = []
            app.play()
            for update in range(90):
                if update in (40, 41, 60):
                    pose = np.eye(4)
                    pose[:2, 3] = 0.1 * (update == 41), update / 1000
                    app.fabric.set_world_matrix("/World/Lidar", pose)
                app.update()
                if product.new_frame:
                    found.append(product.frame)
            return found

    remembered = frames()
    monkeypatch.setattr(CastWorld, "cast", without_memory(CastWorld.cast))
    for one, other in zip(remembered, frames(), strict=True):
        assert one.count > 0
        for name in one.arrays:
            np.testing.assert_array_equal(one.channel(name), other.channel(name))


@pytest.mark.parametrize("motion", ["frozen", "update", "continuous"])
@pytest.mark.parametrize(
    ("ticks", "step", "expected"),
    [
        (1, 1, [[0], [1], [2], [0], [1]]),
        (4, 1, [[0, 1, 2, 0], [1, 2, 0, 1], [2, 0, 1, 2], [0, 1, 2, 0], [1, 2, 0, 1]]),
        (2, 2, [[0, 0], [1, 1], [2, 2], [0, 0], [1, 1]]),
        (3, 1, [[0, 1, 2]] * 5),
    ],
)
def test_emitter_states_go_on_from_turn_to_turn(motion, ticks, step, expected):
    states = tuple(EmitterState(azimuth_deg=[0.0], elevation_deg=[angle]) for angle in (-5.0, 0.0, 5.0))
    with weightless(lidar_motion=motion) as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        config = rotary(ticks, emitter_states=states, state_resolution_step=step)
        product = add_lidar(app, config=config)

        frames = frames_of(app, product, 30)

        assert [frame.channel("tickStates").tolist() for frame in frames] == expected
        for frame in frames:
            np.testing.assert_array_equal(frame.channel("elevation"), 5.0 * frame.channel("tickStates") - 5.0)


@pytest.mark.parametrize("offset", [0.0, 1e3, 1e4, 1e5, 1e6])
def test_ranges_normals_and_intensity_match_the_room_wherever_it_is(offset):
    with weightless() as app:
        add_box(app, "/World/Room", 20.0, (offset, offset, 0))
        product = add_lidar(app, position=(offset, offset, 0), config=rotary(elevations=(0.0, 5.0)))

        [frame] = frames_of(app, product, 6)

        azimuth, elevation = np.deg2rad(-np.arange(360.0)).repeat(2), np.deg2rad(np.tile([0.0, 5.0], 360))
        beam = np.stack(
            [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], axis=1
        )
        exact = (10.0 / np.maximum(np.abs(beam), 1e-12)).min(axis=1)
        np.testing.assert_allclose(frame.channel("distance"), exact, atol=1e-4)
        np.testing.assert_allclose(frame.xyz, beam * exact[:, None], atol=1e-4)
        incidence = 10.0 / exact  # the cosine at the wall that is hit
        np.testing.assert_allclose(frame.channel("scalar"), 0.5 * incidence, atol=1e-5)
        clear = np.abs(np.abs(beam[:, 0]) - np.abs(beam[:, 1])) > 1e-3  # not on an edge of the room
        inwards = np.einsum("ij,ij->i", frame.channel("hitNormals"), beam)
        np.testing.assert_allclose(inwards[clear], -incidence[clear], atol=1e-5)


@pytest.mark.parametrize("loop_hz", [10, 24, 30, 60, 120, 240])
@pytest.mark.parametrize("ticks", [90, 7])
def test_update_mode_puts_slices_together_to_the_same_scan(loop_hz, ticks):
    def scans(motion):
        with weightless(lidar_motion=motion, loop_hz=loop_hz) as app:
            add_box(app, "/World/Room", 20.0, (1, 2, 0))
            product = add_lidar(app, config=rotary(ticks, elevations=(0.0, 3.0)))
            return frames_of(app, product, loop_hz // 2)

    frozen, sliced = scans("frozen"), scans("update")

    assert [f.timestamp_ns for f in sliced] == [f.timestamp_ns for f in frozen]
    assert len(frozen) >= 4
    for a, b in zip(frozen, sliced, strict=True):
        assert b.scan_complete
        assert a.arrays.keys() == b.arrays.keys()
        for name in a.arrays:
            np.testing.assert_array_equal(a.arrays[name], b.arrays[name], err_msg=name)


@pytest.mark.parametrize("tick_rate", [0, 5, 20])
def test_partial_scans_of_a_turn_make_up_the_whole_scan(tick_rate):
    def run(rate):
        with weightless() as app:
            add_box(app, "/World/Room", 20.0, (1, 2, 0))
            product = add_lidar(app, config=rotary(90, elevations=(0.0, 3.0)), tick_rate=rate)
            return frames_of(app, product, 60), app.warnings.codes()

    whole, _ = run(10)
    partial, codes = run(tick_rate)

    assert len(partial) == 60
    assert codes == ["lidar-partial-scan"]
    assert not any(frame.scan_complete for frame in partial)
    for name in ("xyz", "azimuth", "distance", "tickId", "emitterId", "scalar", "hitNormals"):
        np.testing.assert_array_equal(
            np.concatenate([frame.channel(name) for frame in partial]),
            np.concatenate([frame.channel(name) for frame in whole]),
            err_msg=name,
        )
    times = [
        np.concatenate([f.channel("timeOffsetNs") + f.timestamp_ns for f in frames]) for frames in (partial, whole)
    ]
    assert np.abs(times[0] - times[1]).max() <= 1
    assert np.all(np.diff(times[0]) >= 0)


def test_the_partial_warning_names_both_rates():
    with weightless() as app:
        add_lidar(app, tick_rate=5)

        [warning] = app.warnings

        assert warning.where == "/World/Lidar"
        assert "tickRate is 5 Hz, scanRateBaseHz is 10 Hz" in warning.message


def test_a_solid_state_lidar_in_parts_gives_the_emitters_that_fired():
    config = stare([0.0, 0.02, 0.04, 0.099], [0.0, 1.0, 2.0, 3.0])
    with weightless() as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        product = add_lidar(app, config=config, tick_rate=0)

        frames = frames_of(app, product, 6)

        assert [frame.channel("emitterId").tolist() for frame in frames] == [[0], [1], [2], [], [], [3]]


def test_without_accumulation_every_update_gives_its_part():
    with weightless() as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        product = add_lidar(app, config=rotary(60, accumulate_outputs=False))

        frames = frames_of(app, product, 6)

        assert [frame.count for frame in frames] == [10] * 6
        assert app.warnings.codes() == []


def test_a_frozen_scan_shows_the_world_at_the_first_step_at_or_after_its_tick():
    with weightless(loop_hz=7, physics_hz=60) as app:  # an update of 8 or 9 steps; tick at 0.1 s is step 6
        add_box(app, "/World/Wall", 1.0, (10, 0, 0), velocity=(3.0, 0, 0))
        product = add_lidar(app)

        [frame] = frames_of(app, product, 1)

        assert frame.channel("azimuth")[0] == 0.0
        assert frame.channel("distance")[0] == pytest.approx(9.5 + 3.0 * 0.1, abs=1e-4)


def test_update_mode_sees_each_slice_where_the_wall_then_was():
    with weightless(loop_hz=40, lidar_motion="update") as app:
        add_box(app, "/World/Wall", 4.0, (10, 0, 0), velocity=(3.0, 0, 0))
        product = add_lidar(app, config=stare(np.arange(4) * 0.025))

        [frame] = frames_of(app, product, 4)

        np.testing.assert_allclose(frame.channel("distance"), 8.0 + 3.0 * np.array([1, 2, 3, 4]) / 40, atol=1e-4)


def test_velocities_are_those_of_the_hit_points_seen_from_the_sensor():
    with weightless() as app:
        add_box(app, "/World/Wall", 4.0, (10, 0, 0), velocity=(3.0, 0.5, 0), spin=(0, 0, 90))
        add_box(app, "/World/Fixed", 4.0, (-10, 0, 0))
        carrier = add_box(app, "/World/Cart", 0.1, (0, 0, -5), velocity=(1.0, 0, 0))
        config = rotary(90)
        resting = add_lidar(app, config=config)
        moving = add_lidar(app, f"{carrier.GetPath()}/Lidar", (0, 0, 5), config=config)

        app.play()
        app.update(steps=6)

        frame = resting.frame
        points, speeds = frame.xyz.astype(np.float64), frame.channel("velocities")
        wall = points[:, 0] > 0
        centre = np.array([10.3, 0.05, 0.0])
        arm = points[wall] - centre
        expected = np.array([3.0, 0.5, 0.0]) + np.pi / 2 * np.stack([-arm[:, 1], arm[:, 0], 0 * arm[:, 0]], axis=1)
        np.testing.assert_allclose(speeds[wall], expected, atol=2e-3)
        assert not speeds[~wall].any()
        fixed = moving.frame.xyz[:, 0] < 0
        np.testing.assert_allclose(moving.frame.channel("velocities")[fixed], [[-1.0, 0, 0]] * fixed.sum(), atol=1e-4)


@pytest.mark.parametrize("frame_of_reference", ["SENSOR", "WORLD"])
def test_points_are_in_the_frame_of_reference_that_the_prim_asks_for(frame_of_reference):
    with weightless() as app:
        add_box(app, "/World/Room", 20.0, (3, 0, 0))
        product = add_lidar(app, position=(1, 2, 0), config=rotary(4, output_frame_of_reference=frame_of_reference))
        UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Lidar")).SetRotate(Gf.Vec3f(0, 0, 90))

        [frame] = frames_of(app, product, 6)

        in_sensor = [[8, 0, 0], [0, -12, 0], [-12, 0, 0], [0, 8, 0]]  # forward is the world's +y
        in_world = [[1, 10, 0], [13, 2, 0], [1, -10, 0], [-7, 2, 0]]
        np.testing.assert_allclose(frame.xyz, in_world if frame_of_reference == "WORLD" else in_sensor, atol=1e-5)
        if frame_of_reference == "WORLD":
            np.testing.assert_allclose(frame.channel("distance"), np.linalg.norm(in_world, axis=1), rtol=1e-6)


def test_emitter_offsets_move_the_ray_and_the_points_are_where_it_hit():
    state = EmitterState(azimuth_deg=[0.0], elevation_deg=[0.0], vert_offset_m=[0.5], hor_offset_m=[0.25])
    config = rotary(4, emitter_states=(state,))
    with weightless() as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        product = add_lidar(app, config=config)

        [frame] = frames_of(app, product, 6)

        np.testing.assert_allclose(
            frame.xyz, [[10, 0.25, 0.5], [0.25, -10, 0.5], [-10, -0.25, 0.5], [-0.25, 10, 0.5]], atol=1e-5
        )
        np.testing.assert_allclose(frame.channel("distance"), np.sqrt(100 + 0.0625 + 0.25), atol=1e-5)


def test_near_and_far_gates_drop_returns_unless_invalid_points_are_kept():
    def frame_with(**fields):
        with weightless() as app:
            add_box(app, "/World/Near", 0.1, (1, 0, 0))
            add_box(app, "/World/Good", 0.1, (0, -2, 0))
            add_box(app, "/World/Far", 0.1, (-9, 0, 0))
            product = add_lidar(app, config=rotary(4, near_range_m=1.5, far_range_m=5.0, **fields))
            return frames_of(app, product, 6)[0]

    dropped, kept = frame_with(), frame_with(skip_dropping_invalid_points=True)

    assert dropped.channel("tickId").tolist() == [1]
    assert dropped.channel("distance")[0] == pytest.approx(1.95)
    assert kept.count == 4
    assert kept.channel("flags").tolist() == [0, 64, 0, 0]
    assert kept.channel("distance").tolist() == [0.0, dropped.channel("distance")[0], 0.0, 0.0]


def test_an_unbounded_plane_reaches_as_far_as_the_sensor():
    with weightless() as app:
        UsdGeom.Plane.Define(app.stage, "/World/Ground")
        product = add_lidar(app, position=(0, 0, 1), config=rotary(8, elevations=(-0.3, -0.2), min_reflectance=1e-4))

        [frame] = frames_of(app, product, 6)

        assert set(frame.channel("emitterId").tolist()) == {0}  # 1 / sin(0.2 deg) = 286 m, beyond 200 m
        np.testing.assert_allclose(frame.channel("distance"), 1 / np.sin(np.deg2rad(0.3)), atol=1e-3)


def test_a_lidar_never_hits_what_it_excludes():
    with weightless() as app:
        add_box(app, "/World/Mount", 1.0, (0, 0, 0))
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        prim = app.stage.DefinePrim("/World/Lidar", "OmniLidar")
        prim.CreateRelationship("tickgraph:exclude").SetTargets(["/World/Mount"])
        product = add_lidar(app, config=rotary(4))

        [frame] = frames_of(app, product, 6)

        np.testing.assert_allclose(frame.channel("distance"), 10.0, atol=1e-5)


@pytest.mark.parametrize("unit", [1.0, 0.01])
def test_sensors_work_in_metres_whatever_the_stages_unit(unit):
    with weightless() as app:
        UsdGeom.SetStageMetersPerUnit(app.stage, unit)
        stage = app.stage
        scaled = App(stage, physics_hz=240, loop_hz=60)
        add_box(scaled, "/World/Room", 20.0 / unit, (1.0 / unit, 0, 0))
        product = add_lidar(scaled, position=(2.0 / unit, 0, 0), config=rotary(4), channels={"distance"})

        [frame] = frames_of(scaled, product, 6)

        np.testing.assert_allclose(frame.channel("distance"), [9.0, np.sqrt(100.0), 11.0, 10.0], atol=1e-5)
        np.testing.assert_allclose(frame.end.position_m, [2.0, 0, 0], atol=1e-9)
        scaled.close()


def scene_with(app, numbers):
    add_box(app, "/World/Room", 40.0, (0, 0, 0))
    for i in range(6):
        add_box(
            app, f"/World/B{i}", 1.0, (5 * np.cos(i), 5 * np.sin(i), 0), velocity=(0.3, -0.2, 0.1), spin=(20, 30, 40)
        )
    return [
        add_lidar(app, f"/World/Lidar{i}", (0.3 * i, 0.1 * i, 0), rotary(200, elevations=(-5.0, 0.0, 5.0)))
        for i in numbers
    ]


def bytes_of(numbers, threads=0, motion="frozen"):
    """What lidars of these numbers (each at a place of its own) measure together in half a second, by number."""
    with weightless(lidar_motion=motion, settings={"/tickgraph/rayThreads": threads}) as app:
        products = dict(zip(numbers, scene_with(app, numbers), strict=True))
        found = {number: [] for number in numbers}
        app.play()
        for _ in range(30):
            app.update()
            for number, product in products.items():
                if product.new_frame:
                    arrays = sorted(product.frame.arrays.items())
                    found[number].append({name: array.tobytes() for name, array in arrays})
        assert all(len(frames) == 5 for frames in found.values())
        return found


@pytest.mark.parametrize("motion", ["frozen", "update", "continuous"])
def test_a_sensors_bytes_depend_on_no_other_sensor_and_no_thread_count(motion):
    [first], [last] = bytes_of([0], threads=1, motion=motion).values(), bytes_of([49], motion=motion).values()

    assert bytes_of([0], threads=2, motion=motion)[0] == first
    ten = bytes_of(range(10), motion=motion)
    for numbers in (range(3), range(50)):
        found = bytes_of(numbers, motion=motion)
        assert found[0] == first
        assert all(found[number] == ten[number] for number in range(min(len(numbers), 10)))
    assert found[49] == last
    assert len({frames[0]["distance"] for frames in found.values()}) == 50


@pytest.mark.parametrize("motion", ["frozen", "update", "continuous"])
def test_an_app_that_is_done_takes_its_scenes_along(motion):
    gc.collect()
    before = alive()
    with weightless(lidar_motion=motion) as app:
        scene_with(app, range(2))
        app.play()
        app.update(steps=6)
        assert alive() > before
    del app
    gc.collect()

    assert alive() == before


def test_play_after_stop_gives_the_bytes_of_the_first_play():
    with weightless() as app:
        lidar = Lidar.create("/World/Lidar", config="RPLIDAR_S2E", translations=[0, 0, 0], app=app)
        sensor = LidarSensor(lidar, annotators=["generic-model-output"])
        add_box(app, "/World/Box", 1.0, (3, 0, 0), velocity=(0, 1, 0))

        def run():
            app.play()
            app.update(steps=30)
            data, info = sensor.get_data("generic-model-output")
            app.stop()
            assert info == {}
            return data.tobytes()

        assert run() == run()


def test_only_requested_channels_are_computed():
    with weightless() as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        product = add_lidar(app, channels={"xyz"})
        frames_of(app, product, 6)
        assert product.frame.arrays.keys() == {"xyz"}

        product.sensor.require("second", {"scalar"})
        app.update(steps=6)
        assert product.frame.arrays.keys() == {"xyz", "scalar"}

        product.sensor.release("test")
        app.update(steps=6)
        assert product.frame.arrays.keys() == {"scalar"}
        assert product.sensor.demand.consumers() == {"scalar": ["second"]}


def test_channels_above_the_aux_level_stay_empty_with_a_warning():
    with weightless() as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        product = add_lidar(app, channels={"xyz", "emitterId"}, level="NONE")
        frames_of(app, product, 6)

        assert len(product.frame.channel("emitterId")) == 0
        assert app.warnings.codes() == ["aux-level-too-low"]
        product.sensor.require("another", {"xyz"})
        assert [warning.count for warning in app.warnings] == [1]  # a request for other channels gives no warning
        product.sensor.require("ring", {"channelId"}, ignore_aux=True)
        app.update(steps=6)
        assert len(product.frame.channel("channelId")) == 360


def test_normals_need_the_setting_that_publishes_them():
    with weightless(settings={NORMALS: False}) as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        product = add_lidar(app, channels={"xyz", "hitNormals"})
        frames_of(app, product, 6)

        assert len(product.frame.channel("hitNormals")) == 0
        assert app.warnings.codes() == ["normals-off"]


def test_object_ids_name_what_was_hit_when_stable_ids_are_on():
    with weightless(settings={"/rtx-transient/stableIds/enabled": True}) as app:
        add_box(app, "/World/Front", 2.0, (5, 0, 0))
        add_box(app, "/World/Back", 2.0, (-5, 0, 0), velocity=(0, 0, 0))
        lidar = Lidar.create("/World/Lidar", config="RPLIDAR_S2E", aux_output_level="EXTRA", app=app)
        sensor = LidarSensor(lidar, annotators=["generic-model-output", "stable-id-map"])

        app.play()
        app.update(steps=6)
        gmo = parse_generic_model_output_data(sensor.get_data("generic-model-output")[0])
        paths = parse_stable_id_map_data(sensor.get_data("stable-id-map")[0])

        named = [paths[number] for number in parse_object_ids(gmo.objId)]
        assert set(paths.values()) == {"/World/Front", "/World/Back"}
        assert named == ["/World/Front" if abs(azimuth) < 90 else "/World/Back" for azimuth in gmo.x]
        assert sensor.runtime.object_ids() == paths
        assert app.warnings.codes() == []


def test_without_stable_ids_object_ids_are_empty_and_one_warning_says_so():
    with weightless() as app:
        add_box(app, "/World/Front", 2.0, (5, 0, 0))
        product = add_lidar(app, channels={"objId", "xyz"})

        frames_of(app, product, 12)

        assert len(product.frame.channel("objId")) == 0
        assert app.warnings.codes() == ["stable-ids-off"]


def test_what_is_authored_before_play_counts_even_after_the_product_was_made():
    with weightless() as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        product = add_lidar(app, channels={"xyz"})
        prim = app.stage.GetPrimAtPath("/World/Lidar")
        prim.GetAttribute("omni:sensor:tickRate").Set(20.0)
        prim.GetAttribute("omni:sensor:Core:scanRateBaseHz").Set(20)

        frames = frames_of(app, product, 60)

        assert [frame.timestamp_ns for frame in frames] == [k * 50_000_000 for k in range(20)]
        assert frames[0].arrays.keys() == {"xyz"}


def test_a_gmo_holds_what_the_sensor_measured():
    with weightless() as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        lidar = Lidar.create(
            "/World/Lidar", config="Example_Rotary_2D", translations=[1, 0, 0], aux_output_level="BASIC", app=app
        )
        sensor = LidarSensor(lidar, annotators="generic-model-output")
        assert sensor.get_data("generic-model-output") == (None, {})

        app.play()
        app.update(steps=6)
        gmo = parse_generic_model_output_data(sensor.get_data("generic-model-output")[0])

        assert (gmo.numElements, gmo.timestampNs, gmo.scanComplete) == (3600, 0, True)
        assert gmo.z[0] == pytest.approx(9.0)
        assert gmo.tickId.tolist() == list(range(3600))
        assert len(gmo.velocities) == 0
        np.testing.assert_allclose(gmo.frameStart.posM, [1, 0, 0])
        between = sensor.get_data("generic-model-output")[0]
        app.update()
        assert sensor.get_data("generic-model-output")[0] is between  # the same buffer until the next tick
