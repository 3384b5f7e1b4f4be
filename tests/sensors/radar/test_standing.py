"""What stands still is not worked out twice, and what moves is never taken for standing."""

import numpy as np
import pytest

from sensors.raycast.world import CastWorld
from tests.support.radar_scenes import plate, radar_world, received, trihedral

GROUND = {"type": "Plane", "translate": [0, 0, -1], "material": "gravel"}
CHANNELS = ("distance", "rv_ms", "azimuth", "scalar")


def casts_of(monkeypatch):
    """The sizes of all casts from now on."""
    sizes = []
    cast = CastWorld.cast

    def counted(self, rays, *args, **keys):
        sizes.append(len(rays.table))
        return cast(self, rays, *args, **keys)

    monkeypatch.setattr(CastWorld, "cast", counted)
    return sizes


def values(product):
    return np.stack([product.frame.channel(name) for name in CHANNELS])


def test_where_nothing_moves_nothing_is_cast_after_a_frame_of_each_cycle(monkeypatch):
    """The default sequence has two unambiguous velocities, so two grids of cells."""
    with radar_world({**trihedral(0.1, 20.0), "/World/Ground": GROUND}) as (app, product):
        seen = []
        for _ in range(2):
            app.update()
            seen.append(values(product))
        sizes = casts_of(monkeypatch)
        for number in range(4):
            app.update()
            assert np.array_equal(values(product), seen[number % 2])
    assert sizes == []


def test_what_moves_is_cast_in_every_frame(monkeypatch):
    """A body's velocity counts as well: at play it is thrown, from where it stood."""
    ball = {"type": "Sphere", "radius": 0.3, "rigid_body": True, "translate": [20, 0, 0], "velocity": [3, 0, 0]}
    with radar_world({"/World/Ball": ball}) as (app, product):
        ranges = []
        for _ in range(3):
            sizes = casts_of(monkeypatch)
            app.update()
            assert sizes
            ranges.append(float(product.frame.channel("distance")[0]))
    assert np.allclose(np.diff(ranges), 3 / 60, atol=0.01)


def test_a_radar_that_is_put_elsewhere_looks_from_there():
    with radar_world(plate(0.5, 20.0)) as (app, product):
        app.update(steps=3)
        first = float(product.frame.channel("distance")[0])
        pose = np.eye(4)
        pose[0, 3] = 2.0
        app.fabric.set_world_matrix(product.sensor.path, pose)
        app.update()
        assert abs(float(product.frame.channel("distance")[0]) - (first - 2.0)) < 1e-3


def test_finer_rays_over_a_small_target_do_not_see_what_stands_behind_it_twice():
    """Two bits of metal span a window of 0.5 x 0.5 m before a rough wall of 4 x 4 m, and hide 1e-5 of it."""
    points = [[15.0, y, z] for y in (-0.25, 0.24) for z in (-0.25, 0.24)]
    points += [[15.0, y + 0.01, z] for _, y, z in points[:4]] + [[15.0, y, z + 0.01] for _, y, z in points[:4]]
    bits = {"type": "Mesh", "points": points, "faces": [[0, 4, 8], [3, 7, 11]]}
    wall = {**plate(4.0, 20.0)["/World/Plate"], "material": "calibration_lambertion"}

    def of_wall(prims):
        sections, ranges, _ = received(prims)
        return sections[ranges > 18.0].sum()

    alone = of_wall({"/World/Wall": wall})
    assert of_wall({"/World/Wall": wall, "/World/Bits": bits}) == pytest.approx(alone, rel=1e-3)
