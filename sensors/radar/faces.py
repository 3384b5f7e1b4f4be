"""The flat faces of one mesh: which triangles make up a plane, and how the surface bends from plane to plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sensors.compiled import compiled

from .grouping import Groups

SMOOTH = np.cos(np.deg2rad(40.0))
"""Cosine of the angle between two neighbouring faces up to which they stand for one curved surface."""

FLAT = 1.0 - 1e-8
"""Cosine from which on two faces are one plane."""

ROUNDED = 1e-6
"""What float32 may be off by in a flat face, over the largest coordinate of its mesh: some roundings of 6e-8 each."""

LEAST_M, MOST_M = 2e-6, 5e-5
"""Corners so near a plane are in it, whatever the coordinates are: down to 0.4 deg and up to 10 deg of phase."""

TURNED = 1.0 - 5e-4
"""Cosine of the angle (32 mrad) beyond which two faces are not one plane, however small they are."""

SEAM = 4.0
"""A face so many times as long as its neighbour does not bend where they meet: a rounding, or the cap of a rod."""

POLE = 8
"""More faces than these around a vertex make it a pole."""

SPREAD = 1.0 / 8.0
"""Share of the squared angles to the neighbours that a face's normals are spread by: the lobes of faces at equal steps
then add up to a curve without ripple (below 0.1 dB along one axis)."""

TOUCHING_M = 1e-3
"""Flat faces of different meshes so near each other are pieces of one."""

MOST_TILES = 1000
"""Faces of a plane up to which it is looked up which of them touch; beyond, each is for itself."""

_HASH = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0x27D4EB2F165667C5], np.uint64)


Shape = tuple[np.ndarray, np.ndarray]
"""Vertices (n, 3) float64 [m] and triangles (m, 3) int64 of a mesh."""


@dataclass(frozen=True, slots=True)
class Faces:
    """The planes of one mesh, in its frame; p of them.

    of_triangle: (m,) int32, the plane of each triangle. normal: (p, 3), offset: (p,) [m]: n . x = offset. middle:
    (p, 3) [m] of its area. axes: (p, 2, 3), two unit vectors in the plane. curved: (p,) bool, whether it is a piece of
    a curved surface; then spread: (p, 2, 2) covariance of the surface's normals [rad^2], extent: (p, 2, 2) of its area
    [m^2] and bend: (p, 2, 2), by how much the surface's normal turns along it [rad/m], in the axes. low, high: (p, 3)
    [m], the box around each.
    """

    of_triangle: np.ndarray
    normal: np.ndarray
    offset: np.ndarray
    middle: np.ndarray
    axes: np.ndarray
    curved: np.ndarray
    spread: np.ndarray
    extent: np.ndarray
    bend: np.ndarray
    low: np.ndarray
    high: np.ndarray


def faces_of(meshes: Sequence[Shape]) -> list[Faces]:
    """The planes of each of some meshes, which are worked out together: most of them are small."""
    first = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    vertices = np.concatenate([each for each, _ in meshes])
    triangles = np.concatenate([each + start for (_, each), start in zip(meshes, first, strict=False)])
    sizes = np.array([len(each) for _, each in meshes])
    mesh, starts = np.repeat(np.arange(len(meshes)), sizes), np.cumsum(sizes) - sizes
    corners = vertices[triangles]
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(doubled, axis=1)
    normals = doubled / np.where(twice, twice, 1.0)[:, None]
    centres = corners.mean(axis=1)
    offsets = np.einsum("ij,ij->i", normals, centres)
    apart = hashed(np.arange(len(meshes))[:, None])
    keys = hashed(np.rint(np.c_[normals * 1e4, offsets * 1e4]).astype(np.int64)) ^ apart[mesh]
    of_triangle = _ranks(keys)
    keys = hashed(np.rint(vertices * 1e6).astype(np.int64)) ^ np.repeat(apart, np.diff(first))
    welded = _ranks(keys)
    known = np.empty(int(welded.max()) + 1, np.intp)
    known[welded[::-1]] = np.arange(len(welded))[::-1]  # the first vertex of each place
    shared = _shared_edges(welded[triangles])
    near = np.clip(ROUNDED * np.maximum.reduceat(np.abs(corners).max(axis=(1, 2)), starts), LEAST_M, MOST_M)
    of_triangle = _flattened(corners, normals, twice, of_triangle, shared, near[mesh])
    count = int(of_triangle.max()) + 1
    owner = np.empty(count, np.intp)
    owner[of_triangle] = mesh
    rank = np.empty(count, np.intp)
    rank[np.argsort(owner, kind="stable")] = np.arange(count)
    of_triangle = rank[of_triangle]  # those of a mesh lie together

    sums, low, high = np.zeros((count, 7)), np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    _add_up(corners, doubled, twice, of_triangle, sums, low, high)
    area = np.maximum(sums[:, 0], 1e-300)
    normal = sums[:, 1:4] / np.maximum(np.linalg.norm(sums[:, 1:4], axis=1), 1e-300)[:, None]
    middle = sums[:, 4:] / area[:, None]
    moment = np.zeros((count, 3, 3))
    _add_moments(corners, twice / (12.0 * area[of_triangle]), of_triangle, middle, moment)
    axes = plane_axes(normal)
    poles, polar, around = _around_poles(welded[triangles], of_triangle, normal)
    # A narrow triangle's normal is the surface's half way from the pole, not at two thirds, where its middle is.
    middle[polar] += (vertices[known[poles]] - middle[polar]) / 4.0
    turned, bent, apart, neighbours = _turns(of_triangle[shared], normal, middle, moment, (polar, around))
    turned, bent, apart, extent = (_projected(tensor, axes) for tensor in (turned, bent, apart, moment))
    least = 1e-6 * np.trace(apart, axis1=1, axis2=2) + 1e-30
    share = SPREAD * np.minimum(1.0, 4.0 / np.maximum(neighbours, 1))
    spread = turned * share[:, None, None]
    for tensor in (spread, extent):  # narrow faces that lie around a pole in all directions stand for round ones
        area_of = tensor[polar, 0, 0] * tensor[polar, 1, 1] - tensor[polar, 0, 1] * tensor[polar, 1, 0]
        tensor[polar] = np.sqrt(np.maximum(area_of, 0.0))[:, None, None] * np.eye(2)
    planes = np.bincount(owner, minlength=len(meshes))
    ends = np.cumsum(planes)
    whole = (
        normal,
        np.einsum("ij,ij->i", normal, middle),
        middle,
        axes,
        neighbours > 0,
        spread,
        extent,
        _over(bent, apart, least),
        low,
        high,
    )
    return [
        Faces((of_triangle[start : start + size] - begin).astype(np.int32), *(each[begin:end] for each in whole))
        for start, size, begin, end in zip(starts, sizes, ends - planes, ends, strict=True)
    ]


def _over(tensor: np.ndarray, by: np.ndarray, more: np.ndarray) -> np.ndarray:
    """Tensors (p, 2, 2) times the inverses of symmetric ones plus (p,) times the identity."""
    xx, xy, yy = by[:, 0, 0] + more, by[:, 0, 1], by[:, 1, 1] + more
    inverse = np.stack((yy, -xy, -xy, xx), 1).reshape(-1, 2, 2) / (xx * yy - xy * xy)[:, None, None]
    return np.asarray(np.einsum("pij,pjk->pik", tensor, inverse))


@compiled
def _add_up(
    corners: np.ndarray,
    doubled: np.ndarray,
    twice: np.ndarray,
    plane: np.ndarray,
    sums: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
) -> None:
    """Adds triangles (m, 3, 3) to their planes (m,): to sums (p, 7) their doubled areas, these along their normals, and
    times their middles; to low, high: (p, 3) their corners.
    """
    for row in range(len(plane)):
        of = plane[row]
        sums[of, 0] += twice[row]
        for axis in range(3):
            one, two, three = corners[row, 0, axis], corners[row, 1, axis], corners[row, 2, axis]
            sums[of, 1 + axis] += doubled[row, axis]
            sums[of, 4 + axis] += twice[row] * (one + two + three) / 3.0
            low[of, axis] = min(low[of, axis], one, two, three)
            high[of, axis] = max(high[of, axis], one, two, three)


@compiled
def _add_moments(
    corners: np.ndarray, share: np.ndarray, plane: np.ndarray, middle: np.ndarray, moment: np.ndarray
) -> None:
    """Adds the moments (p, 3, 3) of triangles (m, 3, 3) about the middles (p, 3) of their planes (m,), times shares."""
    for row in range(len(plane)):
        of = plane[row]
        for axis in range(3):
            for other in range(3):
                x, y, total = 0.0, 0.0, 0.0
                for corner in range(3):
                    one, two = (
                        corners[row, corner, axis] - middle[of, axis],
                        corners[row, corner, other] - middle[of, other],
                    )
                    x, y, total = x + one, y + two, total + one * two
                moment[of, axis, other] += (total + x * y) * share[row]


def patches(normal: np.ndarray, offset: np.ndarray, body: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """For each plane (p,) the first of those that it makes one flat patch with: of one body, level, and touching.

    normal, offset, low, high: as `Faces` has them, in the frames of the bodies; body: (p,).
    """
    # An odd scale, so that the round numbers of drawn scenes do not lie where rounding decides.
    keys = hashed(np.rint(np.c_[normal, offset] * 9876.5 + 0.123).astype(np.int64)) ^ hashed(body[:, None])
    _, group, counts = np.unique(keys, return_inverse=True, return_counts=True)
    several = np.flatnonzero((counts[group] > 1) & (counts[group] <= MOST_TILES))
    order = several[np.argsort(group[several], kind="stable")]
    first = np.arange(len(normal))
    _join_touching(order, group, low, high, first)
    return first


@compiled
def _join_touching(order: np.ndarray, group: np.ndarray, low: np.ndarray, high: np.ndarray, first: np.ndarray) -> None:
    """Writes the first plane of each patch: planes in `order` (k,), those of one group together, whose boxes touch."""
    for at in range(len(order)):
        one = order[at]
        for beside in range(at + 1, len(order)):
            two = order[beside]
            if group[two] != group[one]:
                break
            apart = 0.0
            for axis in range(3):
                apart = max(apart, low[one, axis] - high[two, axis], low[two, axis] - high[one, axis])
            if apart <= TOUCHING_M:
                root, other = one, two
                while first[root] != root:
                    root = first[root]
                while first[other] != other:
                    other = first[other]
                first[max(root, other)] = min(root, other)
    for plane in range(len(first)):
        first[plane] = first[first[plane]]


def _ranks(keys: np.ndarray) -> np.ndarray:
    """The rank (n,) of each of some 64-bit keys among the different ones."""
    groups = Groups(keys)
    rank = np.empty(len(groups), np.intp)
    rank[np.argsort(groups.keys)] = np.arange(len(groups))
    ranks: np.ndarray = rank[groups.which]
    return ranks


def hashed(rows: np.ndarray) -> np.ndarray:
    """One uint64 for each row of up to four integers."""
    total = np.zeros(len(rows), np.uint64)
    for column, factor in zip(rows.T, _HASH, strict=False):
        total = (total ^ column.astype(np.uint64)) * factor
        total ^= total >> np.uint64(29)
    return total


def plane_axes(normal: np.ndarray) -> np.ndarray:
    """(p, 2, 3): two unit vectors across each normal."""
    helper = np.where(np.abs(normal[:, :1]) < 0.6, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = np.cross(normal, helper)
    first /= np.maximum(np.linalg.norm(first, axis=1), 1e-300)[:, None]
    return np.stack((first, np.cross(normal, first)), 1)


def _projected(tensor: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """(p, 2, 2) of tensors (p, 3, 3) in the planes' axes."""
    found = np.empty((len(tensor), 2, 2))
    _project(np.asarray(tensor, np.float64), axes, found)  # what is counted of nothing is whole numbers
    return found


@compiled
def _project(tensor: np.ndarray, axes: np.ndarray, found: np.ndarray) -> None:
    for plane in range(len(found)):
        for one in range(2):
            for two in range(2):
                total = 0.0
                for row in range(3):
                    for column in range(3):
                        total += axes[plane, one, row] * tensor[plane, row, column] * axes[plane, two, column]
                found[plane, one, two] = total


def _shared_edges(corners: np.ndarray) -> np.ndarray:
    """Pairs (2, e) of triangles that share an edge. corners: (m, 3), numbers of their vertices."""
    ends, others = corners.ravel(), corners[:, [1, 2, 0]].ravel()
    keys = np.minimum(ends, others).astype(np.int64) * (int(corners.max()) + 1) + np.maximum(ends, others)
    edges, pairs = Groups(keys), np.empty((2, len(keys)), np.int64)
    pairs = pairs[:, : _pair(edges.which, np.full(len(edges), -1), pairs)]
    return pairs[:, np.argsort(keys[pairs[0]], kind="stable")] // 3


@compiled
def _pair(edge: np.ndarray, latest: np.ndarray, pairs: np.ndarray) -> int:
    """Writes the places (2, e) of each edge (n,) that was there before, then and now, and counts them; latest: -1 of
    each edge.
    """
    count = 0
    for place in range(len(edge)):
        before = latest[edge[place]]
        if before >= 0:
            pairs[0, count], pairs[1, count] = before, place
            count += 1
        latest[edge[place]] = place
    return count


def _flattened(
    corners: np.ndarray,
    normals: np.ndarray,
    twice: np.ndarray,
    plane: np.ndarray,
    shared: np.ndarray,
    near: np.ndarray,
) -> np.ndarray:
    """Planes (m,) of triangles, where neighbours that lie in one but for rounding are one.

    corners: (m, 3, 3) [m]; twice: (m,) their doubled areas [m^2]; plane: (m,) as known so far; shared: (2, e);
    near: (m,) [m], what corners may be off.
    """
    one, two = shared[:, plane[shared[0]] != plane[shared[1]]]
    level = np.einsum("ij,ij->i", normals[one], normals[two]) > TURNED

    def off(first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """How far the corners of the second triangles are from the planes of the first [m]."""
        away = corners[second] - corners[first][:, :1]
        return np.asarray(np.abs(np.einsum("ecj,ej->ec", away, normals[first])).max(axis=1, initial=0.0))

    one, two = one[level], two[level]
    flat = np.maximum(off(one, two), off(two, one)) < near[one]
    if not flat.any():
        return plane
    one, two = one[flat], two[flat]
    joined = _together(int(plane.max()) + 1, plane[one], plane[two])[plane]
    # A surface that bends by little everywhere is not flat: all corners have to be near the plane of the whole.
    count = int(joined.max()) + 1
    area = np.maximum(np.bincount(joined, twice, count), 1e-300)
    centres = corners.mean(axis=1)
    normal, middle = (
        np.stack([np.bincount(joined, twice * column, count) / area for column in columns.T], 1)
        for columns in (normals, centres)
    )
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    away = np.abs(np.einsum("mcj,mj->mc", corners - middle[joined][:, None], normal[joined])).max(axis=1)
    bends = np.zeros(count, bool)
    bends[joined[away > 2.0 * near]] = True
    return _ranks(np.where(bends[joined], plane + count, joined))


def _together(count: int, one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """For each of `count` things the least one that it is joined to, by pairs (k,) and chains of them."""
    least = np.arange(count)
    while True:
        before = least.copy()
        low = np.minimum(least[one], least[two])
        np.minimum.at(least, one, low)
        np.minimum.at(least, two, low)
        least = least[least]
        if (least == before).all():
            return least


def _turns(
    pairs: np.ndarray, normal: np.ndarray, middle: np.ndarray, moment: np.ndarray, polar: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Sums over the smooth edges of each plane, (p, 3, 3) each: of the turns of the normal, each squared, of turn times
    step, and of the steps from middle to middle, each squared; and their (p,) number.

    A face that is longer than a neighbour by `SEAM` does not bend there, and the neighbour on its own length alone.

    pairs: (2, e) planes at each edge; moment: (p, 3, 3) [m^2] of their areas; polar: planes around poles, and their
    turns, of `_around_poles`.
    """
    one, two = pairs
    cosine = np.einsum("ij,ij->i", normal[one], normal[two])
    smooth = (cosine > SMOOTH) & (cosine < FLAT)
    one, two = np.concatenate((pairs[:, smooth], pairs[::-1, smooth]), axis=1)
    turn, step = normal[two] - normal[one], middle[two] - middle[one]
    long, beside = (np.sqrt(np.einsum("ei,eij,ej->e", turn, moment[of], turn)) for of in (one, two))
    step = step * np.where(beside > SEAM * long, 2.0 * long / (long + beside), 1.0)[:, None]
    own = np.flatnonzero(long <= SEAM * beside)
    one, turn, step = one[own], turn[own], step[own]
    count = len(normal)

    def summed(first: np.ndarray, second: np.ndarray, of: np.ndarray) -> np.ndarray:
        columns = [np.bincount(of, first[:, i] * second[:, j], count) for i in range(3) for j in range(3)]
        return np.stack(columns, 1).reshape(count, 3, 3)

    of, around = polar
    turned = summed(turn, turn, one)
    turned += np.stack([np.bincount(of, column, count) for column in around.reshape(-1, 9).T], 1).reshape(-1, 3, 3)
    number = np.bincount(one, minlength=count) + np.bincount(of, minlength=count)
    return turned, summed(turn, step, one), summed(step, step, one), number


def _around_poles(
    corners: np.ndarray, plane: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (k,) in which many planes meet, as at a sphere's pole, those planes (k,), and (k, 3, 3) the mean square
    of their turns to the others: a plane has no neighbour across an edge there.

    corners: (m, 3) vertices of the triangles; plane: (m,) of each.
    """
    count = len(normal)
    often = np.flatnonzero(np.bincount(corners.ravel())[corners.ravel()] > POLE)
    pairs = np.unique(corners.ravel()[often].astype(np.int64) * count + plane[often // 3])
    vertex, of = np.divmod(pairs, count)
    known, vertex, number = np.unique(vertex, return_inverse=True, return_counts=True)
    many = np.flatnonzero(number[vertex] > POLE)
    of, poles = of[many], known[vertex[many]]
    numbers, vertex = np.unique(vertex[many], return_inverse=True)
    number = number[numbers]

    def mean(values: np.ndarray) -> np.ndarray:
        flat = values.reshape(len(values), int(np.prod(values.shape[1:])))
        columns = [np.bincount(vertex, column, len(numbers)) / number for column in flat.T]
        return np.stack(columns, 1).reshape(len(numbers), *values.shape[1:])

    own = normal[of]
    middle, square = mean(own)[vertex], mean(own[:, :, None] * own[:, None])[vertex]
    across = 2.0 * (own * middle).sum(axis=1) ** 2 / np.maximum((middle**2).sum(axis=1), 1e-300) - 1.0
    mixed = own[:, :, None] * middle[:, None]
    turns = square - mixed - np.swapaxes(mixed, 1, 2) + own[:, :, None] * own[:, None]
    smooth = np.flatnonzero(across > SMOOTH)
    return poles[smooth], of[smooth], turns[smooth]
