"""Checks the sizes stated in a binary layer (.usdc) before USD's reader allocates that much memory.

A crate file begins with PXR-USDC, eight bytes of version and the offset of its table of contents: a count, then name
(16 bytes), start and size of each section. A section begins with numbers of entries, followed by packed blocks, each
with its size before it. FIELDS holds a word for each value: flags, type, and where in the file the value lies (OpenUSD,
crateFile.cpp and crateDataTypes.h, since version 0.4).
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

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
