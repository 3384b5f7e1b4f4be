"""Object ids of returns: 128-bit numbers, and the map from them to prim paths."""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

_WORDS = {np.dtype(np.uint8): 16, np.dtype(np.uint32): 4, np.dtype(np.uint64): 2}
ENTRY = np.dtype([("id", "<u4", 4), ("length", "<u4"), ("offset", "<u4")])


def stable_id(path: str) -> bytes:
    """The 16 bytes of a surface's id, the same in every session: 12 that its prim path decides, then the high 32 bits.

    These are 0 for a prim, and 1 + n for copy n of a point instancer ("/World/Rocks[7]"), whose ids are therefore not
    in the map.
    """
    prim, bracket, rest = path.partition("[")
    copy = int(rest.rstrip("]")) + 1 if bracket else 0
    return hashlib.blake2b(prim.encode(), digest_size=12).digest() + copy.to_bytes(4, "little")


def stable_id_map(paths: Iterable[str]) -> dict[int, str]:
    """Id -> path of the prims among surfaces; copies of point instancers have no entry."""
    return {int.from_bytes(stable_id(path), "little"): path for path in paths if "[" not in path}


def pack_stable_id_map(entries: Mapping[int, str]) -> np.ndarray:
    """A StableIdMap buffer, (size,) uint8, that `parse_stable_id_map_data` reads."""
    texts = [path.encode() for path in entries.values()]
    table = np.zeros(len(texts), ENTRY)
    lengths = np.array([len(text) for text in texts], np.uint32)
    for row, number in zip(table, entries, strict=True):
        row["id"] = np.frombuffer(number.to_bytes(16, "little"), "<u4")
    table["length"] = lengths
    table["offset"] = table.nbytes + np.cumsum(lengths) - lengths
    data = table.tobytes() + b"".join(texts) + len(texts).to_bytes(4, "little")
    return np.frombuffer(data, np.uint8).copy()


def parse_object_ids(array: Any) -> list[int]:
    """128-bit ids as Python integers, from rows of 16 uint8, 4 uint32 or 2 uint64 (little-endian).

    Raises ValueError for any other dtype, and for an array that does not divide into whole ids.
    """
    values = np.ascontiguousarray(array)
    words = _WORDS.get(values.dtype)
    if words is None:
        raise ValueError(f"object ids are uint8, uint32 or uint64 arrays, not {values.dtype}")
    if values.size % words:
        raise ValueError(f"{values.size} values of {values.dtype} are not whole ids of {words}")
    halves = values.reshape(-1).view("<u8").reshape(-1, 2).tolist()
    return [low | high << 64 for low, high in halves]


def parse_stable_id_map_data(buffer: Any) -> dict[int, str]:
    """Id -> prim path of a StableIdMap buffer.

    Its last 4 bytes are the number of entries (u32); the table starts at offset 0 with 24 bytes an entry: id (4 x u32,
    little-endian), length and offset (u32 each, from the start of the buffer) of the path in UTF-8, whose trailing
    white space is dropped. No buffer, or one that does not hold what it says, gives an empty map and a warning.
    """
    if buffer is None:
        return _nothing("no data yet")
    data = np.frombuffer(buffer, np.uint8) if isinstance(buffer, (bytes, bytearray)) else np.ascontiguousarray(buffer)
    data = data.reshape(-1).view(np.uint8)
    if len(data) < 4:
        return _nothing(f"{len(data)} bytes are no StableIdMap") if len(data) else {}
    count = int(data[-4:].view("<u4")[0])
    if count * ENTRY.itemsize > len(data) - 4:
        return _nothing(f"{count} entries do not fit into {len(data)} bytes")
    found = {}
    for number, length, offset in data[: count * ENTRY.itemsize].view(ENTRY).tolist():
        if offset + length > len(data):
            return _nothing("an entry points past the end of the buffer")
        text = data[offset : offset + length].tobytes().decode("utf-8", errors="replace")
        found[sum(int(word) << 32 * place for place, word in enumerate(number))] = text.rstrip()
    return found


def _nothing(reason: str) -> dict[int, str]:
    warnings.warn(f"empty StableIdMap: {reason}", RuntimeWarning, stacklevel=3)
    return {}
