"""Data sets of campaigns: `graph export` of a campaign's folder writes every run that ended well."""

from __future__ import annotations

import csv
import json
from collections import Counter

import numpy as np
import pytest

from graph.cli.main import main
from tests.support.without_wing import needs_wing
from wings.exports import nuscenes

pytestmark = needs_wing("campaign")

LIDAR = """\
tickgraph: 1
scene:
  prims:
    /World/Ground: {type: Plane}
    /World/Box: {type: Cube, size: 1.0, translate: [4, 0, 0.5]}
    /World/Lidar: {type: OmniLidar, config: OS0, translate: [0, 0, 1]}
randomize:
  /World/Box.translate: uniform([3, -1, 0.5], [6, 1, 0.5])
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      cloud: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud, topicName: points, frameId: Lidar}}
      frames: {type: ROS2PublishTransformTree, inputs: {targetPrims: [/World/Lidar]}}
    connections:
      - tick.tick -> [product.execIn, frames.execIn]
      - time.simulationTime -> frames.timeStamp
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath
"""


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """Runs of the seeds 0 and 1 that hold two scans each; the one between them fails to start, as its key is wrong."""
    folder = tmp_path_factory.mktemp("data_set")
    (folder / "lidar.yaml").write_text(LIDAR)
    (folder / "points.csv").write_text("seed,/World/Box.size\n0,\n0,wrong\n1,\n")
    options = ["--points", str(folder / "points.csv"), "--updates", "15", "--jobs", "1"]
    assert main(["sweep", str(folder / "lidar.yaml"), *options, "--out", str(folder / "c")]) == 1
    with (folder / "c/campaign.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["status"], row["/points.messages"]) for row in rows] == [("ok", "2"), ("refused", ""), ("ok", "2")]
    return folder / "c", [int(row["/World/Lidar.elements"]) for row in rows if row["status"] == "ok"]


def exported(campaign, form, out, capsys):
    assert main(["export", str(campaign), "--format", form, "--out", str(out)]) == 0
    said = capsys.readouterr()
    assert said.err.strip() == "run 0001 is left out: it is refused"
    assert said.out.strip() == f"wrote 2 runs into {out} ({form})"
    with (out / "runs.csv").open() as stream:
        return list(csv.DictReader(stream))


def test_npz_has_a_folder_for_each_run(campaign, tmp_path, capsys):
    index = exported(campaign[0], "npz", tmp_path / "o", capsys)
    assert index == [
        {
            "place": "0000",
            "run": "0",
            "file": str(campaign[0].parent / "lidar.yaml"),
            "seed": "0",
            "/World/Box.size": "",
        },
        {
            "place": "0002",
            "run": "2",
            "file": str(campaign[0].parent / "lidar.yaml"),
            "seed": "1",
            "/World/Box.size": "",
        },
    ]
    for row, elements in zip(index, campaign[1], strict=True):
        files = sorted((tmp_path / "o" / row["place"] / "points").glob("*.npz"))
        assert len(files) == 2
        scans = [np.load(file) for file in files]
        assert sum(len(scan[next(iter(scan.files))]) for scan in scans) == elements


def test_kitti_has_a_sequence_for_each_run(campaign, tmp_path, capsys):
    index = exported(campaign[0], "kitti", tmp_path / "o", capsys)
    assert [(row["place"], row["run"], row["seed"]) for row in index] == [("00", "0", "0"), ("01", "2", "1")]
    for row, elements in zip(index, campaign[1], strict=True):
        scans = sorted((tmp_path / "o/sequences" / row["place"] / "velodyne").glob("*.bin"))
        assert sum(file.stat().st_size for file in scans) == elements * 16  # x, y, z, intensity as float32
        assert len((tmp_path / f"o/poses/{row['place']}.txt").read_text().splitlines()) == len(scans) == 2


def test_nuscenes_has_a_scene_for_each_run(campaign, tmp_path, capsys):
    out = tmp_path / "o"
    index = exported(campaign[0], "nuscenes", out, capsys)
    tables = {one.stem: json.loads(one.read_text()) for one in (out / "v1.0-tickgraph").glob("*.json")}
    assert (
        [row["place"] for row in index] == [scene["name"] for scene in tables["scene"]] == ["scene-0001", "scene-0002"]
    )
    tokens = {name: [row["token"] for row in rows] for name, rows in tables.items()}
    assert all(len(set(found)) == len(found) for found in tokens.values())
    assert {name: len(tokens[name]) for name in ("sample", "sample_data", "ego_pose", "sensor", "log", "map")} == {
        "sample": 4, "sample_data": 4, "ego_pose": 4, "sensor": 1, "log": 2, "map": 1,
    }  # fmt: skip
    assert tables["map"][0]["log_tokens"] == tokens["log"]
    sizes = dict.fromkeys(tokens["scene"], 0)
    scene_of = {sample["token"]: sample["scene_token"] for sample in tables["sample"]}
    for data in tables["sample_data"]:
        sizes[scene_of[data["sample_token"]]] += (out / data["filename"]).stat().st_size
    assert [*sizes.values()] == [elements * 20 for elements in campaign[1]]  # x, y, z, intensity, ring as float32


def test_nuscenes_writes_each_table_once_however_many_runs(campaign, tmp_path, capsys, monkeypatch):
    """A table that grew with each run would take quadratic time."""
    written = Counter()
    write = nuscenes.write

    def count(path, data):
        written[path.name] += path.suffix == ".json"
        write(path, data)

    monkeypatch.setattr(nuscenes, "write", count)
    exported(campaign[0], "nuscenes", tmp_path / "o", capsys)
    assert {name: times for name, times in written.items() if times} == dict.fromkeys(
        (one.name for one in (tmp_path / "o/v1.0-tickgraph").iterdir()), 1
    )
