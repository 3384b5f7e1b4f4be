"""A run on ROS 2 topics over DDS, received in a process of its own with Cyclone DDS's own types."""

import os

import pytest

from tests.support.live_rig import CLOUDS, POINTS, digests, heard, listening, recorded, ros_domain, run_rig, write_rig

pytest.importorskip("cyclonedds", reason="pip install 'tickgraph[dds]'")


def test_a_ros_2_program_receives_every_cloud_and_drives_the_robot(tmp_path):
    file, out = write_rig(tmp_path), tmp_path / "out"
    domain = 100 + os.getpid() % 100
    with listening("dds", CLOUDS, environment=ros_domain(domain)) as listener:
        report = run_rig(file, out, "--live", "dds", environment=ros_domain(domain))
        said = heard(listener)
    clouds = said["clouds"][:CLOUDS]
    assert [points for points, _ in clouds] == [POINTS] * CLOUDS
    assert [digest for _, digest in clouds] == digests(recorded(out, "/points"))[:CLOUDS]
    assert said["travelled"] > 0.3  # more than half of the 3.2 s at 0.5 m/s
    # The clock of updates of 1/60 s, in order and without gaps.
    steps = {later - earlier for earlier, later in zip(said["clock"], said["clock"][1:], strict=False)}
    assert steps == {16_666_666, 16_666_667}
    points = said["endpoints"]["rt/points"]
    assert points["type"] == "sensor_msgs::msg::dds_::PointCloud2_"
    # As ROS 2 Jazzy prints it: `ros2 topic info -v` of a PointCloud2.
    assert points["user_data"].startswith("typehash=RIHS01_")
    assert (points["reliable"], points["durability"]) == (True, "Policy.Durability.Volatile")
    assert report["live"]["dds"]["topics"]["/points"] == {"sent": 32, "dropped": 0, "not_sent": 0, "received": 0}
    assert report["live"]["dds"]["topics"]["/cmd_vel"]["received"] == len(recorded(out, "/cmd_vel")) > 0
