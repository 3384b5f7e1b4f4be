import json
import math
from fractions import Fraction

import pytest

from tests.support.lidar_texts import lidar_graph
from tests.support.without_wing import needs_wing

HEAD = """\
tickgraph: 1
scene:
  prims:
    /World/Ball: {type: Sphere, radius: 0.5, translate: [3, 0, 5], rigid_body: true}
    /World/Lidar: {type: OmniLidar, config: OS1}
"""
ONE = "clock: {physics_hz: 240, loop_hz: 60}\nduration: 5\n" + lidar_graph()


@pytest.fixture
def explain(folder, graph):
    """Explains a file of this text; gives the JSON."""

    def run(text, *arguments):
        (folder / "a.yaml").write_text(text)
        result = graph("explain", "a.yaml", "--json", *arguments)
        assert (result.code, result.err) == (0, "")
        return json.loads(result.out)

    return run


def traps(told):
    return {(trap["code"], trap["where"]): trap["message"] for trap in told["traps"]}


def test_the_text_tells_clocks_sensors_demand_and_topics(folder, graph):
    (folder / "a.yaml").write_text(HEAD + ONE)
    result = graph("explain", "a.yaml")
    assert (result.code, result.err) == (0, "")
    assert (
        result.out
        == """\
a.yaml: 5 s, 300 updates

clocks
  loop      60 Hz
  timeline  moves 1/60 s each update
  physics   240 Hz, 4 steps an update
  substeps  4 4 4 4 4 4 4 4 4 4 4 4  in updates 0 to 11

physics
  engine   mujoco: 1 body
  options  implicitfast, newton of at most 100 iterations, elliptic cones, impratio 10
  error    what falls or swings is ahead by half a step: a falling body by 20.4 mm after 1 s

graphs
  /World/G  execution, simulation: 3 nodes, 3 connections
    chain  longest, 3 nodes: tick -> product -> cloud

/World/Lidar (OmniLidar)
  rates     tick 10 Hz, scan 10 Hz
  rays      32,768 a scan, 327,680 a second at its scan rate
  product   since 0 s, made in update 0 by /World/G/product
  rule      tick = scan rate: whole scans, one a tick
  stamps    0 s (update 5), 0.1 s (update 11), 0.2 s (update 17), ...
  frames    50 in 5 s
  computes  xyz
  for       /World/G/cloud: xyz  (while it has a subscriber)

topics (none has a subscriber in the file: recordings and live transports hear them)
  /points  PointCloud2  /World/G/cloud

left out
  channels  /World/Lidar: azimuth, elevation, distance and 17 more: nothing reads them
  poses     copied only for a sensor that is due: nothing reads them after every physics step
  messages  /points: made only for a recording or a live transport: nothing in the file subscribes

traps: none seen

more: graph help clocks, graph help physics, graph help lidar
"""
    )


def test_a_sensor_behind_a_countdown_begins_with_its_first_whole_scan(explain):
    told = explain(
        """\
tickgraph: 1
scene: {prims: {/World/Lidar: {type: OmniLidar, config: picoScan150}}}
clock: {physics_hz: 240, loop_hz: 60}
duration: 5
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      wait: {type: Countdown, inputs: {duration: 5}}
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
    connections: [tick.tick -> wait.execIn, wait.finished -> product.execIn]
"""
    )
    [lidar] = told["sensors"]
    assert (lidar["tick_rate_hz"], lidar["scan_rate_hz"], lidar["rule"]) == (20, 20, "whole")
    assert (lidar["made_in_update"], lidar["exists_from_s"], lidar["frames"], lidar["missed"]) == (5, "1/12", 98, 0)
    assert lidar["first_ticks"] == [
        {"stamp_ns": 100_000_000, "time_s": "3/20", "update": 8},
        {"stamp_ns": 150_000_000, "time_s": "1/5", "update": 11},
        {"stamp_ns": 200_000_000, "time_s": "1/4", "update": 14},
    ]
    assert set(traps(told)) == {("latent-retriggered", "/World/G/wait"), ("nobody-consumes", "/World/Lidar")}
    assert "sleeps through 10 of its 12 triggers" in traps(told)["latent-retriggered", "/World/G/wait"]


def test_substeps_are_those_of_the_exact_accumulator(explain):
    clocks = explain("tickgraph: 1\nclock: {physics_hz: 100, loop_hz: 60}\n")["clocks"]
    assert clocks["substeps"] == [1, 2, 2] * 4
    assert (clocks["substeps_per_update"], clocks["timeline_step_s"]) == ("5/3", "1/60")


def test_physics_slower_than_the_loop_is_a_trap_and_its_updates_are_counted(explain):
    told = explain("tickgraph: 1\nclock: {physics_hz: 24, loop_hz: 60}\nduration: 1\n")
    assert told["clocks"]["substeps"] == [0, 0, 1, 0, 1, 0, 0, 1, 0, 1, 0, 0]
    assert traps(told)["physics-slower-than-loop", "clock"].startswith("36 of 60 updates run no physics step")


def test_fixed_stepping_faster_than_time_codes_moves_every_second_update(explain):
    settings = {
        "/app/player/useFixedTimeStepping": "true",
        "/app/stage/timeCodesPerSecond": "30",
        "/app/player/targetRunLoopFrequency": "60",
    }
    clocks = explain("tickgraph: 1\n", *(f"--{path}={value}" for path, value in settings.items()))["clocks"]
    assert clocks["substeps"] == [2, 0] * 6
    assert (clocks["timeline_every_updates"], clocks["timeline_step_s"], clocks["timeline_per_loop"]) == (2, "1/30", 1)


def test_a_rate_limit_without_time_codes_is_a_trap(explain):
    limit = "--/app/runLoops/main/rateLimitFrequency=30"
    fixed = "--/app/player/useFixedTimeStepping=true"
    [(place, message)] = traps(explain("tickgraph: 1\n", limit, fixed)).items()
    assert place == ("rate-limit-alone", "/app/runLoops/main/rateLimitFrequency")
    assert "0.5 x wall time" in message
    [(place, message)] = traps(explain("tickgraph: 1\n", limit)).items()
    assert place == ("rate-limit-alone", "/app/runLoops/main/rateLimitFrequency")
    assert message.startswith("an update moves by 1/60 s whatever the limit is: at 30 Hz time runs at 0.5 x wall time")
    assert traps(explain(clocked("loop_hz: 30"), limit)) == {}
    assert ("rate-limit-alone", place[1]) not in traps(
        explain("tickgraph: 1\n", limit, fixed, "--/app/stage/timeCodesPerSecond=30")
    )


def test_the_catch_up_cap_is_a_trap_where_it_holds_steps_back(explain):
    capped = traps(
        explain("tickgraph: 1\nduration: 1\nclock: {loop_hz: 20}\n", "--/persistent/simulation/minFrameRate=30")
    )
    assert capped["catch-up-cap", "/persistent/simulation/minFrameRate"].startswith("20 of 20 updates")
    assert traps(explain("tickgraph: 1\nduration: 1\n", "--/persistent/simulation/minFrameRate=30")) == {}


SENSORS = """\
tickgraph: 1
scene:
  prims:
    /World/Whole: {type: OmniLidar, config: OS1}
    /World/Fast:
      type: OmniLidar
      config: OS1
      attributes: {"omni:sensor:tickRate": 100, "omni:sensor:Core:scanRateBaseHz": 100}
    /World/Partial: {type: OmniLidar, config: OS1, attributes: {"omni:sensor:tickRate": 7}}
    /World/Auto: {type: OmniLidar, config: OS1, attributes: {"omni:sensor:tickRate": 0}}
    /World/Idle: {type: OmniLidar, config: OS1}
    /World/Camera: {type: Camera}
duration: 1.3
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      whole: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Whole}}
      fast: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Fast}}
      wait: {type: Countdown, inputs: {duration: 3}}
      partial: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Partial}}
      auto: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Auto}}
    connections:
      - tick.tick -> [whole.execIn, fast.execIn, wait.execIn, auto.execIn]
      - wait.finished -> partial.execIn
"""


def test_each_sensor_is_reported_with_its_rule_and_the_unused_ones_last(explain):
    told = explain(SENSORS)
    assert [(sensor["path"], sensor.get("rule")) for sensor in told["sensors"]] == [
        ("/World/Whole", "whole"),
        ("/World/Fast", "whole"),
        ("/World/Partial", "partial"),
        ("/World/Auto", "every update"),
        ("/World/Idle", None),
        ("/World/Camera", None),
    ]
    assert [sensor["product"] for sensor in told["sensors"][4:]] == [None, None]
    fast = told["sensors"][1]
    assert (fast["frames"], fast["missed"]) == (78, 52)
    assert traps(told)["sensor-faster-than-loop", "/World/Fast"].startswith("52 of 130 ticks are passed over")
    assert {where for code, where in traps(told) if code == "lidar-partial-scan"} == {"/World/Partial", "/World/Auto"}


@pytest.mark.parametrize(
    "options",
    [
        (),
        ("clock: {physics_hz: 100, loop_hz: 60}",),
        ("clock: {physics_hz: 24, loop_hz: 60}",),
        ("clock: {physics_hz: 1000, loop_hz: 30000/1001}",),
        ("settings: {/rtx/hydra/supportMultiTickRate: false}",),
        ("settings: {/app/player/useFixedTimeStepping: true, /app/stage/timeCodesPerSecond: 24}",),
        ("settings: {/persistent/simulation/minFrameRate: 30}", "clock: {physics_hz: 60, loop_hz: 20}"),
        ("settings: {/tickgraph/warmUpSteps: 2}",),
        ("settings: {/app/player/playSimulations: false}",),
        ("clock: {physics_hz: 240, loop_hz: 60, parity: isaacsim-6.0.1}",),
        ("clock: {physics_hz: 60, loop_hz: 60, experience: zero_delay, parity: isaacsim-6.0.1}",),
    ],
)
def test_the_explanation_is_what_a_run_does(options, folder, graph, explain):
    told = explain("\n".join((SENSORS.rstrip(), *options)) + "\n")
    ran = json.loads(graph("run", "a.yaml", "--json").out)
    planned = {
        sensor["path"]: (sensor["frames"], sensor["missed"], (sensor["first_ticks"] or [{}])[0].get("stamp_ns"))
        for sensor in told["sensors"]
        if sensor["product"]
    }
    assert planned == {
        path: (sensor["frames"], sensor["missed"], sensor["first_frame_ns"]) for path, sensor in ran["sensors"].items()
    }
    assert told["updates"] == ran["updates"]


CLOCK = """\
tickgraph: 1
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      read: ReadTime
      later: {type: omni.graph.nodes.Add, inputs: {a: 1.0, b: 1.0}}
      clock: ROS2PublishClock
    connections:
"""
NODES = """\
tickgraph: 1
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      first: {type: Countdown, inputs: {duration: 0}}
      second: {type: Countdown, inputs: {period: 1}}
    connections:
"""


def test_timeline_time_is_found_behind_arithmetic(explain):
    told = explain(
        CLOCK
        + "      - tick.tick -> clock.execIn\n"
        + "      - read.time -> later.a\n      - later.sum -> clock.timeStamp\n"
    )
    assert set(traps(told)) == {("timeline-stamp", "/World/G/clock.inputs:timeStamp")}
    assert "gets read.time" in traps(told)["timeline-stamp", "/World/G/clock.inputs:timeStamp"]


def test_simulation_time_is_not_a_trap(explain):
    text = CLOCK.replace("read: ReadTime", "read: IsaacReadSimulationTime")
    assert (
        traps(explain(text + "      - tick.tick -> clock.execIn\n      - read.simulationTime -> clock.timeStamp\n"))
        == {}
    )


@pytest.mark.parametrize(
    ("order", "what"),
    [
        ("first.execIn, second.execIn", "in the same update only"),
        ("second.execIn, first.execIn", "of the update before"),
    ],
)
def test_nodes_of_one_output_that_exchange_data_depend_on_their_order(order, what, explain):
    told = explain(NODES + f"      - tick.tick -> [{order}]\n      - first.tickValue -> second.duration\n")
    message = traps(told)["fan-out-order", "/World/G/tick.outputs:tick"]
    assert message.startswith("first.tickValue -> second.duration: second reads")
    assert what in message


def test_a_chain_does_not_depend_on_an_order(explain):
    told = explain(
        NODES
        + "      - tick.tick -> first.execIn\n"
        + "      - first.finished -> second.execIn\n"
        + "      - first.tickValue -> second.duration\n"
    )
    assert "fan-out-order" not in {code for code, _ in traps(told)}


def test_a_product_that_comes_too_late_is_reported(explain):
    told = explain(SENSORS.replace("duration: 3", "duration: 1000"))
    assert [sensor["path"] for sensor in told["sensors"] if sensor["product"]] == [
        "/World/Whole",
        "/World/Fast",
        "/World/Auto",
    ]
    assert "no render product in the first 120 updates" in traps(told)["product-not-made", "/World/G/partial"]


def test_deprecated_inputs_are_traps(explain):
    told = explain(HEAD + ONE.replace("topicName: points", "topicName: points, fullScan: false"))
    assert set(traps(told)) == {("full-scan-deprecated", "/World/G/cloud")}


def test_publishers_that_wait_for_a_frame_are_among_the_topics(explain):
    text = (
        HEAD
        + ONE
        + "  /World/Post:\n    pipeline_stage: post_render\n"
        + "    nodes: {scan: {type: ROS2PublishLaserScan, inputs: {topicName: late}}}\n"
    )
    assert explain(text)["topics"] == [
        {
            "topic": "/points",
            "type": "sensor_msgs/msg/PointCloud2",
            "publishers": ["/World/G/cloud"],
            "heard_in_file": False,
        },
        {
            "topic": "/late",
            "type": "sensor_msgs/msg/LaserScan",
            "publishers": ["/World/Post/scan"],
            "heard_in_file": False,
        },
    ]


def test_a_wrong_file_gives_its_problems_and_exit_code_2(folder, graph):
    (folder / "a.yaml").write_text("tickgraph: 1\nclock: {loop_hz: 0}\n")
    result = graph("explain", "a.yaml")
    assert (result.code, result.out) == (2, "")
    assert result.err.startswith("a.yaml:2:")


def test_rates_are_printed_exactly():
    from graph.base.exact import shortest

    assert [shortest(Fraction(*pair)) for pair in ((60, 1), (59, 2), (1, 60), (60000, 1001))] == [
        "60",
        "29.5",
        "1/60",
        "60000/1001",
    ]


def test_a_long_run_is_counted_only_through_its_first_updates(folder, graph):
    (folder / "a.yaml").write_text(HEAD + ONE.replace("duration: 5", "duration: 100000"))
    out = graph("explain", "a.yaml").out
    assert out.startswith("a.yaml: 100000 s, 6,000,000 updates\n")
    assert "  frames    16,666 in the first 100,000 updates\n" in out


def test_a_node_that_fails_is_a_trap_and_the_rest_is_reported_all_the_same(folder, graph):
    bad = ONE.replace("inputs: {cameraPrim: /World/Lidar}", "inputs: {renderProductPrim: /Render/None}")
    (folder / "a.yaml").write_text(HEAD + bad.replace("duration: 5", "duration: 1"))
    result = graph("explain", "a.yaml")
    assert result.code == 0
    assert "compute-failed: /World/G/product: there is no render product /Render/None" in result.out
    assert "  product  none: nobody renders it\n" in result.out


CLOCKED = ONE.replace("clock: {physics_hz: 240, loop_hz: 60}", "clock: {CLOCK}")


def clocked(clock):
    return HEAD + CLOCKED.replace("CLOCK", clock)


def test_the_product_s_profile_tells_its_warm_up_cap_and_late_frames(folder, graph, explain):
    told = explain(clocked("physics_hz: 60, parity: isaacsim-6.0.1"))
    clocks = told["clocks"]
    assert (clocks["parity"], clocks["warm_up_steps"], clocks["most_substeps"]) == ("isaacsim-6.0.1", 2, 2)
    assert clocks["frames_later"] is True
    (sensor,) = told["sensors"]
    # physics begins at 2/60 s: 0.1 to 0.2 s is the first whole scan, complete at step 12, in update 9
    assert [(tick["stamp_ns"], tick["update"]) for tick in sensor["first_ticks"][:1]] == [(100_000_000, 9)]
    text = graph("explain", "a.yaml").out
    assert "  cap       at most 2 steps an update (minFrameRate)\n" in text
    assert "  warm-up   2 steps at play: physics stays 1/30 s ahead of the timeline\n" in text
    assert "  frames    are delivered in the update after the one that renders them\n" in text


@pytest.mark.parametrize(
    ("clock", "options", "speed", "code"),
    [
        ("loop_hz: 30, experience: full", [], "1/2", "slow-motion"),
        ("loop_hz: 100, experience: full", [], "5/6", "slow-motion"),
        ("loop_hz: 240, experience: full", ["--/app/player/useFastMode=true"], 4, None),
        ("loop_hz: 120, experience: full", [], 1, None),
        ("loop_hz: 10", ["--/persistent/simulation/minFrameRate=30"], "1/3", "catch-up-cap"),
        ("loop_hz: 60", ["--/app/player/playSimulations=false"], 0, None),
    ],
)
def test_the_ratio_to_wall_time_is_reported_and_slow_motion_is_a_trap(
    folder, graph, explain, clock, options, speed, code
):
    told = explain(clocked(clock), *options)
    assert told["clocks"]["sim_per_wall"] == speed
    found = {"slow-motion", "fast-forward", "catch-up-cap", "rate-limit-alone"} & {name for name, _ in traps(told)}
    assert found == ({code} if code else set())
    assert ("x wall time" in graph("explain", "a.yaml", *options).out.partition("traps")[0]) == (speed != 1)


def test_a_rate_limit_that_play_overwrites_is_a_trap(explain):
    told = explain(clocked("experience: full, parity: isaacsim-6.0.1"), "--/app/runLoops/main/rateLimitFrequency=45")
    assert "replaced 45 Hz" in traps(told)["rate-limit-overwritten", "/app/runLoops/main/rateLimitFrequency"]


def test_a_loop_rate_that_play_overwrites_is_a_trap(explain):
    told = explain(clocked("loop_hz: 30, experience: full, parity: isaacsim-6.0.1"))
    message = traps(told)["rate-limit-overwritten", "/app/runLoops/main/rateLimitFrequency"]
    assert "replaced 30 Hz by N x timeCodesPerSecond = 60 Hz" in message


def test_physics_switched_off_is_a_trap(explain):
    told = explain(clocked("loop_hz: 60"), "--/app/player/playSimulations=false")
    assert set(traps(told)) == {("physics-off", "/app/player/playSimulations")}


@pytest.mark.parametrize(("end", "duration", "times"), [(24, 5, 4), (24, 4.5, 4), (120, 5, None), (100, 5, 1)])
def test_a_scene_that_ends_before_the_run_does_is_a_trap(folder, explain, end, duration, times):
    """24 time codes a second: the end is at end / 24 s, and a run of whole ends stands at the last."""
    (folder / "s.usda").write_text(f"#usda 1.0\n(\n    timeCodesPerSecond = 24\n    endTimeCode = {end}\n)\n")
    told = explain(f"tickgraph: 1\nscene: {{usd: s.usda}}\nduration: {duration}\n")
    found = {code: message for (code, _), message in traps(told).items()}
    assert set(found) == ({"timeline-loops"} if times else set())
    if times:
        assert f"starts again at 0 s, {times} times in this run" in found["timeline-loops"]


def test_the_explanation_without_multi_tick_rendering(folder, graph, explain):
    told = explain(clocked("physics_hz: 60"), "--/rtx/hydra/supportMultiTickRate=false")
    assert told["clocks"]["multi_tick"] is False
    assert "multi-tick rendering is off" in graph("explain", "a.yaml", "--/rtx/hydra/supportMultiTickRate=false").out


def test_a_publisher_without_a_time_is_a_trap(explain):
    text = """\
tickgraph: 1
scene: {prims: {/World/Box: {type: Cube}}}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      bare: {type: ROS2PublishTransformTree, inputs: {targetPrims: [/World/Box]}}
      clock: ROS2PublishClock
    connections:
      - tick.tick -> [bare.execIn, clock.execIn]
      - time.simulationTime -> clock.timeStamp
"""
    traps = {(trap["code"], trap["where"]) for trap in explain(text)["traps"]}
    assert traps == {("timestamp-unconnected", "/World/G/bare.inputs:timeStamp")}


def test_a_publisher_with_the_time_of_its_reading_is_no_trap(explain):
    text = """\
tickgraph: 1
scene: {prims: {/World/Box: {type: Cube, rigid_body: true}}}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      joints: {type: IsaacReadJointState, inputs: {prim: /World/Box}}
      states: {type: ROS2PublishJointState, inputs: {jointNames: [a]}}
    connections:
      - tick.tick -> joints.execIn
      - joints.execOut -> states.execIn
      - joints.sensorTime -> states.sensorTime
"""
    assert "timestamp-unconnected" not in {trap["code"] for trap in explain(text)["traps"]}


def test_knobs_and_inputs_are_overridden_as_in_a_run(explain, folder, graph):
    assert explain(HEAD + ONE)["clocks"]["physics_hz"] == 240
    told = explain(HEAD + ONE, "--fidelity", "physics.hz=120", "--set", "cloud.topicName=other")
    assert told["clocks"]["physics_hz"] == 120
    assert [topic["topic"] for topic in told["topics"]] == ["/other"]
    for wrong, said in (("--fidelity", "KEY=VALUE"), ("--set", "NODE.ATTR=VALUE")):
        result = graph("explain", "a.yaml", wrong, "x")
        assert (result.code, result.out, result.err) == (2, "", f"graph: {wrong} x: write it as {said}\n")


@pytest.mark.parametrize(("noise", "said"), [("off", "not added: lidar.noise is off"), ("on", "added to ranges")])
def test_the_text_says_whether_a_constant_offset_of_ranges_is_added(folder, graph, noise, said):
    (folder / "a.yaml").write_text(
        HEAD.replace("OS1}", 'OS1, attributes: {"omni:sensor:Core:rangeOffsetM": 0.5}}') + ONE
    )
    result = graph("explain", "a.yaml", "--fidelity", f"lidar.noise={noise}")
    assert (result.code, result.err) == (0, "")
    [line] = [line for line in result.out.splitlines() if "rangeOffsetM" in line]
    assert "0.5 m, " + said in line


ANGLES = (0, 2 * math.pi / 3, 4 * math.pi / 3)
KIWI = {
    "wheelRadius": [0.1],
    "wheelPositions": [[0.5 * math.cos(a), 0.5 * math.sin(a), 0] for a in ANGLES],
    "wheelOrientations": [[math.cos(a / 2), 0, 0, math.sin(a / 2)] for a in ANGLES],
    "mecanumAngles": [90],
}
MECANUM = {
    "wheelRadius": [0.1],
    "wheelPositions": [[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]],
    "wheelOrientations": [[1, 0, 0, 0]] * 4,
    "wheelAxis": [0, 1, 0],
    "mecanumAngles": [-135, -45, -45, -135],
}


@needs_wing("robots")
@pytest.mark.parametrize(
    ("robot", "told"),
    [
        # d = 0.5 m: a wheel turns the body by (r x speed) / d, and each gets d / (n d^2 r): 1 / (3 x 0.25) = 1.333.
        (KIWI, "at 0.667 of inputVelocity along x, 0.667 along y, and turns at 1.333 of it"),
        # s = sqrt(1/2): a wheel gets 1 / (4 s r) and rolls by r x speed: 0.354. Its arm is 2 s: s / (4 x 2) = 0.088.
        (MECANUM, "at 0.354 of inputVelocity along x, 0.354 along y, and turns at 0.088 of it"),
        (KIWI | {"linearGain": 1.5, "angularGain": 0.75}, None),
    ],
)
def test_the_speeds_that_a_holonomic_robot_has_are_told(robot, told, explain):
    node = json.dumps({"type": "HolonomicController", "inputs": {**robot, "inputVelocity": [0.1, 0, 0]}})
    wires = "nodes: {tick: OnPlaybackTick, drive: " + node + "}, connections: [tick.tick -> drive.execIn]"
    found = traps(explain("tickgraph: 1\ngraphs: {/G: {" + wires + "}}\n")).get(("holonomic-factors", "/G/drive"))
    assert (found is None) if told is None else (found is not None and told in found)
