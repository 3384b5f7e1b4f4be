"""Physics of inline prims and of USD text."""

import pytest

from graph.sim.scene.prims import author_prims
from graph.sim.scene.stage import open_stage
from graph.sim.usd import UsdGeom


@pytest.fixture
def world():
    """Builds a stage from inline prims and its physics: world(prims, hz) -> (physics, stage, warnings)."""
    from tests.support.physics_worlds import physics_of

    def build(prims, hz=240, meters_per_unit=1.0, up="Z", fidelity=None):
        stage = open_stage()
        UsdGeom.SetStageMetersPerUnit(stage, meters_per_unit)
        UsdGeom.SetStageUpAxis(stage, up)
        author_prims(stage, prims)
        physics, warnings = physics_of(stage, hz, fidelity)
        return physics, stage, warnings

    return build


@pytest.fixture
def usda():
    """Builds the physics of a USD text: usda(text, hz) -> (physics, warnings)."""
    from tests.support.physics_worlds import physics_of, stage_of

    def build(text, hz=240, fidelity=None):
        return physics_of(stage_of(text), hz, fidelity)

    return build
