"""Semantic classes of returns: which labels count, how they are inherited, and the per-point array."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

import sensors.replicator as rep
from sensors.lidar.prim import write_config
from sensors.surfaces.semantics import inherited_labels, labels_of, numbered
from tests.support.lidar_worlds import add_box, rotary, weightless


def label(prim, taxonomy, *labels):
    """UsdSemantics: the API and its attribute."""
    prim.AddAppliedSchema(f"SemanticsLabelsAPI:{taxonomy}")
    prim.CreateAttribute(f"semantics:labels:{taxonomy}", Sdf.ValueTypeNames.TokenArray).Set(list(labels))


def old_label(prim, kind, data, name="Semantics"):
    prim.CreateAttribute(f"semantic:{name}:params:semanticType", Sdf.ValueTypeNames.String).Set(kind)
    prim.CreateAttribute(f"semantic:{name}:params:semanticData", Sdf.ValueTypeNames.String).Set(data)


@pytest.fixture
def prim():
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/World/Car/Body", "Cube")
    yield prim
    del stage


def test_labels_come_from_usd_semantics(prim):
    label(prim, "class", "car", "vehicle")
    label(prim, "colour", "red")

    assert labels_of(prim) == {"class": "car,vehicle", "colour": "red"}


def test_older_attributes_are_read_too_and_the_new_ones_win(prim):
    old_label(prim, "class", "truck")
    old_label(prim, "part", "body", name="Semantics_1")
    prim.CreateAttribute("semantics:state", Sdf.ValueTypeNames.String).Set("parked")
    assert labels_of(prim) == {"class": "truck", "part": "body", "state": "parked"}

    label(prim, "class", "car")

    assert labels_of(prim)["class"] == "car"


@pytest.mark.parametrize("value", ["", None])
def test_an_empty_label_is_none(prim, value):
    attribute = prim.CreateAttribute("semantics:labels:class", Sdf.ValueTypeNames.TokenArray)
    if value is not None:
        attribute.Set([value])
    old_label(prim, "class", "")

    assert labels_of(prim) == {}


def test_a_prim_has_the_labels_of_the_nearest_above_it(prim):
    stage = prim.GetStage()
    label(stage.GetPrimAtPath("/World"), "class", "world")
    label(stage.GetPrimAtPath("/World"), "site", "yard")
    label(stage.GetPrimAtPath("/World/Car"), "class", "car")

    assert inherited_labels(stage, "/World/Car/Body") == {"class": "car", "site": "yard"}
    assert inherited_labels(stage, "/World/None") == {}


def test_numbers_follow_the_text_of_the_labels():
    numbers, labels = numbered([{"class": "wall"}, {}, {"class": "car"}, {"class": "wall"}])

    assert numbers.tolist() == [3, 1, 2, 3]
    assert labels == {0: {"class": "BACKGROUND"}, 1: {"class": "UNLABELLED"}, 2: {"class": "car"}, 3: {"class": "wall"}}


def test_every_return_has_its_class():
    with weightless() as app:
        label(add_box(app, "/World/Ahead", 2.0, (6, 0, 0)), "class", "wall")
        old_label(add_box(app, "/World/Left", 2.0, (0, 6, 0), velocity=(0, 0, 0.1)), "class", "car")
        add_box(app, "/World/Right", 2.0, (0, -6, 0))
        instancer = UsdGeom.PointInstancer.Define(app.stage, "/World/Rocks")
        rock = UsdGeom.Sphere.Define(app.stage, "/World/Rocks/Prototypes/Rock")
        label(rock.GetPrim(), "class", "rock")
        label(instancer.GetPrim(), "site", "quarry")
        instancer.CreatePrototypesRel().SetTargets([rock.GetPath()])
        instancer.CreateProtoIndicesAttr([0])
        instancer.CreatePositionsAttr([Gf.Vec3f(-6, 0, 0)])
        write_config(
            app.stage.DefinePrim("/World/Lidar", "OmniLidar"), rotary(ticks=8, skip_dropping_invalid_points=True)
        )
        product = rep.create_render_product("/World/Lidar", app=app)
        classes = rep.get_annotator("SemanticClasses", app=app).attach(product)
        app.play()
        app.update(steps=6)
        found = classes.get_data()
        computed = set(product.frame.arrays)

    labels = found["info"]["idToLabels"]
    named = [labels[str(number)]["class"] for number in found["data"]]
    assert found["data"].dtype == np.uint32
    # Clockwise from straight ahead, every 45 degrees.
    nothing = "BACKGROUND"
    assert named == ["wall", nothing, "UNLABELLED", nothing, "rock", nothing, "car", nothing]
    assert labels[str(found["data"][4])] == {"class": "rock", "site": "quarry"}
    assert computed == {"classId"}
