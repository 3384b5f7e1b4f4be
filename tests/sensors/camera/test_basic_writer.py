"""Replicator's BasicWriter: what a camera sees as files of one folder, under the product's names."""

import json

import numpy as np
import pytest
from PIL import Image

import sensors.replicator as rep
from graph.base.errors import UserError
from sensors.errors import SensorValueError
from tests.support.camera_worlds import add_camera, ahead
from tests.support.lidar_worlds import add_box, weightless


@pytest.fixture
def app():
    """A labelled cube of side 1, its front 4.5 m ahead."""
    with weightless() as app:
        add_box(app, "/World/A", 1.0, ahead(0, 0, 5))
        prim = app.stage.GetPrimAtPath("/World/A")
        prim.AddAppliedSchema("SemanticsLabelsAPI:class")
        prim.GetAttribute("semantics:labels:class").Set(["crate"])
        yield app


def files(app, folder, updates=2, **options):
    """The names of what is written of some frames."""
    product = add_camera(app)
    rep.writers.get("BasicWriter", app=app).initialize(output_dir=folder, **options).attach([product])
    app.play()
    app.update(steps=updates)
    return sorted(path.name for path in folder.iterdir())


def test_each_frame_and_kind_is_a_file(app, tmp_path):
    names = files(app, tmp_path / "out", rgb=True, distance_to_camera=True)
    assert names == [
        *("distance_to_camera_0000.npy", "distance_to_camera_0001.npy"),
        *("rgb_0000.png", "rgb_0001.png"),
    ]
    depth = np.load(tmp_path / "out" / "distance_to_camera_0000.npy")
    assert depth[240, 320] == pytest.approx(4.5, abs=1e-4)
    with Image.open(tmp_path / "out" / "rgb_0000.png") as picture:
        assert (picture.size, picture.mode) == ((640, 480), "RGBA")


def test_boxes_have_their_labels_and_paths_beside_them(app, tmp_path):
    names = files(app, tmp_path, 1, bounding_box_2d_tight=True, bounding_box_3d=True)
    assert names == [
        f"{name}{part}_0000.{ending}"
        for name in ("bounding_box_2d_tight", "bounding_box_3d")
        for part, ending in (("", "npy"), ("_labels", "json"), ("_prim_paths", "json"))
    ]
    boxes = np.load(tmp_path / "bounding_box_2d_tight_0000.npy")
    assert boxes["semanticId"].tolist() == [0]
    assert json.loads((tmp_path / "bounding_box_2d_tight_labels_0000.json").read_text()) == {"0": {"class": "crate"}}
    assert json.loads((tmp_path / "bounding_box_2d_tight_prim_paths_0000.json").read_text()) == ["/World/A"]


def test_segmentations_are_colours_or_numbers_with_tables(app, tmp_path):
    wanted = {"semantic_segmentation": True, "instance_segmentation": True}
    names = files(app, tmp_path, 1, colorize_instance_segmentation=False, frame_padding=2, **wanted)
    assert names == [
        *("instance_segmentation_00.png", "instance_segmentation_mapping_00.json"),
        *("instance_segmentation_semantics_mapping_00.json",),
        *("semantic_segmentation_00.png", "semantic_segmentation_labels_00.json"),
    ]
    with Image.open(tmp_path / "instance_segmentation_00.png") as picture:
        assert np.asarray(picture)[240, 320] == 2
    assert json.loads((tmp_path / "instance_segmentation_mapping_00.json").read_text())["2"] == "/World/A"
    table = json.loads((tmp_path / "semantic_segmentation_labels_00.json").read_text())
    with Image.open(tmp_path / "semantic_segmentation_00.png") as picture:
        assert table[str(picture.getpixel((320, 240)))] == {"class": "crate"}


def test_clouds_and_parameters(app, tmp_path):
    names = files(app, tmp_path, 1, pointcloud=True, camera_params=True, normals=True, motion_vectors=True)
    assert "pointcloud_0000.npy" in names
    assert {"normals_0000.png", "motion_vectors_0000.npy", "pointcloud_semantic_0000.npy"} <= set(names)
    assert json.loads((tmp_path / "camera_params_0000.json").read_text())["renderProductResolution"] == [640, 480]


def test_nothing_is_written_through_a_link(app, tmp_path):
    outside = tmp_path / "outside.png"
    outside.write_text("mine")
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "rgb_0000.png").symlink_to(outside)
    with pytest.raises(UserError, match="is a link, and nothing is written through links"):
        files(app, folder, 1, rgb=True)
    assert outside.read_text() == "mine"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"rbg": True}, "no option 'rbg'; did you mean \"rgb\""),
        ({"image_output_format": "gif"}, "image_output_format 'gif' is not one of png, jpeg, jpg"),
        ({"frame_padding": -1}, "give 0 to 20 digits"),
    ],
)
def test_mistakes_are_one_line(app, tmp_path, options, said):
    with pytest.raises(SensorValueError, match=said):
        files(app, tmp_path, **options)


def test_a_folder_is_needed(app):
    with pytest.raises(SensorValueError, match="output_dir"):
        rep.writers.get("BasicWriter", app=app).initialize(rgb=True).attach([add_camera(app)])
