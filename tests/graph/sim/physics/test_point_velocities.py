"""Velocities of the points of what deforms: those of a state, not differences between two."""

import numpy as np
import pytest

from graph.sim import App
from tests.support.without_wing import needs_wing

CLOTH = """#usda 1.0
(
    upAxis = "Z"
    metersPerUnit = 1
)
def Mesh "Cloth" (prepend apiSchemas = ["PhysxDeformableSurfaceAPI"])
{
    point3f[] points = [(0, 0, 5), (0.2, 0, 5), (0.2, 0.2, 5), (0, 0.2, 5)]
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    vector3f physics:velocity = (1, -2, 0)
}
"""
FLEX = """<mujoco><worldbody><flexcomp name="cloth" type="grid" count="3 3 1" spacing=".2 .2 .2" pos="0 0 3"
radius=".01" mass="1" dim="2"><elasticity young="1000"/></flexcomp></worldbody></mujoco>"""


@pytest.mark.parametrize(
    ("name", "text", "key", "start"),
    [
        ("cloth.usda", CLOTH, "usd", [1, -2, 0]),
        pytest.param("cloth.xml", FLEX, "mjcf", [0, 0, 0], marks=needs_wing("mjcf")),
    ],
)
def test_points_in_free_fall_have_the_velocity_of_the_fall(tmp_path, name, text, key, start):
    """start - g t along z, at the end of the last step; nothing stretches a sheet that falls as a whole."""
    (tmp_path / name).write_text(text)
    (tmp_path / "graph.yaml").write_text(f"tickgraph: 1\nscene: {{{key}: {name}}}\n")
    with App.from_file(tmp_path / "graph.yaml") as app:
        app.play()
        app.update(steps=6)
        (path,) = app.physics.deformable_paths
        found = app.fabric.capture().point_velocities(path)
        fallen = 9.81 * float(app.simulation.get_simulation_time())
    assert np.allclose(found, np.array(start) - [0, 0, fallen], atol=1e-6)


def test_other_prims_have_none():
    with App(None) as app:
        app.add_prims({"/World/Box": {"type": "Cube", "rigid_body": True}})
        app.play()
        assert app.fabric.capture().point_velocities("/World/Box") is None
