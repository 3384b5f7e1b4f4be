"""The bodies that prims follow, and the prims' poses in the bodies' frames."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.base.errors import RunError
from graph.base.records import dataclass
from graph.sim import transforms
from graph.sim.transforms import Floats


@dataclass(frozen=True)
class Binding:
    """The body that each of some prims follows (-1: none), by row and path, and its matrix in that body's rigid
    frame.
    """

    bodies: NDArray[np.intp]
    names: tuple[str, ...]
    offsets: Floats


def bind(
    stage: Any,
    paths: tuple[str, ...],
    body_of: Callable[[str], str | None],
    rows: Mapping[str, int],
    residuals: Mapping[str, Floats],
    offset: Callable[[str], Floats | None],
) -> Binding:
    """Binds prims to the bodies with which they move. Raises RunError for a prim that is not on the stage.

    body_of: the body of a prim, None without one. rows, residuals: of the bodies, by path; see `scale_and_shear`.
    offset: where a user has placed a prim in the frame of its body, None where the stage has it.
    """
    from graph.sim.usd import EARLIEST, UsdGeom

    xforms = UsdGeom.XformCache(EARLIEST)
    bodies = np.full(len(paths), -1, dtype=np.intp)
    offsets = np.empty((len(paths), 4, 4))
    names = [""] * len(paths)
    for number, path in enumerate(paths):
        prim = stage.GetPrimAtPath(path) if path.startswith("/") else None
        if not prim:
            raise RunError(f"{path}: no such prim on the stage")
        body = body_of(path)
        if body is None:
            offsets[number] = transforms.from_usd(xforms.GetLocalToWorldTransform(prim))
            continue
        bodies[number], names[number] = rows[body], body
        placed = offset(path)
        if placed is not None:
            offsets[number] = placed
            continue
        # Composed from the body downwards: where the body itself stands on the stage leaves no trace in it.
        relative, _ = xforms.ComputeRelativeTransform(prim, stage.GetPrimAtPath(body))
        offsets[number] = residuals[body] @ transforms.from_usd(relative)
    return Binding(bodies, tuple(names), offsets)


def scale_and_shear(stage: Any, path: str) -> Floats:
    """(4, 4) The scale and shear of a body's transform on the stage, which its pose does not contain."""
    from graph.sim.usd import EARLIEST, UsdGeom

    prim = stage.GetPrimAtPath(path)
    world = transforms.from_usd(UsdGeom.XformCache(EARLIEST).GetLocalToWorldTransform(prim))
    out = transforms.inverse_rigid(transforms.rigid_part(world)) @ world
    out[:3, 3] = 0.0
    return out
