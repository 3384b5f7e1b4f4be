"""A cloud is the same to the last byte in whatever order a file names its prims."""

import random

import pytest

from graph.sim import App
from sensors import Lidar, LidarSensor

# Balls of several sizes are meshes of many triangles, each in a cell of its own; boxes and a wall near them overlap.
PRIMS = {
    "/W/Physics": {"type": "PhysicsScene", "attributes": {"physics:gravityMagnitude": 1e-12}},
    "/W/Ground": {"type": "Plane"},
    "/W/Wall": {"type": "Cube", "size": 4, "translate": [9, 3, 2]},
    "/W/Same": {"type": "Cube", "size": 4, "translate": [9, 3, 2]},
    "/W/Post": {"type": "Cylinder", "radius": 0.3, "height": 3, "translate": [3, -4, 1.5]},
    "/W/Fine": {"type": "Sphere", "radius": 1.5, "translate": [-6, 2, 1]},
    **{
        f"/W/Ball{k}": {
            "type": "Sphere",
            "radius": 0.3 + 0.1 * k,
            "translate": [4 - 2 * k, 3 + k, 1],
            "rigid_body": True,
            "attributes": {"physics:velocity": [0.5, -0.2 * k, 0.0], "physics:angularVelocity": [10.0 * k, 20.0, 5.0]},
        }
        for k in range(5)
    },
    "/W/Crate": {"type": "Cube", "size": 0.7, "translate": [-3, -3, 1], "rigid_body": True},
}


def clouds(paths, motion):
    """The buffers of three scans of a world whose prims are added in this order."""
    with App(physics_hz=240, loop_hz=60, fidelity={"lidar.motion": motion}) as app:
        app.add_prims({path: PRIMS[path] for path in paths})
        lidar = Lidar.create("/W/Lidar", config="Example_Rotary", translations=[0, 0, 1.3], app=app)
        sensor = LidarSensor(lidar, annotators=["generic-model-output"])
        app.play()
        found = []
        for _ in range(3):
            app.update(6)
            found.append(bytes(sensor.get_data("generic-model-output")[0]))
        return found


@pytest.mark.parametrize("motion", ["frozen", "continuous"])
def test_the_order_of_prims_changes_no_byte_of_a_cloud(motion):
    first = clouds(list(PRIMS), motion)
    assert min(map(len, first)) > 10_000
    for seed in range(4):
        paths = list(PRIMS)
        random.Random(seed).shuffle(paths)
        assert clouds(paths, motion) == first, seed
