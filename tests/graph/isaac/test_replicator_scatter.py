"""`scatter_2d` and `scatter_3d` of `omni.replicator.core`."""

START = """import numpy as np
from isaacsim import SimulationApp
app = SimulationApp()
import omni.replicator.core as rep
import omni.replicator.core.functional as F
from isaacsim.core.utils.xforms import get_world_pose

def places(prims):
    return np.array([get_world_pose(str(one.GetPath()))[0] for one in prims])
"""


def test_surfaces_get_prims_where_they_are_free_and_within_bounds(run_script):
    """A plane of 4 m, tilted by 20 deg about x and 1 m up: points on it keep y tan(20 deg) = z - 1."""
    code, out, err = run_script(
        START
        + """plane = rep.create.plane(scale=4, position=(0, 0, 1), rotation=(20, 0, 0))
wall = rep.create.cube(scale=(0.5, 4, 4), position=(1, 0, 1))
balls = rep.create.sphere(scale=0.2, count=20)
seen = []
with rep.trigger.on_frame(num_frames=3):
    with balls:
        rep.randomizer.scatter_2d(plane, wall, min_samp=(None, -1, None), offset=0.1, check_for_collisions=True)
for _ in range(3):
    rep.orchestrator.step()
    seen.append(places(balls.get_output_prims()["prims"]))
turn = np.radians(20)
normal = np.array([0, -np.sin(turn), np.cos(turn)])
for one in seen:
    apart = np.abs(one[:, None] - one[None]).max(axis=2) + np.eye(len(one))
    print(np.allclose((one - [0, 0, 1]) @ normal, 0.1), apart.min() >= 0.199, one[:, 1].min() >= -1)
    print(abs(one[:, 0]).max() < 2, np.all(abs(one[:, 0] - 1) > 0.349), np.ptp(one[:, 0]) > 1, np.ptp(one[:, 1]) > 1)
print(np.allclose(seen[0], seen[1]))
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == ["True True True", "True True True True"] * 3 + ["False"]


def test_volumes_get_prims_inside_them(run_script):
    """Inside a ring of radius 1 m and thickness 0.5 m, a ball in its hole is empty; without volumes, bounds are one."""
    code, out, err = run_script(
        START
        + """ring = rep.create.torus(scale=2, visible=False)
shell = F.create.cube(scale=4)
core = F.create.sphere(scale=1)
drops = F.create_batch.sphere(count=60, scale=0.01)
with rep.create.group(drops):
    rep.randomizer.scatter_3d(ring)
one = places(drops)
reach = np.hypot(one[:, 0], one[:, 1])
print(0.3 < reach.min(), reach.max() < 1.6, abs(one[:, 2]).max() < 0.6)
rng, bounds = rep.rng.ReplicatorRNG(3), ((None, None, 0), (0.2, None, None))
F.randomizer.scatter_3d(drops, shell, volume_excl_prims=core, extents=bounds, rng=rng)
two = places(drops)
print(np.linalg.norm(two, axis=1).min() > 0.49, two[:, 2].min() >= 0, two[:, 0].max() <= 0.2, two[:, 1].max() > 1)
F.randomizer.scatter_3d(drops, extents=((0, 0, 5), (1, 1, 6)), rng=np.random.default_rng(3))
three = places(drops)
print(three.min(axis=0).round().tolist(), three.max(axis=0).round().tolist())
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == ["True True True", "True True True True", "[0.0, 0.0, 5.0] [1.0, 1.0, 6.0]"]


def test_scattering_without_room_warns_and_without_a_surface_fails(run_script):
    code, out, err = run_script(
        START
        + """plane = F.create.plane(scale=1)
boxes = F.create_batch.cube(count=2, scale=3)
before = places(boxes)
F.randomizer.scatter_2d(boxes, plane, check_for_collisions=True)
after = places(boxes)
print(np.array_equal(before[1], after[1]), abs(after[0]).max() <= 0.5)
for wrong in (lambda: F.randomizer.scatter_2d(boxes, "/World"), lambda: F.randomizer.scatter_3d(boxes)):
    try:
        wrong()
    except ValueError as error:
        print(error)
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == [
        "True True",
        "omni.replicator.core: scatter_2d: surface_prims have no surface; give meshes or shapes",
        "omni.replicator.core: scatter_3d: give volume_prims, or min_samp and max_samp for all three axes",
    ]
    assert "no place was found for" in err
