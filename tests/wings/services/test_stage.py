"""The stage as services."""

import json

import pytest

from graph import ComputeError
from graph.testing import run_node

PACKAGE = "isaac_ros2_messages/srv"


@pytest.fixture
def ask(stage, world):
    """A function: asks services (name, type, fields) in one update; returns the answers as plain data."""
    from pxr import Gf, UsdGeom

    from graph.sim.messages.ros_fields import from_plain, to_plain

    box = UsdGeom.Cube.Define(stage, "/World/Box")
    box.AddTranslateOp().Set((1, 2, 3))
    box.AddOrientOp().Set(Gf.Quatf(0.5, 0.5, -0.5, 0.5))
    UsdGeom.Xform.Define(stage, "/World/Box/Inner")

    def ask(*questions, updates=None):
        app = world()
        calls = []

        def put(update, node):
            if update == 1:
                for service, kind, fields in questions:
                    request = from_plain(f"{PACKAGE}/{kind}_Request", fields)
                    calls.append((kind, app.bus.services.call(service, f"{PACKAGE}/{kind}", request)))

        updates = updates or len(questions) + 1
        trace = run_node("ROS2ServicePrim", pulses={"execIn": range(updates)}, updates=updates, app=app, on_update=put)
        assert trace.fired("execOut")[:1] == [1]
        return [to_plain(f"{PACKAGE}/{kind}_Response", call.response) for kind, call in calls]

    return ask


def test_prims_are_listed_with_all_below(ask):
    [answer] = ask(("/get_prims", "GetPrims", {"path": "/World"}))
    assert answer == {
        "paths": ["/World", "/World/Box", "/World/Box/Inner"], "types": ["", "Cube", "Xform"],
        "success": True, "message": "",
    }  # fmt: skip


def test_attributes_are_listed_with_types(ask):
    [answer] = ask(("/get_prim_attributes", "GetPrimAttributes", {"path": "/World/Box"}))
    types = dict(zip(answer["names"], answer["types"], strict=True))
    assert (types["size"], types["xformOp:translate"], types["xformOp:orient"]) == ("double", "double3", "quatf")


@pytest.mark.parametrize(
    ("attribute", "kind", "value"),
    [
        ("size", "double", 2.0),
        ("xformOp:translate", "double3", [1, 2, 3]),
        ("xformOp:orient", "quatf", [0.5, 0.5, -0.5, 0.5]),
        ("xformOpOrder", "token[]", ["xformOp:translate", "xformOp:orient"]),
        ("extent", "float3[]", [[-1, -1, -1], [1, 1, 1]]),
    ],
)
def test_values_are_read_as_json(ask, attribute, kind, value):
    [answer] = ask(("/get_prim_attribute", "GetPrimAttribute", {"path": "/World/Box", "attribute": attribute}))
    assert (json.loads(answer["value"]), answer["type"], answer["success"]) == (value, kind, True)


def test_values_are_written_from_json(ask, stage):
    questions = [
        ("/set_prim_attribute", "SetPrimAttribute", {"path": "/World/Box", "attribute": name, "value": value})
        for name, value in (("size", "3.5"), ("xformOp:orient", "[1, 0, 0, 0]"), ("size", '"big"'), ("size", "{"))
    ]
    answers = ask(*questions)
    assert [answer["success"] for answer in answers] == [True, True, False, False]
    assert answers[2]["message"] == "'size' does not take '\"big\"': 'big' is not a number"
    box = stage.GetPrimAtPath("/World/Box")
    assert box.GetAttribute("size").Get() == 3.5
    assert box.GetAttribute("xformOp:orient").Get().GetReal() == 1


@pytest.mark.parametrize(
    ("service", "kind", "fields", "message"),
    [
        ("/get_prims", "GetPrims", {"path": "/Gone"}, "Invalid prim: '/Gone'"),
        ("/get_prims", "GetPrims", {"path": "no path"}, "Invalid prim: 'no path'"),
        ("/get_prim_attributes", "GetPrimAttributes", {}, "Invalid prim: ''"),
        (
            "/get_prim_attribute", "GetPrimAttribute", {"path": "/World/Box", "attribute": "mass"},
            "Prim has no attribute: 'mass'",
        ),
    ],
)  # fmt: skip
def test_what_is_not_there_is_answered_not_raised(ask, service, kind, fields, message):
    [answer] = ask((service, kind, fields))
    assert (answer["success"], answer["message"]) == (False, message)


def test_a_service_without_name_stops_the_run(world):
    with pytest.raises(ComputeError, match="getAttributeServiceName is empty"):
        run_node("ROS2ServicePrim", inputs={"getAttributeServiceName": ""}, pulses={"execIn": [0]}, app=world())
