"""Tables of numbers in OpenEXR files: reading them, and values between their texels.

First rows are on top; texels are about the middles of equal parts of the image.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.base.extras import install_command
from graph.base.inputs import digest
from graph.base.limits import check
from graph.base.silence import silenced

from .image_files import ImageFiles, ImageProblem
from .lens import Floats

BACKWARD = np.array([0.0, 0.0, 1.0])
"""Marks a texel without a direction."""


def between(table: Floats, across: Floats, down: Floats) -> Floats:
    """(c, n) of a table (h, w, c) between the four texels about places from 0 to 1; its edge beyond."""
    height, width, _ = table.shape
    found = np.zeros((table.shape[2], len(across)))
    with np.errstate(invalid="ignore"):
        x, y = np.nan_to_num(across * width - 0.5), np.nan_to_num(down * height - 0.5)
    left, top = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    for row, tall in ((top, 1 - (y - top)), (top + 1, y - top)):
        for column, wide in ((left, 1 - (x - left)), (left + 1, x - left)):
            texel = table[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
            found += texel.T * (tall * wide)
    return found


def read_directions(prim: Any, name: str, files: ImageFiles) -> tuple[Floats, str]:
    """The unit directions of a table, (h, w, 3) float64 in optical axes, 0 for none; and a key of the file's content.

    The file has them in red, green, blue: x right, y up, looking along -z. Raises UserError as `read_table` does.
    """
    found, key = read_table(prim, name, files)
    if found.shape[2] < 3:
        raise UserError(f"{prim.GetPath()}.{name} has {found.shape[2]} channels; a table of directions has three")
    directions = found[..., :3].astype(np.float64) * (1.0, -1.0, -1.0)
    none = ~np.isfinite(directions).all(axis=2) | (np.abs(found[..., :3] - BACKWARD) < 1e-6).all(axis=2)
    directions[none] = 0
    return directions, key


def read_table(prim: Any, name: str, files: ImageFiles) -> tuple[Floats, str]:
    """The image that an attribute names, (h, w, c) float, and a key of its content.

    Raises UserError, naming the attribute, for a file that is missing, is not allowed or is damaged, and without
    OpenEXR.
    """
    where = f"{prim.GetPath()}.{name}"
    if not prim.HasAttribute(name):
        raise UserError(f"{where} is missing; name the table")
    try:
        file = files.allowed(prim.GetAttribute(name))
    except ImageProblem as problem:
        raise UserError(f"{where}: {problem}") from None
    try:
        import OpenEXR
    except ImportError:
        raise UserError(f"{where} is an OpenEXR file. Run: {install_command('exr')}") from None
    return _read(OpenEXR, file, where)


def _read(library: Any, file: Path, where: str) -> tuple[Floats, str]:
    try:
        with silenced():  # it prints what is wrong with a damaged file
            with library.File(str(file), header_only=True) as image:
                low, high = image.header()["dataWindow"]
            width, height = (int(side) + 1 for side in np.subtract(high, low))
            check("camera.texels", width * height, f"{where}: {width:,} x {height:,} pixels")
            with library.File(str(file), separate_channels=True) as image:
                planes = {name: channel.pixels for name, channel in image.channels().items()}
    except UserError:
        raise
    except Exception as error:  # the library raises several kinds for damaged files
        raise UserError(f"{where}: {file.name} cannot be read ({' '.join(str(error).split())})") from None
    found = [planes[name] for name in "RGB" if name in planes]
    if not found:
        raise UserError(f"{where}: {file.name} has no channels R, G, B; it has {', '.join(planes)}")
    return np.stack(found, axis=2), digest(file)
