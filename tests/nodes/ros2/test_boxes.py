"""Bounding boxes as detections."""

import numpy as np
import pytest

from graph import ComputeError
from graph.testing import run_node
from nodes.ros2.boxes import BOX_2D, BOX_3D


def once(kind, app, rows, **inputs):
    inputs = {"data": rows.view(np.uint8).reshape(-1), **inputs}
    run_node(kind, inputs=inputs, pulses={"execIn": [0]}, app=app)


def test_boxes_in_the_image_have_centre_and_size(world, plain):
    app = world()
    once("ROS2PublishBbox2D", app, np.array([(7, 10, 20, 31, 60, 0.5), (8, 0, 0, 4, 2, 0)], BOX_2D), timeStamp=1.0)
    [message] = plain(app, "/bbox2d")
    assert message["header"] == {"stamp": {"sec": 1, "nanosec": 0}, "frame_id": "sim_camera"}
    boxes = [one["bbox"] for one in message["detections"]]
    assert [(box["center"]["position"]["x"], box["center"]["position"]["y"]) for box in boxes] == [(20.5, 40), (2, 1)]
    assert [(box["size_x"], box["size_y"]) for box in boxes] == [(21, 40), (4, 2)]
    assert [one["results"][0]["hypothesis"] for one in message["detections"]] == [
        {"class_id": "7", "score": 1.0}, {"class_id": "8", "score": 1.0},
    ]  # fmt: skip


def test_boxes_in_space_are_placed_by_their_prims_pose_in_metres(stage, world, plain):
    from pxr import UsdGeom

    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    app = world()
    # Row vectors: scaled by 2, then turned 90 degrees about z (x goes to y), then moved by (100, 0, 0).
    transform = [[0, 2, 0, 0], [-2, 0, 0, 0], [0, 0, 2, 0], [100, 0, 0, 1]]
    once("ROS2PublishBbox3D", app, np.array([(3, [0, -5, 0], [20, 5, 10], transform, 0)], BOX_3D))
    [detection] = plain(app, "/bbox3d")[0]["detections"]
    box = detection["bbox"]
    # The middle (10, 0, 5) goes to (100, 20, 10) units.
    assert list(box["center"]["position"].values()) == pytest.approx([1.0, 0.2, 0.1])
    assert list(box["center"]["orientation"].values()) == pytest.approx([0, 0, 0.5**0.5, 0.5**0.5])
    assert list(box["size"].values()) == pytest.approx([0.4, 0.2, 0.2])
    assert detection["results"][0]["hypothesis"]["class_id"] == "3"


def test_no_boxes_are_an_empty_list_of_detections(world, plain):
    app = world()
    once("ROS2PublishBbox2D", app, np.zeros(0, BOX_2D))
    once("ROS2PublishBbox3D", app, np.zeros(0, BOX_3D))
    assert plain(app, "/bbox2d")[0]["detections"] == plain(app, "/bbox3d")[0]["detections"] == []


@pytest.mark.parametrize(("kind", "size"), [("ROS2PublishBbox2D", 24), ("ROS2PublishBbox3D", 96)])
def test_a_part_of_a_box_is_refused(world, kind, size):
    with pytest.raises(ComputeError, match=f"data has {size + 1} bytes; a box has {size}"):
        once(kind, world(), np.zeros(size + 1, np.uint8))
