"""Object ids of returns: 128-bit numbers, and the map from them to prim paths."""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

_WORDS = {np.dtype(np.uint8): 16, np.dtype(np.uint32): 4, np.dtype(np.uint64): 2}
ENTRY = np.dtype([("id", "<u4", 4), ("length", "<u4"), ("offset", "<u4")])


EXTENSION = 0x49445354
"""Marks, as the fourth word from the end of a map, a second table: the ids that the documented format does not have."""


def stable_id(path: str) -> bytes:
    """The 16 bytes of a surface's id, the same in every session: 12 determined by its prim path, then the high 32 bits.

    The high bits are 0 for a prim and for a GeomSubset, and 1 + n for copy n of a point instancer ("/World/Rocks[7]",
    "/World/Rocks[7]/Lid"): such copies have no prim.
    """
    prim, bracket, rest = path.partition("[")
    number, _, below = rest.partition("]")
    copy = int(number) + 1 if bracket else 0
    return hashlib.blake2b(f"{prim}{below}".encode(), digest_size=12).digest() + copy.to_bytes(4, "little")


def has_prim(path: str) -> bool:
    """Whether a surface is a prim (or GeomSubset), so that the documented map contains it."""
    return "[" not in path


def stable_id_map(paths: Iterable[str]) -> dict[int, str]:
    """Id -> path of all surfaces; prims first, then the copies of point instancers."""
    ordered = sorted(dict.fromkeys(paths), key=lambda path: not has_prim(path))
    return {int.from_bytes(stable_id(path), "little"): path for path in ordered}


def pack_stable_id_map(entries: Mapping[int, str]) -> np.ndarray:
    """A StableIdMap buffer, (size,) uint8, that `parse_stable_id_map_data` reads.

    The documented part has its documented place: the table of the ids of prims and GeomSubsets at the start, the number
    of its entries in the last word. Our extension is between the labels and that word: the table of all other ids, then
    its offset, its number of entries and `EXTENSION` (u32 each).
    """
    documented = {number: path for number, path in entries.items() if has_prim(path)}
    others = {number: path for number, path in entries.items() if not has_prim(path)}
    first = _tables(documented, 0)
    first += b" " * (-len(first) % 4)
    second = _tables(others, len(first))
    second += b" " * (-len(second) % 4)
    tail = np.array([len(first), len(others), EXTENSION, len(documented)], "<u4").tobytes()
    return np.frombuffer(first + second + tail, np.uint8).copy()


def _tables(entries: Mapping[int, str], start: int) -> bytes:
    """A table at byte `start` of a map, and its labels."""
    texts = [path.encode() for path in entries.values()]
    table = np.zeros(len(texts), ENTRY)
    lengths = np.array([len(text) for text in texts], np.uint32)
    for row, number in zip(table, entries, strict=True):
        row["id"] = np.frombuffer(number.to_bytes(16, "little"), "<u4")
    table["length"] = lengths
    table["offset"] = start + table.nbytes + np.cumsum(lengths) - lengths
    return table.tobytes() + b"".join(texts)


def parse_object_ids(array: Any) -> list[int]:
    """128-bit ids as Python integers, from rows of 16 uint8, 4 uint32 or 2 uint64 (little-endian).

    Raises ValueError for any other dtype, and for an array that is not a whole number of ids.
    """
    values = np.ascontiguousarray(array)
    words = _WORDS.get(values.dtype)
    if words is None:
        raise ValueError(f"object ids are uint8, uint32 or uint64 arrays, not {values.dtype}")
    if values.size % words:
        raise ValueError(f"{values.size} values of {values.dtype} are not whole ids of {words}")
    halves = values.reshape(-1).view("<u8").reshape(-1, 2).tolist()
    return [low | high << 64 for low, high in halves]


def parse_stable_id_map_data(buffer: Any, *, resolve_all: bool = False) -> dict[int, str]:
    """Id -> prim path of a StableIdMap buffer (array of any dtype, bytes, or one of our handles).

    Its last 4 bytes are the number of entries (u32); the table starts at offset 0 with 24 bytes an entry: id (4 x u32,
    little-endian), length and offset (u32 each, from the start of the buffer) of the path in UTF-8, whose trailing
    white space is dropped. As documented it has prims and GeomSubsets, but not the ids whose high 32 bits distinguish
    copies; resolve_all: those too, so that every hit of the frame has a path ("/World/Rocks[7]" is copy 7 of a point
    instancer). A missing or inconsistent buffer gives an empty map and a warning.
    """
    if isinstance(buffer, (int, np.integer)):
        from sensors.handles import resolve

        buffer = resolve(int(buffer))
    if buffer is None:
        return _nothing("no data yet")
    try:
        data = np.frombuffer(bytes(buffer), np.uint8) if isinstance(buffer, _BYTES) else _bytes_of(buffer)
    except (TypeError, ValueError) as error:
        return _nothing(str(error))
    if len(data) < 4:
        return _nothing(f"{len(data)} bytes are no StableIdMap") if len(data) else {}
    count = int.from_bytes(data[-4:].tobytes(), "little")
    try:
        found = _entries(data, 0, count)
        tail = np.frombuffer(data[-16:-4].tobytes(), "<u4")
        if resolve_all and len(tail) == 3 and tail[2] == EXTENSION:
            found |= _entries(data, int(tail[0]), int(tail[1]))
    except ValueError as error:
        return _nothing(str(error))
    return found


_BYTES = (bytes, bytearray, memoryview)


def _bytes_of(data: Any) -> np.ndarray:
    array = np.ascontiguousarray(data.numpy() if hasattr(data, "numpy") else data)
    if array.dtype.kind not in "uib":
        raise ValueError(f"a {array.dtype} array is not a StableIdMap")
    return array.reshape(-1).view(np.uint8)


def _entries(data: np.ndarray, start: int, count: int) -> dict[int, str]:
    """The entries of one table of a map. Raises ValueError if the buffer is too short for them."""
    end = start + count * ENTRY.itemsize
    if end > len(data) - 4:
        raise ValueError(f"{count} entries do not fit into {len(data)} bytes")
    found = {}
    for number, length, offset in np.frombuffer(data[start:end].tobytes(), ENTRY).tolist():
        if offset + length > len(data):
            raise ValueError("an entry points past the end of the buffer")
        text = data[offset : offset + length].tobytes().decode("utf-8", errors="replace")
        found[sum(int(word) << 32 * place for place, word in enumerate(number))] = text.rstrip()
    return found


def _nothing(reason: str) -> dict[int, str]:
    warnings.warn(f"empty StableIdMap: {reason}", RuntimeWarning, stacklevel=3)
    return {}
