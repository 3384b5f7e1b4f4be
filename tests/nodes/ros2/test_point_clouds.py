import numpy as np
import pytest

from graph.sim.messages.ros_types import deserialize, serialize
from nodes.ros2.point_clouds import CLOUD_FIELDS, POINT_CLOUD, point_cloud

POINTS = np.array([[1, 2, 3], [4, 5, 6]], np.float32)


def layout(message):
    return [(one.name, one.offset, one.datatype, one.count) for one in message.fields]


def test_a_bare_cloud_is_x_y_z_float32_packed_in_12_bytes():
    message = point_cloud(POINTS, {}, 1_500_000_002, "lidar")
    assert layout(message) == [("x", 0, 7, 1), ("y", 4, 7, 1), ("z", 8, 7, 1)]
    assert (message.height, message.width, message.point_step, message.row_step) == (1, 2, 12, 24)
    assert (message.is_dense, message.is_bigendian) == (True, False)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 500_000_002)
    assert message.header.frame_id == "lidar"
    assert message.data.tobytes() == POINTS.astype("<f4").tobytes()


EVERYTHING = {
    "Intensity": np.array([0.5, 0.25], np.float32),
    "Timestamp": np.array([2**32 + 7, 8], np.uint64),
    "EmitterId": np.array([1, 2], np.uint32),
    "ChannelId": np.array([3, 4], np.uint32),
    "MaterialId": np.array([5, 6], np.uint32),
    "TickId": np.array([7, 8], np.uint32),
    "HitNormal": np.array([[0, 0, 1], [1, 0, 0]], np.float32),
    "Velocity": np.array([[1, 2, 3], [4, 5, 6]], np.float32),
    "ObjectId": np.arange(32, dtype=np.uint8).reshape(2, 16),
    "EchoId": np.array([0, 1], np.uint8),
    "TickState": np.array([2, 3], np.uint8),
    "RadialVelocityMS": np.array([-1.5, 2.5], np.float32),
    "Ring": np.array([9, 10], np.uint32),
    "Time": np.array([0, 99_900_000], np.int32),
}


def test_all_fields_stand_in_the_order_of_the_original_ours_last():
    names = [name for name, *_ in layout(point_cloud(POINTS, EVERYTHING, 0, "lidar"))]
    assert names == [
        *(
            "x",
            "y",
            "z",
            "intensity",
            "timestamp_0",
            "timestamp_1",
            "emitter_id",
            "channel_id",
            "material_id",
            "tick_id",
        ),
        *("nx", "ny", "nz", "vx", "vy", "vz", "object_id_0", "object_id_1", "object_id_2", "object_id_3"),
        *("echo_id", "tick_state", "radial_velocity_ms", "ring", "time"),
    ]


def test_the_fields_hold_what_went_in_after_a_trip_through_cdr():
    message = deserialize(serialize(point_cloud(POINTS, EVERYTHING, 0, "lidar"), POINT_CLOUD), POINT_CLOUD)
    formats = {2: "u1", 4: "<u2", 6: "<u4", 7: "<f4"}
    dtype = np.dtype(
        {
            "names": [one.name for one in message.fields],
            "formats": [formats[one.datatype] for one in message.fields],
            "offsets": [one.offset for one in message.fields],
            "itemsize": message.point_step,
        }
    )
    points = np.frombuffer(message.data.tobytes(), dtype)
    assert message.point_step == 92
    assert points["x"].tolist() == [1, 4]
    assert points["intensity"].tolist() == [0.5, 0.25]
    assert (points["timestamp_1"].astype(np.uint64) << np.uint64(32) | points["timestamp_0"]).tolist() == [2**32 + 7, 8]
    assert points["nx"].tolist() == [0, 1]
    assert points["vz"].tolist() == [3, 6]
    assert points["object_id_0"][0] == 0x03020100
    assert points["tick_state"].tolist() == [2, 3]
    assert points["ring"].tolist() == [9, 10]
    assert points["time"].tolist() == pytest.approx([0, 0.0999])


def test_a_quantity_that_the_sensor_did_not_deliver_is_left_out():
    message = point_cloud(
        POINTS, {"EmitterId": np.empty(0, np.uint32), "Intensity": EVERYTHING["Intensity"]}, 0, "lidar"
    )
    assert [one.name for one in message.fields] == ["x", "y", "z", "intensity"]


def test_an_empty_cloud_keeps_its_fields():
    message = point_cloud(np.empty((0, 3), np.float32), {"Intensity": np.empty(0, np.float32)}, 0, "lidar")
    assert [one.name for one in message.fields] == ["x", "y", "z", "intensity"]
    assert (message.width, message.row_step, len(message.data)) == (0, 0, 0)


def test_arrays_of_another_length_are_refused():
    with pytest.raises(ValueError, match="Intensity has 3 values for 2 points"):
        point_cloud(POINTS, {"Intensity": np.zeros(3, np.float32)}, 0, "lidar")


def test_every_field_names_a_channel_that_sensors_know_or_a_radars():
    from sensors.channels import CHANNELS

    assert {one.channel for one in CLOUD_FIELDS.values()} <= CHANNELS.keys()
