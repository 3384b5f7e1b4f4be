"""Reads Radiance pictures (.hdr): red, green, blue and a common exponent, a byte each.

Format: G. Ward, "Real Pixels", Graphics Gems II (1991), and the run lengths of Radiance's `color.c`.
"""

from __future__ import annotations

import re

import numpy as np

MAGIC = (b"#?RADIANCE", b"#?RGBE")
_SIZE = re.compile(rb"-Y (\d{1,6}) \+X (\d{1,6})\n")


def picture_size(data: bytes) -> tuple[int, int, int]:
    """Width and height, and where the pixels begin. Raises ValueError for other layouts."""
    end = data.find(b"\n\n", 0, 1 << 16)
    found = _SIZE.match(data, end + 2) if end >= 0 else None
    if found is None or b"32-bit_rle_xyze" in data[:end]:
        raise ValueError("its header is not that of rows of RGBE from the top")
    return int(found[2]), int(found[1]), found.end()


def decoded(data: bytes) -> np.ndarray:
    """(height, width, 4) uint8. Raises ValueError for damaged pictures."""
    width, height, place = picture_size(data)
    bytes_ = np.frombuffer(data, np.uint8)
    if not (8 <= width < 1 << 15) or bytes(data[place : place + 2]) != b"\x02\x02":
        flat = bytes_[place : place + 4 * width * height]
        if flat.size < 4 * width * height:
            raise ValueError("it ends too early")
        return flat.reshape(height, width, 4).copy()
    out = np.empty((height, 4, width), np.uint8)
    for row in range(height):
        if data[place : place + 4] != bytes((2, 2, width >> 8, width & 255)):
            raise ValueError("a row has another length")
        place = _row(data, bytes_, place + 4, out[row])
    return np.ascontiguousarray(np.moveaxis(out, 1, 2))


def _row(data: bytes, bytes_: np.ndarray, place: int, out: np.ndarray) -> int:
    """Unpacks one row into (4, width); returns where the next one begins."""
    width = out.shape[1]
    for channel in out:
        at = 0
        while at < width:
            if place + 1 >= len(data):
                raise ValueError("it ends too early")
            count = data[place]
            run = count > 128
            count -= 128 * run
            if not count or at + count > width:
                raise ValueError("a run is longer than its row")
            if run:
                channel[at : at + count] = data[place + 1]
                place += 2
            else:
                if place + 1 + count > len(data):
                    raise ValueError("it ends too early")
                channel[at : at + count] = bytes_[place + 1 : place + 1 + count]
                place += 1 + count
            at += count
    return place
