"""Units and up axis that a script sets on the stage of an App that exists: read at play, by all from one source.

The wall is 8 units of 1 m, or 800 of 1 cm, ahead; after 24 steps of 240 Hz a body at rest has fallen
g dt^2 n (n + 1) / 2 = 9.81 x 300 / 240^2 = 0.0511 m.
"""

import numpy as np
import pytest
from pxr import UsdGeom

from graph.sim import App
from tests.support.lidar_worlds import add_lidar, rotary


@pytest.mark.parametrize("fabric", ["on", "off"])
@pytest.mark.parametrize("late", ["before prims", "after prims", "after the lidar"])
@pytest.mark.parametrize(("unit", "up"), [(0.01, "Y"), (0.01, "Z"), (1.0, "Y")])
def test_units_and_up_axis_set_after_the_app_was_made(unit, up, late, fabric):
    def declare(when):
        if when == late:
            UsdGeom.SetStageMetersPerUnit(app.stage, unit)
            UsdGeom.SetStageUpAxis(app.stage, up)

    metre = 1 / unit
    with App(None, physics_hz=240, loop_hz=60, fidelity={"fabric": fabric}) as app:
        assert app.meters_per_unit == 1.0
        declare("before prims")
        app.add_prims(
            {
                "/World/Wall": {"type": "Cube", "size": 2 * metre, "translate": [9 * metre, 0, 0]},
                "/World/Box": {
                    **{"type": "Cube", "size": 0.1 * metre, "translate": [0, 0, -5 * metre]},
                    **{"rigid_body": True, "mass": 1},
                },
            }
        )
        declare("after prims")
        product = add_lidar(app, config=rotary(4), channels={"distance"})
        declare("after the lidar")
        app.play()
        app.update(6)
        place = app.fabric.world_matrix("/World/Box")[:3, 3] * unit
        distances = product.frame.channel("distance")
        assert app.meters_per_unit == unit
    assert distances[0] == pytest.approx(8.0, abs=1e-5)
    fallen = {"Y": [0, -0.0511, -5], "Z": [0, 0, -5.0511]}[up]
    np.testing.assert_allclose(place, fallen, atol=1e-4)
