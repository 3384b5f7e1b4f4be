"""What `graph run` says of its clocks: profiles by the file's key, the measured speed on both wall clocks."""

from __future__ import annotations

import json

import pytest

FILE = """\
tickgraph: 1
scene:
  prims:
    /World/Lidar: {{type: OmniLidar, config: Example_Rotary_2D}}
    /World/Wall: {{type: Cube, size: 2.0, translate: [5, 0, 0]}}
clock: {{{clock}}}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      clock: ROS2PublishClock
    connections:
      - tick.tick -> clock.execIn
      - time.simulationTime -> clock.timeStamp
"""


@pytest.fixture
def run(folder, graph):
    """Runs a file with this clock; gives its report."""

    def run(clock, *options):
        (folder / "a.yaml").write_text(FILE.format(clock=clock))
        result = graph("run", "a.yaml", "--json", *options)
        assert result.code == 0, result.err
        return json.loads(result.out)

    return run


@pytest.mark.parametrize(
    ("clock", "options", "speed"),
    [
        ("loop_hz: 60", [], 1),
        ("loop_hz: 30, experience: full", [], 0.5),
        ("loop_hz: 120, experience: full", [], 1),
        ("loop_hz: 240, experience: full", ["--/app/player/useFastMode=true"], 4),
        ("physics_hz: 60, loop_hz: 10, parity: isaacsim-6.0.1", [], 0.333333),
    ],
)
def test_the_report_holds_the_speed_on_the_virtual_wall_clock(run, clock, options, speed):
    report = run(clock, "--updates", "120", *options)
    assert report["wall_clock"] == {"kind": "virtual", "sim_per_wall": speed}
    assert report["real_time_factor"] > 0
    assert report["topics"]["/clock"]["messages"] == 120


def test_the_report_holds_the_speed_on_the_real_wall_clock(run):
    report = run(
        "loop_hz: 100, physics_hz: 200, experience: full",
        "--/app/stage/timeCodesPerSecond=200",
        "--updates",
        "61",
        "--realtime",
    )
    assert report["wall_clock"]["kind"] == "real"
    assert 0.1 < report["wall_clock"]["sim_per_wall"] <= 0.53  # slow motion by half; a busy machine is slower
    assert report["real_time_factor"] <= 0.53


def test_slow_motion_is_in_the_table_of_a_run(folder, graph):
    (folder / "a.yaml").write_text(FILE.format(clock="loop_hz: 30, experience: full"))
    assert "0.5 x on the virtual wall clock" in graph("run", "a.yaml", "--updates", "30").out


@pytest.mark.parametrize(("parity", "steps"), [("documented", 60), ("isaacsim-6.0.1", 62)])
def test_the_profile_is_a_key_of_the_file_and_each_difference_an_option(run, parity, steps):
    assert run(f"parity: {parity}", "--updates", "60")["physics_steps"] == steps
    assert run(f"parity: {parity}", "--updates", "60", "--/tickgraph/warmUpSteps=5")["physics_steps"] == 65


def test_a_misspelt_difference_is_reported(folder, graph):
    (folder / "a.yaml").write_text(FILE.format(clock="parity: isaacsim-6.0.1"))
    result = graph("run", "a.yaml", "--updates", "1", "--/tickgraph/warmUpStep=5")
    assert 'did you mean "/tickgraph/warmUpSteps"?' in result.err


def test_a_setting_of_the_command_line_that_nothing_reads_is_a_warning(graph, folder):
    (folder / "g.yaml").write_text("tickgraph: 1\n")
    done = graph("run", "g.yaml", "--updates", "1", "--/app/nope=3", "--/app/player/useFastMode=false")
    assert [line for line in done.err.splitlines() if "setting-" in line] == [
        "warning setting-unread: /app/nope: nothing in this run read it; correct it, or leave it out"
    ]
