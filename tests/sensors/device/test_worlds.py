"""Many worlds: each is what one alone would be, scans by the exact schedule, and begins again after a reset."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("warp", reason="pip install 'tickgraph[gpu]'")
pytest.importorskip("mujoco_warp", reason="pip install 'tickgraph[gpu]'")

from graph.base.errors import UserError
from graph.sim import Worlds
from tests.support.devices import on_each

FILE = Path(__file__).parents[3] / "graphs" / "worlds.yaml"
LIDAR = "/World/Robot/chassis/lidar"


def drive(worlds, updates, speeds=None):
    """Steps the worlds with wheel speeds (w, 2) [rad/s]; returns each world's ranges and joint positions."""
    if speeds is not None:
        worlds.drive(velocities=np.asarray(speeds, np.float32))
    for _ in range(updates):
        worlds.step()
    return worlds.lidars[LIDAR].channels.distance.numpy(), worlds.coordinates.numpy()


@on_each
def test_a_world_of_many_is_the_world_alone(device):
    """On the processor to the bit; on a card to 1e-4, for it adds in no fixed order."""
    with Worlds(FILE, count=1, device=device, channels=["distance"]) as alone:
        one, place = drive(alone, 13, [[5, 5]])
    with Worlds(FILE, count=3, device=device, channels=["distance"]) as many:
        all_, places = drive(many, 13, [[5, 5], [0, 0], [5, -5]])
    assert one[0].max() > 1
    most = 1e-4 if device == "cuda" else 0.0
    assert np.abs(one[0] - all_[0]).max() <= most
    assert np.abs(place[0] - places[0]).max() <= most
    assert not np.array_equal(all_[0], all_[1])
    assert not np.array_equal(all_[1], all_[2])


@on_each
def test_scans_come_at_their_exact_times_and_begin_again_after_a_reset(device):
    """10 Hz at 60 updates a second: the scan of tick k covers [(k - 1) / 10, k / 10), in update 6 k. World 1, reset
    after update 9, is at its first scan after update 15, when the others are at their second."""
    with Worlds(FILE, count=2, device=device, channels=["distance"]) as worlds:
        lidar = worlds.lidars[LIDAR]
        drive(worlds, 5, [[5, 5], [5, 5]])
        assert lidar.frame_id.tolist() == [-1, -1]
        drive(worlds, 1)
        assert (lidar.frame_id.tolist(), lidar.stamp_ns.tolist()) == ([0, 0], [0, 0])
        drive(worlds, 3)
        driven = worlds.coordinates.numpy()[1].copy()
        worlds.reset([False, True])
        assert not np.array_equal(worlds.coordinates.numpy()[1], driven)
        drive(worlds, 6)
        assert lidar.frame_id.tolist() == [1, 0]
        assert lidar.stamp_ns.tolist() == [100_000_000, 0]
        assert worlds.steps.tolist() == [60, 24]


@on_each
def test_the_first_scan_is_that_of_an_app(device):
    """Until the first scan nothing moves but for what settles: ranges of the same file in an App, to a millimetre."""
    from graph.sim import App
    from sensors import render_product
    from sensors.annotators.annotator import Annotator
    from sensors.annotators.registry import find_annotator

    with Worlds(FILE, count=1, device=device, channels=["distance", "surface"]) as worlds:
        ranges, _ = drive(worlds, 6)
    with App.from_file(FILE) as app:
        cloud = Annotator(find_annotator("IsaacExtractRTXSensorPointCloud"), app=app).attach(render_product(app, LIDAR))
        app.play()
        app.update(steps=6)
        seen = cloud.get_data()["distance"]
    assert len(seen) == np.count_nonzero(ranges[0])
    assert np.abs(ranges[0][ranges[0] > 0] - seen).max() < 1e-3


@on_each
def test_wrong_shapes_counts_and_rates_are_refused_in_a_line(device):
    with pytest.raises(UserError, match="count 0 is not above 0"):
        Worlds(FILE, count=0, device=device)
    with pytest.raises(UserError, match="for one world on the processor use App"):
        Worlds(FILE, count=2, device="cpu")
    with pytest.raises(UserError, match="must be a multiple of the loop's"):
        Worlds(FILE, count=2, device=device, fidelity={"physics.hz": 100})
    with Worlds(FILE, count=2, device=device, channels=["distance"]) as worlds:
        with pytest.raises(UserError, match=r"shape \(2, 3\); give \(2, 2\)"):
            worlds.drive(velocities=np.zeros((2, 3), np.float32))
        with pytest.raises(UserError, match="one value for each of 2 worlds"):
            worlds.reset([True])
