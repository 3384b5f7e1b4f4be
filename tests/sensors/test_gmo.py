"""GenericModelOutput buffers: layout, round trip, and everything that is not one."""

import warnings

import numpy as np
import pytest

from sensors import GenericModelOutput, parse_generic_model_output_data, parse_object_ids, parse_stable_id_map_data
from sensors.channels import CHANNELS, AuxLevel
from sensors.frame import Frame, FramePose
from sensors.gmo import HEADER, Modality, channels_for, pack
from sensors.handles import handle, resolve


def frame_of(count, level=AuxLevel.FULL, coords="SPHERICAL"):
    generator = np.random.default_rng(3)
    arrays = {}
    for name in channels_for(level, coords):
        channel = CHANNELS[name]
        shape = (count, channel.width) if channel.width > 1 else count
        arrays[name] = generator.integers(0, 100, shape).astype(channel.dtype)
    pose = np.eye(4)
    pose[:3, 3] = 1.0, 2.0, 3.0
    pose[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]  # a quarter turn to the left
    return Frame(
        timestamp_ns=100,
        frame_id=7,
        start=FramePose(100, np.eye(4)),
        end=FramePose(200, pose),
        count=count,
        arrays=arrays,
        aux_level=level,
        coords=coords,
    )


def test_the_first_28_bytes_are_the_public_ones():
    buffer = pack(frame_of(5))

    assert buffer[:4].tobytes() == b"OMGN"
    assert buffer[4:16].view("<u4").tolist() == [1, 0, 0]
    assert int(buffer[16:24].view("<u8")[0]) == len(buffer)
    assert int(buffer[24:28].view("<u4")[0]) == 5


@pytest.mark.parametrize("level", list(AuxLevel))
@pytest.mark.parametrize("count", [0, 1, 7])
def test_what_is_packed_is_what_is_parsed(level, count):
    frame = frame_of(count, level)

    gmo = parse_generic_model_output_data(pack(frame))

    assert (gmo.numElements, gmo.timestampNs, gmo.frameId, gmo.auxType) == (count, 100, 7, level)
    assert gmo.modality is Modality.LIDAR
    np.testing.assert_array_equal(gmo.x, frame.arrays["azimuth"])
    np.testing.assert_array_equal(gmo.y, frame.arrays["elevation"])
    np.testing.assert_array_equal(gmo.z, frame.arrays["distance"])
    for name in ("timeOffsetNs", "scalar", "flags"):
        np.testing.assert_array_equal(getattr(gmo, name), frame.arrays[name])
    assert gmo.timeOffSetNs is gmo.timeOffsetNs or np.array_equal(gmo.timeOffSetNs, gmo.timeOffsetNs)
    for name, channel in CHANNELS.items():
        if channel.level > AuxLevel.NONE:
            expected = frame.arrays.get(name, channel.empty())
            np.testing.assert_array_equal(getattr(gmo, name), expected)
            assert getattr(gmo, name).dtype == channel.dtype


def test_poses_have_quaternions_i_j_k_w():
    gmo = parse_generic_model_output_data(pack(frame_of(1)))

    half = 0.5**0.5
    np.testing.assert_allclose(gmo.frameEnd.orientation, [0, 0, half, half], atol=1e-12)
    np.testing.assert_array_equal(gmo.frameEnd.posM, [1.0, 2.0, 3.0])
    assert (gmo.frameStart.timestampNs, gmo.frameEnd.timestampNs) == (100, 200)


def test_cartesian_frames_hold_metres_in_x_y_z():
    frame = frame_of(4, AuxLevel.NONE, "CARTESIAN")

    gmo = parse_generic_model_output_data(pack(frame))

    np.testing.assert_array_equal(np.stack([gmo.x, gmo.y, gmo.z], axis=1), frame.arrays["xyz"])


def test_scan_complete_is_an_auxiliary_field():
    assert parse_generic_model_output_data(pack(frame_of(1, AuxLevel.BASIC))).scanComplete is True
    assert parse_generic_model_output_data(pack(frame_of(1, AuxLevel.NONE))).scanComplete is False


def test_equal_frames_give_equal_bytes():
    assert pack(frame_of(9)).tobytes() == pack(frame_of(9)).tobytes()


@pytest.mark.parametrize("convert", [bytes, bytearray, memoryview, np.array, lambda b: b.reshape(1, -1)])
def test_bytes_and_arrays_parse_alike(convert):
    assert parse_generic_model_output_data(convert(pack(frame_of(3)))).numElements == 3


assert HEADER.fields is not None
MODALITY_AT = HEADER.fields["modality"][1]


def damaged(offset, dtype, value):
    buffer = pack(frame_of(3))
    buffer[offset : offset + np.dtype(dtype).itemsize].view(dtype)[0] = value
    return buffer


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (None, "no data yet"),
        (np.zeros(0, np.uint8), "0 bytes"),
        (np.zeros(10, np.uint8), "10 bytes"),
        (damaged(0, "<u4", 1), "the magic number is 0x00000001"),
        (damaged(4, "<u4", 2), "layout version 2, this reads 1"),
        (pack(frame_of(3))[:-1], "elements need"),
        (damaged(24, "<u4", 2**31), "elements need"),
        (damaged(MODALITY_AT, "<u4", 99), "not a valid Modality"),
        (140_737_488_355_328, "not a buffer handle"),
        (0, "not a buffer handle"),
        ("text", "empty GenericModelOutput"),
        (object(), "an? object holds no bytes"),
        ({}, "a dict holds no bytes"),
    ],
)
def test_anything_else_warns_and_gives_an_empty_output(data, message):
    with pytest.warns(RuntimeWarning, match=message):
        gmo = parse_generic_model_output_data(data)

    assert isinstance(gmo, GenericModelOutput)
    assert gmo.numElements == 0
    assert len(gmo.x) == len(gmo.velocities) == 0


def test_any_cut_or_flipped_byte_is_survived():
    whole = pack(frame_of(3))
    generator = np.random.default_rng(0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for _ in range(300):
            buffer = whole[: generator.integers(1, len(whole) + 1)].copy()
            buffer[generator.integers(0, min(len(buffer), 200))] ^= generator.integers(1, 256)
            assert parse_generic_model_output_data(buffer).numElements in (0, 3)


def test_fields_and_arrays_are_read_only_and_the_buffer_may_be():
    buffer = pack(frame_of(3))
    buffer.setflags(write=False)

    gmo = parse_generic_model_output_data(buffer)

    assert gmo.numElements == 3
    with pytest.raises(AttributeError, match="numElements is read-only"):
        gmo.numElements = 4
    with pytest.raises(AttributeError, match="posM is read-only"):
        gmo.frameEnd.posM = np.zeros(3)
    with pytest.raises(ValueError, match="read-only"):
        gmo.x[0] = 1.0


def test_fields_of_other_sensors_are_zero_and_empty():
    gmo = parse_generic_model_output_data(pack(frame_of(3)))

    assert (gmo.sensorID, gmo.cycleCnt, gmo.maxRangeM, gmo.numSgws, gmo.numRows, gmo.originX) == (0, 0, 0.0, 0, 0, 0.0)
    assert (gmo.idsVelocities.dtype, len(gmo.idsVelocities)) == (np.float32, 0)
    assert {"rv_ms", "objId", "timeOffSetNs", "numCols"} <= set(dir(gmo))


def test_unknown_fields_are_attribute_errors():
    with pytest.raises(AttributeError, match='GenericModelOutput has no "azimuth"'):
        _ = GenericModelOutput().azimuth


def test_handles_give_objects_back_and_never_addresses():
    frame = frame_of(2)
    number = handle(frame)

    assert resolve(number) is frame
    assert resolve(number + 12345) is None
    assert parse_generic_model_output_data(number).numElements == 2


@pytest.mark.parametrize("dtype", [np.uint8, np.uint32, np.uint64])
def test_object_ids_read_the_same_from_every_width(dtype):
    ids = [1, 2**64, (5 << 96) | 7]
    raw = np.frombuffer(b"".join(i.to_bytes(16, "little") for i in ids), np.uint8)

    assert parse_object_ids(raw.view(dtype)) == ids
    assert parse_object_ids(raw.view(dtype).reshape(3, -1)) == ids


def test_object_ids_of_other_types_are_refused():
    with pytest.raises(ValueError, match="not float32"):
        parse_object_ids(np.zeros(4, np.float32))
    with pytest.raises(ValueError, match="not whole ids"):
        parse_object_ids(np.zeros(5, np.uint32))


def stable_id_map(entries):
    table, labels = b"", b""
    start = 24 * len(entries)
    for number, label in entries.items():
        text = label.encode()
        table += number.to_bytes(16, "little")
        table += len(text).to_bytes(4, "little") + (start + len(labels)).to_bytes(4, "little")
        labels += text
    return np.frombuffer(table + labels + len(entries).to_bytes(4, "little"), np.uint8)


def test_a_stable_id_map_gives_paths_without_trailing_space():
    buffer = stable_id_map({1: "/World/Böx", 2**100 + 3: "/World/Ball  \n"})

    assert parse_stable_id_map_data(buffer) == {1: "/World/Böx", 2**100 + 3: "/World/Ball"}


@pytest.mark.parametrize("buffer", [None, np.zeros(2, np.uint8), np.full(20, 255, np.uint8)])
def test_a_buffer_that_is_not_a_map_warns(buffer):
    with pytest.warns(RuntimeWarning, match="empty StableIdMap"):
        assert parse_stable_id_map_data(buffer) == {}
