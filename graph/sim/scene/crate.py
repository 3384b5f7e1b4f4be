"""Checks a binary layer (.usdc) before USD's reader reads it: the sizes that it states, and its tree of paths.

A crate file begins with PXR-USDC, eight bytes of version and the offset of its table of contents: a count, then name
(16 bytes), start and size of each section. A section begins with numbers of entries, followed by packed blocks, each
with its size before it. FIELDS holds a word for each value: flags, type, and where in the file the value lies (OpenUSD,
crateFile.cpp and crateDataTypes.h, since version 0.4). The reader allocates as much memory as the numbers say.

PATHS holds the number of paths, that of the table's entries, and three packed lists of whole numbers; the third are the
jumps: -2 is a leaf and the last of its siblings, -1 the last of its siblings with children, 0 a leaf whose sibling
follows, any other number the way to the sibling of an entry with children (integerCoding.cpp). In a damaged table
several entries lead to the same one, and the reader's walk takes time and memory that double with each.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from graph.base.inputs import opened

_SECTIONS = {
    b"TOKENS": (2, 1),
    b"STRINGS": (1, 0),
    b"FIELDS": (1, 2),
    b"FIELDSETS": (1, 1),
    b"PATHS": (2, 3),
    b"SPECS": (1, 3),
}
"""The number of counts and of packed blocks in each section. TOKENS: the second count is in bytes."""
_SECTION = 32
"""Bytes of an entry of the table of contents."""
_ARRAY, _INLINED, _COMPRESSED = 1 << 63, 1 << 62, 1 << 61
_VECTORS, _LIST_OPS = (31, 40, 41, 45, 48, 49, 50), (32, 33, 34, 35, 36, 37, 38, 39, 54, 55)
"""Types that begin with a count, and types that begin with a byte of flags and a count."""
_OLD = b"\0\7\0"
"""Arrays of files before this version count in 32 bits."""


def crate_entries(path: Path) -> int:
    """The largest count of entries that a table or value of a crate file states; 0 for other and too short files.

    A table, block or unpacked value that does not fit into the file counts with the entries that it states.
    """
    with opened(path) as file:
        if file.read(8) != b"PXR-USDC":
            return 0
        most = 0
        try:
            for count in _counts(file, path.stat().st_size):
                most = max(most, count)
        except (struct.error, OSError, ValueError, IndexError):  # USD reports the mistake
            pass
        return most


def _counts(file: BinaryIO, length: int) -> Iterator[int]:
    version = file.read(8)[:3]
    file.seek(_number(file))
    count = _number(file)
    if count * _SECTION > length:
        yield count * _SECTION
        return
    sections = [struct.unpack("<16sqq", file.read(_SECTION)) for _ in range(count)]
    for name, start, _ in sections:
        numbers, blocks = _SECTIONS.get(name.rstrip(b"\0"), (0, 0))
        file.seek(max(start, 0))
        entries = [_number(file) for _ in range(numbers)]
        yield from entries
        packed = b""
        for _ in range(blocks if version >= b"\0\4\0" else 0):
            size = _number(file)
            if size > length:
                yield size
                return
            packed = file.read(size)
        if name.startswith(b"FIELDS\0") and packed:
            yield from _values(file, length, version, packed, entries[0])


def _values(file: BinaryIO, length: int, version: bytes, packed: bytes, count: int) -> Iterator[int]:
    """The sizes that the values of all fields state."""
    import numpy as np
    from lz4.block import LZ4BlockError, decompress

    if packed[0] or count > 255 * len(packed):  # several chunks: larger than any file that is checked in full
        return
    try:
        words = np.frombuffer(decompress(packed[1:], uncompressed_size=count * 8), "<u8")
    except (LZ4BlockError, MemoryError, OverflowError):
        return
    words = np.sort(words)
    for word in words[np.append(True, words[1:] != words[:-1])].tolist():  # np.unique would import numpy.ma
        kind, place = (word >> 48) & 0xFF, word & (2**48 - 1)
        if word & _INLINED or not place:
            continue
        file.seek(place)
        if word & _ARRAY:
            size = _number(file) if version >= _OLD else struct.unpack("<I", file.read(4))[0]
            if word & _COMPRESSED or size > length:
                yield size
        elif kind in _VECTORS or kind in _LIST_OPS:
            flags = file.read(1)[0] if kind in _LIST_OPS else 2
            size = _number(file) if flags > 1 else 0
            if size > length:
                yield size


def _number(file: BinaryIO) -> int:
    [number] = struct.unpack("<Q", file.read(8))
    return int(number)


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
