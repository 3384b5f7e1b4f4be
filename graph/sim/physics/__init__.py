"""Rigid-body physics of a stage, built when the simulation plays and freed when it stops.

`protocol` is the interface of an engine; `read_world` reads the stage into plain data (`model`) for any engine;
`mujoco` is the default engine. Only `mujoco` and wings use MuJoCo's models and data.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from graph.sim.scene.stage import Warn, ignore_warning

if TYPE_CHECKING:
    from graph.sim.fidelity import Fidelity
    from graph.sim.scene.scan import Scan

    from .protocol import EngineFactory, ModelScene, PhysicsEngine
    from .world_model import WorldModel


class Mujoco:
    """The factory of the default engine (`EngineFactory`); MuJoCo is imported with the first world that needs it."""

    name = "mujoco"

    def __call__(
        self,
        world: WorldModel,
        dt: Fraction,
        *,
        meters_per_unit: float,
        fidelity: Fidelity | None,
        warn: Warn,
        mjcf: ModelScene | None,
    ) -> PhysicsEngine:
        """The MuJoCo engine of a world.

        fidelity: its knobs `physics.*` choose how it solves (see `solver`), and replace the scene's own attributes. If
        neither sets the integrator, it is `discrete` for worlds with driven joints (only it keeps stiff drives and
        contacts stable together) or deformables, and otherwise the cheaper `implicitfast`.
        """
        from .mujoco.compile import compiler_of
        from .mujoco.engine import MujocoEngine

        return MujocoEngine(world, dt, meters_per_unit, compiler_of(fidelity, mjcf), warn)


MUJOCO = Mujoco()


def build_physics(
    stage: Any,
    dt: Fraction,
    fidelity: Fidelity | None = None,
    *,
    engine: EngineFactory = MUJOCO,
    warn: Warn = ignore_warning,
    scan: Scan | None = None,
    mjcf: ModelScene | None = None,
) -> PhysicsEngine | None:
    """An engine with the stage's dynamics and steps of `dt` [s], in the state of the stage; None if nothing can move.

    mjcf: the model that the stage mirrors; it is simulated unchanged, together
    with the stage's other bodies and colliders. Raises UserError if the engine refuses the scene.
    """
    from graph.sim.scene.scan import scan_stage

    from .authored_settings import check_settings

    check_settings(stage, warn, mirrors=mjcf is not None)
    if mjcf is not None:
        mjcf.settle(warn)
    scan = scan or scan_stage(stage)
    moves = scan.dynamic or (mjcf is not None and mjcf.moves)
    if not (moves or scan.soft):
        return None
    from .read_forces import start_surfaces
    from .read_world import read_world
    from .start_checks import tell_start

    world = read_world(scan, warn)
    if not (moves or world.softs):
        return None
    physics = engine(world, dt, meters_per_unit=scan.meters_per_unit, fidelity=fidelity, warn=warn, mjcf=mjcf)
    start_surfaces(physics, warn)
    tell_start(physics, warn)
    return physics
