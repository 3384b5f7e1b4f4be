"""Binary layers that state sizes beyond their own."""

import struct

import lz4.block
import pytest

from graph.base import limits
from graph.base.errors import UserError
from graph.sim.scene.crate import crate_entries, has_path_tree
from graph.sim.scene.stage import open_stage
from graph.sim.usd import Sdf


@pytest.fixture
def crate(tmp_path):
    """A binary layer of 100 prims, with an array of 3,000 numbers."""
    layer = Sdf.Layer.CreateAnonymous()
    for number in range(100):
        Sdf.CreatePrimInLayer(layer, f"/P{number}")
    attribute = Sdf.AttributeSpec(layer.GetPrimAtPath("/P0"), "numbers", Sdf.ValueTypeNames.IntArray)
    attribute.default = list(range(3000))
    layer.Export(str(tmp_path / "a.usdc"))
    return tmp_path / "a.usdc"


def test_the_largest_table_or_value_is_reported(crate):
    assert crate_entries(crate) == 3000  # the array: 101 paths and some hundred bytes of texts are fewer


def test_a_text_and_a_short_file_have_no_tables(tmp_path):
    (tmp_path / "a.usda").write_text("#usda 1.0\n")
    (tmp_path / "b.usdc").write_bytes(b"PXR-USDC" + b"\xff" * 20)
    assert [crate_entries(tmp_path / name) for name in ("a.usda", "b.usdc")] == [0, 0]


def test_a_binary_layer_opens_at_the_limit_and_not_beyond(crate):
    with limits.raised({"usd.entries": 3000}):
        open_stage(crate)
    with (
        limits.raised({"usd.entries": 2999}),
        pytest.raises(UserError, match=r"3,000 entries; .*usd\.entries=N"),
    ):
        open_stage(crate)


def test_a_table_of_contents_larger_than_the_file_is_refused_unread(crate):
    data = bytearray(crate.read_bytes())
    place = struct.unpack_from("<q", data, 16)[0]
    struct.pack_into("<Q", data, place, 2**27)
    crate.write_bytes(data)
    assert crate_entries(crate) == 2**27 * 32
    with pytest.raises(UserError, match=r"a\.usdc says that it has 4,294,967,296 entries"):
        open_stage(crate)


def jumps_of(crate):
    """Where the packed jumps of a file's paths lie, and their size: the third list of the section PATHS."""
    data = crate.read_bytes()
    table = struct.unpack_from("<Q", data, 16)[0]
    for number in range(struct.unpack_from("<Q", data, table)[0]):
        name, start, _ = struct.unpack_from("<16sqq", data, table + 8 + 32 * number)
        if name.startswith(b"PATHS"):
            place = start + 16
            for _ in range(3):
                size = struct.unpack_from("<Q", data, place)[0]
                place += 8 + size
            return place - size, size
    return None


@pytest.mark.parametrize("count", [0, 1, 2, 300, 70_000])
def test_the_paths_of_a_whole_layer_are_a_tree(tmp_path, count):
    layer = Sdf.Layer.CreateAnonymous()
    with Sdf.ChangeBlock():
        for number in range(count):
            Sdf.CreatePrimInLayer(layer, f"/P{number % 7}/Q{number // 7}" + "/R" * (number % 3))
    layer.Export(str(tmp_path / "a.usdc"))
    assert has_path_tree(tmp_path / "a.usdc")


def test_a_table_whose_entries_meet_is_refused_before_usd_walks_it(crate):
    """Each of 102 entries has a child behind it and a sibling two on: as many ways to the last as Fibonacci's 101st."""
    place, size = jumps_of(crate)
    # A jump of 2, and after it differences of 0, the commonest: code 1 is a byte, code 0 the commonest.
    count = 102
    plain = struct.pack("<i", 0) + bytes([1]) + bytes((2 * count + 7) // 8 - 1) + bytes([2])
    packed = b"\0" + lz4.block.compress(plain, store_size=False)
    data = bytearray(crate.read_bytes())
    assert len(packed) <= size
    data[place : place + len(packed)] = packed
    struct.pack_into("<Q", data, place - 8, len(packed))
    crate.write_bytes(data)
    assert not has_path_tree(crate)
    with pytest.raises(UserError, match=r"a\.usdc is damaged: its table of paths is not a tree; repair it$"):
        open_stage(crate)
