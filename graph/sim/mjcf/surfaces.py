"""Surfaces that only MuJoCo has (height fields, and its meshes) as points and triangles."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.sim.geometry.tessellation import Triangles
from graph.sim.transforms import Floats


def mesh(model: Any, number: int) -> tuple[Floats, Triangles]:
    """Vertices (n, 3) [m] and triangles (m, 3) of a mesh of the model, in the frame of its geoms."""
    first, count = model.mesh_vertadr[number], model.mesh_vertnum[number]
    face, faces = model.mesh_faceadr[number], model.mesh_facenum[number]
    triangles: Triangles = model.mesh_face[face : face + faces].astype(np.uint32)
    return model.mesh_vert[first : first + count].astype(np.float64), triangles


def height_field(model: Any, number: int) -> tuple[Floats, Triangles]:
    """The closed surface of a height field: its top as MuJoCo collides with it, its four sides and its underside [m].

    Each cell of the top is cut from its corner of least x and y to the opposite one, as MuJoCo cuts it.
    """
    rows, columns = int(model.hfield_nrow[number]), int(model.hfield_ncol[number])
    half_x, half_y, height, depth = map(float, model.hfield_size[number])
    start = model.hfield_adr[number]
    heights = model.hfield_data[start : start + rows * columns].astype(np.float64) * height
    y, x = np.meshgrid(np.linspace(-half_y, half_y, rows), np.linspace(-half_x, half_x, columns), indexing="ij")
    top = np.stack([x.ravel(), y.ravel(), heights], axis=1)
    grid = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (part.ravel() for part in (grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]))
    upper = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])

    # Once around the edge, counter-clockwise seen from above, so that the sides face out.
    edge = np.concatenate([grid[0, :-1], grid[:-1, -1], grid[-1, :0:-1], grid[:0:-1, 0]])
    below = top[edge].copy()
    below[:, 2] = -depth
    low = len(top) + np.arange(len(edge))
    following, low_following = np.roll(edge, -1), np.roll(low, -1)
    sides = np.concatenate(
        [np.stack([edge, low, low_following], axis=1), np.stack([edge, low_following, following], axis=1)]
    )
    corners = low[[0, columns - 1, columns + rows - 2, 2 * columns + rows - 3]]
    under = np.array([[corners[0], corners[2], corners[1]], [corners[0], corners[3], corners[2]]])
    return np.concatenate([top, below]), np.concatenate([upper, sides, under]).astype(np.uint32)


def flex(model: Any, number: int) -> Triangles | None:
    """The triangles (m, 3) of a cloth's faces or of a solid's skin, by vertex of the flex.

    None for a one-dimensional flex.
    """
    if model.flex_dim[number] == 2:
        first, count = model.flex_elemdataadr[number], model.flex_elemnum[number]
        found: Triangles = model.flex_elem[first : first + 3 * count].reshape(-1, 3).astype(np.uint32)
        return found
    if model.flex_dim[number] == 3:
        first, count = model.flex_shelldataadr[number], model.flex_shellnum[number]
        skin: Triangles = model.flex_shell[first : first + 3 * count].reshape(-1, 3).astype(np.uint32)
        return skin
    return None
