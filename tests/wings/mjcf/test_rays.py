"""Rays hit the mirrored geoms where closed forms, and MuJoCo's own rays, say."""

from __future__ import annotations

import numpy as np
import pytest

from graph.sim import App
from graph.sim.physics.mujoco.library import mujoco
from sensors.raycast.rays import RayBundle
from sensors.raycast.world import CastWorld


def cast(app, origin, directions):
    """(n,) ranges [m] of rays now; infinite where they hit nothing."""
    geometry = app.geometry()
    world = CastWorld(geometry)
    world = CastWorld(geometry, lambda poses: app.fabric.rigid_matrices(world.bodies, poses))
    table = np.zeros((len(directions), 6), np.float32)
    table[:, 3:6] = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return world.cast(RayBundle(np.asarray(origin, np.float64), table)).distance


def mujoco_ranges(app, origin, directions):
    """What `mj_ray` gives for geoms of the shown groups."""
    model, data = app.physics.model, app.physics.data
    mujoco.mj_kinematics(model, data)
    groups = np.array([1, 1, 1, 0, 0, 0], np.uint8)
    out = []
    for direction in directions:
        geom = np.array([-1], np.int32)
        unit = direction / np.linalg.norm(direction)
        distance = mujoco.mj_ray(model, data, np.asarray(origin, float), unit, groups, 1, -1, geom)
        out.append(distance if geom[0] >= 0 else np.inf)
    return np.array(out)


def test_an_ellipsoid_is_hit_at_its_radii(model):
    file = model("<worldbody><geom type='ellipsoid' size='.5 .3 .2' pos='2 0 1'/></worldbody>")
    with App(mjcf=file, fidelity={"mesh.tolerance": 1e-5}) as app:
        app.play()
        assert cast(app, [0, 0, 1], np.array([[1.0, 0, 0]])) == pytest.approx([1.5], abs=2e-5)
        assert cast(app, [2, 0, 5], np.array([[0, 0, -1.0]])) == pytest.approx([3.8], abs=2e-5)
        # x = y' = s: (s / .5)^2 + (s / .3)^2 = 1 seen from afar along the diagonal through the centre
        s = 1 / np.sqrt(1 / 0.25 + 1 / 0.09)
        assert cast(app, [0, -2, 1], np.array([[1.0, 1, 0]])) == pytest.approx([np.sqrt(2) * (2 - s)], abs=2e-5)


def test_a_height_field_is_hit_at_the_heights_written(model):
    """3 by 3 samples over 2 m by 2 m, 0 to 1 standing for 0 to 0.5 m, the first row written lying at the largest y.

    Each cell is cut from its corner of least x and y to the opposite one: half way along that cut the height is the
    mean of its two ends, which for two of the cells around the peak are samples of 0.
    """
    field = "<hfield name='h' nrow='3' ncol='3' size='1 1 .5 .1' elevation='0 0 0 0 1 0 0 0 .5'/>"
    file = model(f"<asset>{field}</asset><worldbody><geom type='hfield' hfield='h' pos='0 0 1'/></worldbody>")
    down = np.array([[0, 0, -1.0]])
    with App(mjcf=file) as app:
        app.play()
        for (x, y), height in {
            (-0.5, -0.5): (0.0 + 0.5) / 2,
            (0.5, 0.5): (0.0 + 0.5) / 2,
            (0.5, -0.5): 0.0,
            (-0.5, 0.5): 0.0,
            (0.25, 0.25): 0.375,
            (0.99, -0.99): 0.25 * 0.98,
            (0.6, -0.9): 0.25 * (0.6 - 0.1),
        }.items():
            assert cast(app, [x, y, 3], down) == pytest.approx([2 - height], abs=1e-6), (x, y)
        assert cast(app, [3, 0.3, 0.95], np.array([[-1.0, 0, 0]])) == pytest.approx([2.0], abs=1e-6)
        assert cast(app, [0.3, 0.2, 0], -down) == pytest.approx([0.9], abs=1e-6)


def test_every_geom_of_the_quadruped_is_where_mujocos_rays_find_it(quadruped):
    rng = np.random.default_rng(5)
    with App(mjcf=quadruped, fidelity={"mesh.tolerance": 1e-5}) as app:
        app.play()
        app.simulation.run_steps(150)
        for origin in ([0, 0, 3], [1.5, 1.0, 2.0], [-3, 1, 1.0]):
            target = rng.uniform([-2, -1.5, 0], [2, 1.5, 1.2], (400, 3))
            directions = target - origin
            ours, theirs = cast(app, origin, directions), mujoco_ranges(app, origin, directions)
            assert (np.isfinite(ours) == np.isfinite(theirs)).mean() > 0.995  # grazing rays may differ
            both = np.isfinite(ours) & np.isfinite(theirs)
            assert both.sum() > 200
            assert np.quantile(np.abs(ours[both] - theirs[both]), 0.99) < 1e-3


def test_collision_groups_and_clear_geoms_are_not_seen(model):
    geoms = "".join(
        f"<geom type='box' size='.1 1 1' pos='{x} 0 0' {more}/>"
        for x, more in ((1, "group='3'"), (2, "rgba='1 0 0 0'"), (3, "group='2'"), (4, ""))
    )
    with App(mjcf=model(f"<worldbody>{geoms}</worldbody>")) as app:
        app.play()
        assert cast(app, [0, 0, 0], np.array([[1.0, 0, 0]])) == pytest.approx([2.9], abs=1e-6)


def test_planes_end_where_the_model_says_or_never(model):
    planes = "<geom type='plane' size='2 1 .1'/><geom type='plane' size='0 0 .1' pos='0 0 -5'/>"
    with App(mjcf=model(f"<worldbody>{planes}</worldbody>")) as app:
        app.play()
        down = np.array([[0, 0, -1.0]])
        assert cast(app, [1.9, 0.9, 1], down) == pytest.approx([1])
        assert cast(app, [1.9, 1.1, 1], down) == pytest.approx([6])
        assert cast(app, [2.1, 0.9, 1], down) == pytest.approx([6])
        assert cast(app, [900, 0, 1], down) == pytest.approx([6])
