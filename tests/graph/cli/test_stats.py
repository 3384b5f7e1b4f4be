import json

import pytest

from tests.support.lidar_texts import lidar_graph

SCENE = """\
tickgraph: 1
scene:
  prims:
    /World/Ball: {type: Sphere, radius: 0.5, translate: [3, 0, 5], rigid_body: true}
    /World/Lidar: {type: OmniLidar, config: OS1}
"""
CLOCK = """\
graphs:
  /World/G:
    nodes: {tick: OnPlaybackTick, time: IsaacReadSimulationTime, clock: ROS2PublishClock}
    connections: [tick.tick -> clock.execIn, time.simulationTime -> clock.timeStamp]
"""


@pytest.fixture
def report(folder, graph):
    """Runs a file of this text for 0.2 s; gives the report on stdout."""

    def run(text, *arguments):
        (folder / "a.yaml").write_text(text)
        result = graph("run", "a.yaml", "--duration", "0.2", "--json", *arguments)
        assert result.code == 0, result.err
        return json.loads(result.out)

    return run


def test_the_parts_of_a_run_exclude_each_other_and_fit_into_its_time(report):
    told = report(SCENE + lidar_graph(), "--stats", "--out", "out")
    stats = told["stats"]
    assert set(stats) >= {"physics", "builds", "casts", "post", "graph", "io"}
    assert 0 < sum(cost["wall_s"] for cost in stats.values()) <= told["wall_time_s"]
    assert all(cost["cpu_s"] >= 0 for cost in stats.values())


def test_a_part_that_nothing_requires_is_not_in_the_statistics(report):
    stats = report(SCENE + CLOCK, "--stats")["stats"]
    assert {"physics", "graph"} <= set(stats)
    assert not {"builds", "casts", "io"} & set(stats)


def test_without_stats_nothing_is_measured(report):
    assert "stats" not in report(SCENE + CLOCK)


def test_the_table_names_each_part_and_what_it_is(folder, graph):
    (folder / "a.yaml").write_text(SCENE + lidar_graph())
    out = graph("run", "a.yaml", "--duration", "0.2", "--stats").out
    assert [line.split()[0] for line in out.splitlines() if "%" in line][:3] == ["physics", "builds", "casts"]
    assert "geometry and acceleration structures for rays" in out
