"""What a file may bring beside rigid shapes and whole turns: the device measures it as the processor does."""

from fractions import Fraction

import numpy as np
import pytest

pytest.importorskip("warp", reason="pip install 'tickgraph[gpu]'")

from pxr import UsdGeom

from graph.sim import App
from sensors import LidarConfig
from sensors.lidar.config import EmitterState
from sensors.raycast.rays import RayBundle
from sensors.raycast.shared import cast_world
from tests.support.devices import on_each
from tests.support.lidar_worlds import EVERYTHING, add_box, add_lidar, bind, frames_of, rotary, stare, weightless
from tests.support.without_wing import needs_wing

RANDOM = np.random.default_rng(4)
SPREAD = EmitterState(
    azimuth_deg=RANDOM.uniform(-40, 40, 300),
    elevation_deg=RANDOM.uniform(-20, 20, 300),
    fire_time_ns=np.arange(300) * 300_000,
    hor_offset_m=RANDOM.uniform(-0.05, 0.05, 300),
    vert_offset_m=RANDOM.uniform(-0.05, 0.05, 300),
)
OWN = LidarConfig(
    scan_type="SOLID_STATE",
    scan_rate_base_hz=Fraction(10),
    pattern_firing_rate_hz=Fraction(10),
    emitter_states=(SPREAD,),
    near_range_m=0.5,
    far_range_m=30.0,
)
ROUNDED = {"distance", "xyz", "scalar", "hitNormals", "velocities", "azimuth", "elevation"}
"""Channels that are computed from what was hit; with offsets the angles [deg] too."""
CASES = {
    "a pattern of its own, each beam with its offset": OWN,
    "a minimum range past what it is mounted on": rotary(ticks=180, elevations=(-30.0, 0.0, 10.0), near_range_m=2.5),
    "beams that have no return are kept": stare(np.linspace(0, 0.09, 40), np.linspace(-90, 90, 40)),
}


def frame_on(device, config):
    app = weightless(device=device, settings={"/rtx-transient/stableIds/enabled": True})
    with app:
        add_box(app, "/World/Mount", 0.6, (0, 0, -0.4))
        add_box(app, "/World/Near", 1.0, (2.2, 0.3, 0))  # its face is at 1.7 m
        bind(app, add_box(app, "/World/Far", 2.0, (6, 0.5, 0.2)), "steel")
        add_box(app, "/World/Mover", 1.0, (3, -2.5, 0), velocity=(0, 1, 0), spin=(0, 0, 40))
        names = EVERYTHING | {"objId"}
        product = add_lidar(app, config=config, channels=names)
        frames = frames_of(app, product, 60)
        return [(one.count, {name: np.array(one.channel(name)) for name in names}) for one in frames]


@on_each
@pytest.mark.parametrize("config", CASES.values(), ids=CASES)
def test_frames_of_own_patterns_are_those_of_the_processor(device, config):
    """Ranges to 1e-5 m, ids and everything of the firings alike, in each of the frames of a quarter of a second."""
    ours, theirs = frame_on(device, config), frame_on("cpu", config)
    assert len(ours) == len(theirs) >= 2
    for (count, here), (expected, there) in zip(ours, theirs, strict=True):
        assert count == expected > 5
        assert np.abs(here["distance"] - there["distance"]).max() < 1e-5
        for name in EVERYTHING - ROUNDED | {"objId"}:
            assert np.array_equal(here[name], there[name]), name
        for name in ROUNDED:
            assert np.abs(here[name] - there[name]).max() < 1e-4, name
        if config.near_range_m:
            seen = here["distance"][here["distance"] > 0]
            assert seen.min() > config.near_range_m


def lattice(rays=2000):
    """Directions evenly over the sphere."""
    number = np.arange(rays) + 0.5
    height, turn = 1 - 2 * number / rays, np.pi * (1 + np.sqrt(5)) * number
    level = np.sqrt(1 - height * height)
    table = np.zeros((rays, 6), np.float32)
    table[:, 3:] = np.stack([level * np.cos(turn), level * np.sin(turn), height], 1)
    return table


def same(one, two):
    """Ranges to 1e-5 m and a step of float32, ids alike but for one ray in a thousand; some of both kinds."""
    both = np.isfinite(one.distance) & np.isfinite(two.distance)
    assert 100 < both.sum() < len(both)
    apart = np.abs(one.distance[both] - two.distance[both]) - np.spacing(two.distance[both])
    assert (apart > 1e-5).sum() <= 2
    assert (one.surfaces() != two.surfaces()).sum() <= 2


def cloth_on(device):
    """A sheet that flies past and bends about a ball, after 12 updates."""
    points = [(x, y, 0.8) for x in np.linspace(-2, 2, 5) for y in np.linspace(-2, 2, 5)]
    faces = [[i * 5 + j, i * 5 + j + 5, i * 5 + j + 6, i * 5 + j + 1] for i in range(4) for j in range(4)]
    with App(physics_hz=240, loop_hz=60, device=device) as app:
        cloth = UsdGeom.Mesh.Define(app.stage, "/World/Cloth")
        cloth.GetPointsAttr().Set(points)
        cloth.GetFaceVertexCountsAttr().Set([4] * 16)
        cloth.GetFaceVertexIndicesAttr().Set([corner for face in faces for corner in face])
        cloth.GetPrim().AddAppliedSchema("PhysxDeformableSurfaceAPI")
        app.add_prims({"/World/Ball": {"type": "Sphere", "radius": 0.5, "schemas": ["PhysicsCollisionAPI"]}})
        app.play()
        found = []
        for _ in range(2):
            app.update(steps=6)
            found.append(cast_world(app.world).cast(RayBundle(np.array([0.3, 0.1, 2.0]), lattice()), normals=True))
        return found


@on_each
def test_a_world_without_anything_gives_frames_without_returns(device):
    with weightless(device=device, settings={"/rtx-transient/stableIds/enabled": True}) as app:
        product = add_lidar(app, config=rotary(ticks=90), channels=EVERYTHING | {"objId"})
        found = frames_of(app, product, 20)
        assert [one.count for one in found] == [0] * len(found) != []


@on_each
def test_a_deforming_body_is_met_where_it_is_now(device):
    ours, theirs = cloth_on(device), cloth_on("cpu")
    for here, there in zip(ours, theirs, strict=True):
        same(here, there)
    assert not np.array_equal(ours[0].distance, ours[1].distance)


SHAPES = """\
<mujoco>
  <asset>
    <mesh name="tent" vertex="-1 -1 0  1 -1 0  1 1 0  -1 1 0  0 0 1.2"/>
    <hfield name="dunes" nrow="4" ncol="4" size="3 3 1 0.1" elevation="0 1 0 2  1 0 2 0  0 2 1 0  1 0 0 1"/>
  </asset>
  <worldbody>
    <geom type="hfield" hfield="dunes" pos="0 0 -2"/>
    <body pos="2 0 0.5"><freejoint/><geom type="sdf" mesh="tent" mass="1"/></body>
    <geom type="ellipsoid" size="0.4 0.6 0.3" pos="-2 0 0.5"/>
    <body pos="0 3 0"><freejoint/><geom type="capsule" size="0.3 0.5"/></body>
  </worldbody>
</mujoco>
"""


@needs_wing("mjcf")
@on_each
def test_distance_fields_height_fields_and_ellipsoids_of_models_are_met_alike(device, tmp_path):
    """A geom with a signed distance field is seen as its mesh, by rays of both."""
    model = tmp_path / "shapes.xml"
    model.write_text(SHAPES)
    found = []
    for name in (device, "cpu"):
        with App(mjcf=model, device=name) as app:
            app.play()
            app.update(steps=3)
            hits = cast_world(app.world).cast(RayBundle(np.array([0.1, 0.2, 1.0]), lattice()), normals=True)
            found.append(hits)
            met = {cast_world(app.world).surfaces[n].path for n in hits.surfaces() if n >= 0}
            assert len(met) == 4
    same(*found)
