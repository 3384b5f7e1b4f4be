"""Binary layers that state sizes beyond their own."""

import struct

import pytest

from graph.base import limits
from graph.base.errors import UserError
from graph.sim.scene.crate import crate_entries
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
