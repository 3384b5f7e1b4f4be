"""Names of the RTX sensors' modules: enums of buffers, pictures of annotators, prims that may be wrapped."""

from importlib import import_module

import numpy as np
import pytest

import graph.isaac
from graph.sim import App
from tests.support.without_wing import needs_wing


@pytest.fixture
def rtx():
    with App() as app, graph.isaac.importable():
        module = import_module("isaacsim.sensors.experimental.rtx")
        module.stage = app.stage
        yield module


@pytest.mark.parametrize(
    ("kind", "prim_type"),
    [
        ("Lidar", "OmniLidar"),
        ("Radar", "OmniRadar"),
        pytest.param("Acoustic", "OmniAcoustic", marks=needs_wing("acoustic")),
    ],
)
def test_a_bare_prim_without_its_schema_is_not_wrapped(rtx, kind, prim_type):
    made = getattr(rtx, kind)
    rtx.stage.DefinePrim("/World/bare", prim_type)
    with pytest.raises(ValueError, match=f"/World/bare is without the API schema {made.schema}"):
        made("/World/bare")
    rtx.stage.DefinePrim("/World/whole", prim_type).AddAppliedSchema(made.schema)
    assert made("/World/whole").paths == ["/World/whole"]
    assert made(made("/World/new").path).paths == ["/World/new"]


def test_fields_of_buffers_are_named_by_their_enums(rtx):
    names = import_module("isaacsim.sensors.experimental.rtx.generic_model_output")
    assert [one.name for one in names.AuxType] == ["NONE", "BASIC", "EXTRA", "FULL"]
    assert (names.Modality.ACOUSTIC, names.CoordsType.NOT_APPLICABLE) == (3, 2)


def test_depths_are_drawn_from_near_in_white_to_far_in_black(rtx):
    depths = np.array([[[1.0], [2.0]], [[3.0], [np.inf]]], np.float32)
    drawn = rtx.draw_annotator_data_to_image(annotator="distance_to_camera", data=depths, info={})
    assert drawn.tolist() == [[255, 127], [0, 0]]


def test_colors_are_drawn_as_blue_green_red(rtx):
    one = np.array([[[1, 2, 3, 4]]], np.uint8)
    assert rtx.draw_annotator_data_to_image(annotator="rgb", data=one[..., :3], info={}).tolist() == [[[3, 2, 1]]]
    assert rtx.draw_annotator_data_to_image(annotator="rgba", data=one, info={}).tolist() == [[[3, 2, 1, 4]]]


def test_segments_are_drawn_over_the_picture_but_for_the_background(rtx):
    frame = np.full((1, 2, 3), 9, np.uint8)
    ids = np.array([[[0], [5]]], np.uint32)
    drawn = rtx.draw_annotator_data_to_image(annotator="semantic_segmentation", data=ids, info={}, frame=frame)
    assert drawn[0, 0].tolist() == [9, 9, 9]
    assert drawn[0, 1].tolist() != [9, 9, 9]


def test_boxes_are_drawn_at_their_corners(rtx):
    box = np.zeros(1, [("semanticId", "<u4"), ("x_min", "<i4"), ("y_min", "<i4"), ("x_max", "<i4"), ("y_max", "<i4")])
    box[0] = (1, 2, 3, 7, 8)
    drawn = rtx.draw_annotator_data_to_image(
        annotator="bounding_box_2d_tight", data=box, info={}, frame=np.zeros((12, 10, 3), np.uint8)
    )
    rows, columns = np.nonzero(drawn.any(axis=-1))
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (3, 8, 2, 7)


def test_points_in_space_are_drawn_on_white(rtx):
    drawn = rtx.draw_annotator_data_to_image(annotator="pointcloud", data=np.eye(3), info={})
    assert drawn.shape == (1500, 1500, 3)
    assert 0 < (drawn != 255).any(axis=-1).sum() < 100


def test_what_gives_no_picture_is_refused(rtx):
    with pytest.raises(ValueError, match="'skeleton_data' gives no picture"):
        rtx.draw_annotator_data_to_image(annotator="skeleton_data", data=np.zeros(3), info={})


def test_facts_of_a_camera_asset(rtx):
    (asset,) = (one for one in rtx.SUPPORTED_CAMERA_CONFIGS if "oak_d_pro_poe" in one)
    assert rtx.get_camera_metadata(asset) == {
        "vendor": "Luxonis",
        "display_name": "Luxonis OAK-D Pro PoE",
        "prim_prefix": "oak_d_pro_poe",
        "is_depth_sensor": True,
        "variants": set(),
    }


def test_base_materials_are_grouped(rtx):
    old = import_module("isaacsim.sensors.rtx")
    groups = (old.NONE_BASE, old.METALS_BASE, old.POLYMERS_BASE, old.GLASS_BASE, old.OTHER_BASE)
    assert {name: number for group in groups for name, number in group.items()} == old.BASE_MATERIALS
    assert (old.METALS_BASE["tin"], old.POLYMERS_BASE["plastic"], old.GLASS_BASE["clear_glass"]) == (10, 11, 19)
    assert (old.OTHER_BASE["asphalt"], len(old.OTHER_BASE)) == (24, 24)
