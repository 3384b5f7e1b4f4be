import math

import numpy as np
import pytest

from graph.sim.physics.convex_decomposition import MOST_TRIANGLES, enclosed, surface_pieces
from tests.support.physics_worlds import GROUND, steps


def boxes(*spans):
    """A mesh of the union of boxes of a grid: ((x0, y0, z0), (x1, y1, z1)) in whole numbers, only its outer faces."""
    cells = {
        (x, y, z)
        for low, high in spans
        for x in range(low[0], high[0])
        for y in range(low[1], high[1])
        for z in range(low[2], high[2])
    }
    points, faces = [], []
    for x, y, z in sorted(cells):
        for axis in range(3):
            for side in (0, 1):
                other = [x, y, z]
                other[axis] += 2 * side - 1
                if tuple(other) in cells:
                    continue
                u, v = (axis + 1) % 3, (axis + 2) % 3
                ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
                corners = []
                for a, b in ring if side else reversed(ring):
                    corner = [x, y, z]
                    corner[axis] += side
                    corner[u] += a
                    corner[v] += b
                    corners.append(corner)
                faces.append(list(range(len(points), len(points) + 4)))
                points.extend(corners)
    return {"type": "Mesh", "points": points, "faces": faces}


BIN = boxes(
    ((0, 0, 0), (6, 6, 1)),
    ((0, 0, 1), (6, 1, 4)),
    ((0, 5, 1), (6, 6, 4)),
    ((0, 1, 1), (1, 5, 4)),
    ((5, 1, 1), (6, 5, 4)),
)


@pytest.mark.parametrize(
    ("shape", "half"),
    [
        ({"type": "Sphere", "radius": 0.5}, 0.5),
        ({"type": "Cube", "size": 1.0}, 0.5),
        ({"type": "Cylinder", "radius": 0.5, "height": 1.0}, 0.5),
    ],
)
@pytest.mark.parametrize("mirror", [1, -1])
def test_what_falls_into_a_bin_rests_on_its_floor(world, shape, half, mirror):
    holder = {**BIN, "scale": [mirror, 1, 1]}
    physics, _, warnings = world(
        {**GROUND, "/Bin": holder, "/A": {**shape, "rigid_body": True, "translate": [3 * mirror, 3, 4]}}
    )
    steps(physics, 720)
    assert physics.positions[0] == pytest.approx([3 * mirror, 3, 1 + half], abs=5e-3)
    assert warnings == []


def test_a_bin_holds_what_rolls_against_its_walls(world):
    ball = {"type": "Sphere", "radius": 0.3, "rigid_body": True, "translate": [3, 3, 1.3], "velocity": [4, 1, 0]}
    physics, _, _ = world({"/Bin": BIN, "/A": ball})
    for _ in range(960):
        physics.step()
        x, y, z = physics.positions[0]
        assert 1.2 < x < 4.8
        assert 1.2 < y < 4.8
        assert z > 1.25


def test_stairs_are_stood_on_step_by_step(world):
    stairs = boxes(*(((n, 0, 0), (n + 1, 2, n + 1)) for n in range(4)))
    blocks = {
        f"/B{n}": {"type": "Cube", "size": 0.5, "rigid_body": True, "translate": [n + 0.5, 1, n + 1.3]}
        for n in range(4)
    }
    physics, _, warnings = world({"/Stairs": stairs, **blocks})
    steps(physics, 480)
    assert physics.positions[:, 2] == pytest.approx([n + 1.25 for n in range(4)], abs=5e-3)
    assert warnings == []


def test_a_ball_falls_through_a_hole_and_not_through_the_rim(world):
    plate = boxes(((0, 0, 2), (3, 1, 3)), ((0, 2, 2), (3, 3, 3)), ((0, 1, 2), (1, 2, 3)), ((2, 1, 2), (3, 2, 3)))
    ball = {"type": "Sphere", "rigid_body": True}
    prims = {
        "/Small": {**ball, "radius": 0.4, "translate": [1.5, 1.5, 4]},
        "/Large": {**ball, "radius": 0.6, "translate": [11.5, 1.5, 4]},
    }
    other = {**plate, "translate": [10, 0, 0]}
    physics, _, _ = world({**GROUND, "/Plate": plate, "/Other": other, **prims})
    steps(physics, 720)
    small, large = physics.positions[:, 2]
    assert small == pytest.approx(0.4, abs=5e-3)
    # a ball of 0.6 on a square hole of 1: its middle is sqrt(0.36 - 0.25) above the rim
    assert large == pytest.approx(3 + math.sqrt(0.11), abs=1e-2)


def test_a_moving_concave_mesh_hangs_and_weighs_as_it_is(world):
    """A U upside down, 3 x 1 x 2 with a slot of 1 x 1 x 1, hung over a bar."""
    hook = boxes(((0, 0, 1), (3, 1, 2)), ((0, 0, 0), (1, 1, 1)), ((2, 0, 0), (3, 1, 1)))
    shape = {"physics:approximation": "convexDecomposition"}
    bar = {"type": "Cube", "size": 1.0, "scale": [0.6, 4, 0.5], "translate": [1.5, 0.5, 5.25]}
    physics, _, _ = world(
        {"/Bar": bar, "/U": {**hook, "rigid_body": True, "translate": [0, 0, 4.6], "attributes": shape}}
    )
    assert physics.model.body_mass[1] == pytest.approx(5000)
    assert physics.model.body_ipos[1] == pytest.approx([1.5, 0.5, (3 * 1.5 + 2 * 0.5) / 5], abs=1e-6)
    steps(physics, 720)
    assert physics.positions[0] == pytest.approx([0, 0, 4.5], abs=1e-2)


def test_a_moving_concave_mesh_is_its_hull_unless_it_says_otherwise(world):
    hook = boxes(((0, 0, 1), (3, 1, 2)), ((0, 0, 0), (1, 1, 1)), ((2, 0, 0), (3, 1, 1)))
    physics, _, _ = world({**GROUND, "/U": {**hook, "rigid_body": True}})
    assert physics.model.ngeom == 2
    assert physics.model.body_mass[1] == pytest.approx(6000)


def test_a_mesh_encloses_what_it_does_on_paper():
    box = np.array([[x, y, z] for x in (1.0, 2) for y in (0.0, 2) for z in (0.0, 3)])
    faces = np.array(
        [
            [0, 1, 3],
            [0, 3, 2],
            [4, 6, 7],
            [4, 7, 5],
            [0, 4, 5],
            [0, 5, 1],
            [2, 3, 7],
            [2, 7, 6],
            [0, 2, 6],
            [0, 6, 4],
            [1, 5, 7],
            [1, 7, 3],
        ]
    )
    for triangles in (faces, faces[:, ::-1]):
        volume = enclosed(box, triangles)
        assert volume.volume == pytest.approx(6)
        assert volume.center == pytest.approx([1.5, 1, 1.5])
        assert volume.inertia == pytest.approx(np.diag([6 * (4 + 9) / 12, 6 * (1 + 9) / 12, 6 * (1 + 4) / 12]))
    assert enclosed(box, faces[1:]) is None


def test_flat_grids_are_joined_and_huge_ones_left():
    n = 21
    x, y = np.meshgrid(np.arange(n, dtype=float), np.arange(n, dtype=float))
    points = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    first = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).reshape(-1)
    triangles = np.concatenate(
        [np.stack([first, first + 1, first + n], 1), np.stack([first + 1, first + n + 1, first + n], 1)]
    )
    pieces = surface_pieces(points, triangles)
    assert len(pieces) <= n - 1
    covered = sum(np.ptp(piece[:, 0]) * np.ptp(piece[:, 1]) for piece in pieces)
    assert covered == pytest.approx((n - 1) ** 2)
    assert surface_pieces(points, np.repeat(triangles, MOST_TRIANGLES // len(triangles) + 1, axis=0)) is None
