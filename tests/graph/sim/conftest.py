"""Makes the helpers beside these tests importable: `from noting_sensor import ...`."""

import sys
from fractions import Fraction
from pathlib import Path

import pytest

from graph.sim.physics import build_physics
from graph.sim.scene.prims import author_prims
from graph.sim.scene.stage import open_stage
from graph.sim.usd import UsdGeom

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def world():
    """Builds a stage from inline prims and its physics: world(prims, hz) -> (physics, stage, warnings)."""

    def build(prims, hz=240, meters_per_unit=1.0, up="Z", fidelity=None):
        stage = open_stage()
        UsdGeom.SetStageMetersPerUnit(stage, meters_per_unit)
        UsdGeom.SetStageUpAxis(stage, up)
        author_prims(stage, prims)
        warnings = []
        physics = build_physics(stage, Fraction(1, hz), fidelity, warn=lambda *warning: warnings.append(warning))
        return physics, stage, warnings

    return build
