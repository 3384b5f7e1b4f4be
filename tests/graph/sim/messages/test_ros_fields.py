"""Message types and the two views of them: flat fields, plain data."""

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from graph.sim.messages.ros_fields import from_plain, leaves, pack, to_plain, unpack, zero
from graph.sim.messages.ros_types import definition, deserialize, known, message_type, register, serialize, type_names

TWIST = "geometry_msgs/msg/Twist"


def test_inner_fields_are_named_by_their_path():
    names = [(leaf.name, leaf.type) for leaf in leaves("sensor_msgs/msg/JointState")]
    assert names == [
        ("header:stamp:sec", "int"),
        ("header:stamp:nanosec", "uint"),
        ("header:frame_id", "token"),
        ("name", "token[]"),
        ("position", "double[]"),
        ("velocity", "double[]"),
        ("effort", "double[]"),
    ]


def test_every_known_type_goes_through_all_forms_and_keeps_its_bytes():
    """Those of ROS: other tests add types of their own, some of them huge."""
    own = get_typestore(Stores.ROS2_HUMBLE).types
    for name in sorted(own.keys() & set(type_names())):
        message = zero(name)
        data = serialize(message, name)
        assert serialize(deserialize(data, name), name) == data
        assert serialize(pack(name, unpack(name, message)), name) == data
        assert serialize(from_plain(name, to_plain(name, message)), name) == data


def test_values_survive_flattening():
    fields = {"linear": {"x": 1.5, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": -2.0}}
    message = from_plain(TWIST, fields)
    assert unpack(TWIST, message) == [1.5, 0, 0, 0, 0, -2.0]
    assert to_plain(TWIST, pack(TWIST, unpack(TWIST, message))) == fields


def test_a_list_of_messages_is_a_list_of_json_texts():
    name = "geometry_msgs/msg/Polygon"
    message = pack(name, [['{"x": 1, "y": 2}', "{}"]])
    assert [(one.x, one.y, one.z) for one in message.points] == [(1, 2, 0), (0, 0, 0)]
    assert unpack(name, message) == [['{"x": 1.0, "y": 2.0, "z": 0.0}', '{"x": 0.0, "y": 0.0, "z": 0.0}']]


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        (TWIST, {"linear": {"w": 1}}, "has no field linear.w; it has x, y, z"),
        (TWIST, {"linear": 3}, "field linear must be a mapping"),
        (TWIST, [], "the message must be a mapping"),
        (TWIST, {"linear": {"x": "fast"}}, "field linear.x: 'fast' is not a float64"),
        ("std_msgs/msg/Int8", {"data": 200}, "field data: 200 does not fit into int8"),
        ("std_msgs/msg/Int8", {"data": 1.5}, "field data: 1.5 is not a whole number"),
        ("std_msgs/msg/UInt8MultiArray", {"data": [1, 256]}, "field data: the values do not fit into uint8"),
        ("std_msgs/msg/UInt8MultiArray", {"data": 7}, "field data: 7 is not a list"),
        ("sensor_msgs/msg/CameraInfo", {"k": [1, 2]}, "field k: needs 9 values, got 2"),
        ("shape_msgs/msg/SolidPrimitive", {"dimensions": [1, 2, 3, 4]}, "takes at most 3 values, got 4"),
        ("std_msgs/msg/Empty", {"structure_needs_at_least_one_member": 1}, "it has no fields"),
    ],
)
def test_what_does_not_fit_is_named(name, data, message):
    with pytest.raises(ValueError, match=message):
        from_plain(name, data)


def test_services_and_messages_beyond_the_common_packages_are_there():
    request = message_type("example_interfaces/srv/AddTwoInts_Request")(2, 3)
    data = serialize(request, "example_interfaces/srv/AddTwoInts_Request")
    assert data[4:] == (2).to_bytes(8, "little") + (3).to_bytes(8, "little")
    assert [leaf.name for leaf in leaves("ackermann_msgs/msg/AckermannDriveStamped")][-1] == "drive:jerk"
    assert "AckermannDrive drive" in definition("ackermann_msgs/msg/AckermannDriveStamped")


def test_installed_packages_are_searched(tmp_path, monkeypatch):
    folder = tmp_path / "share" / "yard_msgs"
    (folder / "msg").mkdir(parents=True)
    (folder / "srv").mkdir()
    (folder / "msg" / "Gate.msg").write_text("# a gate\nbool open\nfloat32[2] size  # [m]\n")
    (folder / "srv" / "Lift.srv").write_text("float64 height\n---\nbool done\n")
    assert not known("yard_msgs/msg/Gate")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    assert [(leaf.name, leaf.type) for leaf in leaves("yard_msgs/msg/Gate")] == [("open", "bool"), ("size", "float[]")]
    assert known("yard_msgs/srv/Lift_Response")
    assert not known("yard_msgs/msg/../../secret")


def test_a_definition_that_cannot_be_read_or_needs_unknown_types_is_refused():
    with pytest.raises(ValueError, match="no message definition"):
        register("a_msgs/msg/Broken", "int32 = = 3 what")
    with pytest.raises(ValueError, match="field pose is of the unknown type b_msgs/msg/Pose"):
        register("a_msgs/msg/Holey", "b_msgs/Pose pose")
    assert not known("a_msgs/msg/Holey")


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a_msgs/Twist", "int32 x", "is not a type name; one reads package/msg/Name"),
        ("a_msgs/msg/X\nimport os", "int32 x", "is not a type name"),
        ("a_msgs/msg/L", "a_msgs/L[] inner", "field inner makes the type hold itself"),
        ("a_msgs/msg/M", f"a_msgs/N n\n{'=' * 80}\nMSG: a_msgs/N\na_msgs/M[] m", "makes the type hold itself"),
        ("a_msgs/msg/D", "int32 x\nfloat64 x", "a_msgs/msg/D: "),
        ("a_msgs/msg/B", "int32[999999999999] x", "holds 999,999,999,999 values; the limit is 1,000,000 values"),
        (
            "a_msgs/msg/P",
            f"a_msgs/Q[2000] q\n{'=' * 80}\nMSG: a_msgs/Q\nint32[2000] x",
            "holds 4,000,000 values",
        ),
    ],
)
def test_definitions_of_strangers_cannot_do_harm(name, text, message):
    with pytest.raises(ValueError, match=message):
        register(name, text)


def test_fields_may_be_named_like_words_of_python_and_constants_are_left_out():
    name = "own_msgs/msg/Mail"
    register(name, 'string from\nint32 lambda\nstring HINT="a\'\\\\b"\n')
    message = from_plain(name, {"from": "me", "lambda": 3})
    assert to_plain(name, deserialize(serialize(message, name), name)) == {"from": "me", "lambda": 3}
    assert unpack(name, message) == ["me", 3]


def test_numbers_leave_a_message_in_their_own_width():
    message = pack("std_msgs/msg/Float32MultiArray", [[], 0, np.array([1.0, 2.0])])
    assert message.data.dtype == np.float32
