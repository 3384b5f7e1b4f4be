"""The tree of paths in a binary layer (.usdc), looked at before USD's reader follows it.

The reader walks a table of jumps: an entry has its first child behind it and its next sibling so many entries on. In a
damaged table several entries lead to the same one, and the walk takes time and memory that double with each.

PATHS holds the number of paths, that of the table's entries, and three packed lists of whole numbers; the third are the
jumps: -2 is a leaf and the last of its siblings, -1 the last of its siblings with children, 0 a leaf whose sibling
follows, any other number the way to the sibling of an entry with children (OpenUSD, crateFile.cpp and
integerCoding.cpp, since version 0.4).
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from graph.base.inputs import opened

_SECTION = 32


def has_path_tree(path: Path) -> bool:
    """Whether each entry of a crate file's table of paths is reached once; True for other files.

    Tables that this reads differently from USD, or cannot read, count as good: USD says what is wrong with them.
    """
    from lz4.block import LZ4BlockError

    with opened(path) as file:
        if file.read(8) != b"PXR-USDC" or file.read(8)[:3] < b"\0\4\0":
            return True
        try:
            jumps = _jumps(file)
        except (struct.error, OSError, ValueError, IndexError, TypeError, OverflowError, MemoryError, LZ4BlockError):
            return True
    if not len(jumps):
        return True
    place = np.arange(len(jumps))
    reached = np.sort(np.concatenate([place[jumps != -2] + 1, (place + jumps)[jumps > 0]]))
    return bool(np.array_equal(reached, place[1:]))


def _jumps(file: BinaryIO) -> NDArray[np.int64]:
    """The table of jumps; empty for a file without one."""
    file.seek(struct.unpack("<Q", file.read(8))[0])
    for _ in range(struct.unpack("<Q", file.read(8))[0]):
        name, start, _ = struct.unpack("<16sqq", file.read(_SECTION))
        if name.startswith(b"PATHS\0"):
            file.seek(start + 8)
            [count] = struct.unpack("<Q", file.read(8))
            packed = b""
            for _ in range(3):
                packed = file.read(struct.unpack("<Q", file.read(8))[0])
            return _unpacked(packed, count)
    return np.zeros(0, np.int64)


def _unpacked(packed: bytes, count: int) -> NDArray[np.int64]:
    """Whole numbers as USD packs them: LZ4 over differences, 2 bits for the size of each, the commonest in none."""
    from lz4.block import decompress

    codes_end = 4 + (2 * count + 7) // 8
    if packed[0] or codes_end > 256 * len(packed):  # several chunks, or more than LZ4 can have packed
        return np.zeros(0, np.int64)
    data = np.frombuffer(decompress(packed[1:], uncompressed_size=codes_end + 4 * count), np.uint8)
    codes = ((data[4:codes_end, None] >> np.array([0, 2, 4, 6], np.uint8)) & 3).reshape(-1)[:count]
    sizes = np.array([0, 1, 2, 4])[codes]
    starts = codes_end + np.cumsum(sizes) - sizes
    out = np.full(count, int(data[:4].view("<i4")[0]), np.int64)
    for code, kind in ((1, "<i1"), (2, "<i2"), (3, "<i4")):
        at = starts[codes == code]
        size = np.dtype(kind).itemsize
        out[codes == code] = data[at[:, None] + np.arange(size)].reshape(-1).view(kind)
    return np.cumsum(out)
