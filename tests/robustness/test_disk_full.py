"""A disk that fills: the recording opens, the report is whole, the message says what was kept and what was lost.

    pytest tests/robustness/test_disk_full.py --disks 60

The disk is a tmpfs of its own, mounted in a user namespace; where the system allows none, the test is skipped.
"""

import json
import random
import re
import shutil
import sys

import pytest
from mcap.reader import make_reader

from tests.support.disks import in_a_disk

GRAPH = """
tickgraph: 1
scene:
  prims:
    /World/Wall: {type: Cube, size: 2.0, translate: [6, 0, 1]}
    /World/Ground: {type: Plane}
    /World/Lidar: {type: OmniLidar, config: OS1, translate: [0, 0, 1]}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      clock: ROS2PublishClock
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      cloud: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud, topicName: points}}
    connections:
      - tick.tick -> [clock.execIn, product.execIn]
      - time.simulationTime -> clock.timeStamp
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath
"""


@pytest.fixture
def disks(tmp_path):
    if shutil.which("unshare") is None or in_a_disk(1 << 20, tmp_path / "disk", "true").returncode:
        pytest.skip("no user namespace with a tmpfs on this system")


def pytest_generate_tests(metafunc):
    if "size" in metafunc.fixturenames:
        config = metafunc.config
        draw = random.Random(config.getoption("--seed", default=0))
        pages = range(150, 1000)  # of 4 kB: 0.6 to 4.1 MB, where the whole run takes 4.3 MB
        metafunc.parametrize("size", [4096 * draw.choice(pages) for _ in range(config.getoption("--disks", default=4))])


def test_what_fits_is_a_finished_recording_beside_a_whole_report(tmp_path, disks, size):
    file = tmp_path / "graph.yaml"
    file.write_text(GRAPH)
    disk = tmp_path / "disk"
    run = f"{sys.executable} -m graph run {file} --duration 3 --out {disk}"
    ended = in_a_disk(size, disk, f"{run}; code=$?; cp {disk}/* {tmp_path}; exit $code")
    assert ended.returncode == 1, ended.stderr
    assert "Traceback" not in ended.stderr
    check_what_is_left(tmp_path, ended.stderr)


def test_where_the_recording_leaves_no_page_for_the_report_its_last_chunk_makes_room(tmp_path, disks):
    """A first run says how large the recording is; the disk has a page for each 4096 bytes of it, and no other."""
    file, disk = tmp_path / "graph.yaml", tmp_path / "disk"
    file.write_text(GRAPH)
    run = f"{sys.executable} -m graph run {file} --duration 3 --out {disk}"
    free = in_a_disk(10_000_000, disk, f"{run} >&2; stat -c %s {disk}/run.mcap")
    pages = -(-int(free.stdout) // 4096)
    ended = in_a_disk(4096 * pages, disk, f"{run}; code=$?; cp {disk}/* {tmp_path}; exit $code")
    assert ended.returncode == 1, ended
    check_what_is_left(tmp_path, ended.stderr)


def check_what_is_left(tmp_path, stderr):
    """The recording opens and holds as many messages as the one line of `stderr` says; the report is whole."""
    lines = [line for line in stderr.splitlines() if "No space left on device" in line]
    assert 1 <= len(lines) <= 2, stderr
    kept = int(re.search(r"(\d+)(?: messages)? are kept", lines[-1])[1])
    with (tmp_path / "run.mcap").open("rb") as recording:
        reader = make_reader(recording, validate_crcs=True)
        summary = reader.get_summary()
        assert summary.statistics.message_count == sum(1 for _ in reader.iter_messages())
    assert summary.statistics.message_count == kept
    assert summary.statistics.message_count > 0
    assert json.loads((tmp_path / "report.json").read_text())["updates"] > 0


def test_a_conversion_that_finds_no_room_leaves_nothing(tmp_path, disks):
    file = tmp_path / "graph.yaml"
    nodes = "".join(f"      n{one}: {{type: Countdown, inputs: {{duration: {one}}}}}\n" for one in range(1, 2000))
    file.write_text(f"tickgraph: 1\ngraphs:\n  /World/G:\n    nodes:\n{nodes}")
    for name in ("a.json", "a.usda", "a.usdc"):
        disk = tmp_path / "disk"
        run = f"{sys.executable} -m graph convert {file} {disk}/{name}"
        ended = in_a_disk(40960, disk, f"{run}; code=$?; ls -A {disk}; exit $code")
        assert (ended.returncode, ended.stdout) == (2, ""), (name, ended)
        assert ended.stderr.count("\n") == 1, ended.stderr
        assert f"{name} cannot be written" in ended.stderr
