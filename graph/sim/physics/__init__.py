"""Rigid-body physics of a stage, built when the simulation plays and freed when it stops."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from graph.sim.scene.stage import Warn, ignore_warning

if TYPE_CHECKING:
    from graph.sim.fidelity import Fidelity
    from graph.sim.mjcf.scene import MjcfScene
    from graph.sim.scene.scan import Scan

    from .model import Volume, World
    from .mujoco.compile import Compiled
    from .mujoco.engine import MujocoEngine as MujocoEngine
    from .mujoco.geoms import Shape


def build_physics(
    stage: Any,
    dt: Fraction,
    fidelity: Fidelity | None = None,
    *,
    warn: Warn = ignore_warning,
    scan: Scan | None = None,
    mjcf: MjcfScene | None = None,
) -> MujocoEngine | None:
    """The stage's dynamics with time step `dt` [s], at the state the stage describes; None if nothing can move.

    mjcf: the model that the stage mirrors; it is simulated as it is, and the stage's other bodies and colliders in it.
    fidelity: its knobs `physics.*` choose how the engine solves (see `solver`); they beat the scene's own attributes.
    Where neither says it, the integrator is `discrete` with driven joints (it alone keeps stiff drives and contacts
    stable together) or deformables, and the cheaper `implicitfast` without. Raises UserError if the
    engine refuses the scene.
    """
    from graph.sim.scene.scan import scan_stage

    from .authored_settings import check_settings

    check_settings(stage, warn, mirrors=mjcf is not None)
    if mjcf is not None:
        mjcf.settle(warn)
    scan = scan or scan_stage(stage)
    if not scan.dynamic and not scan.soft and not (mjcf and mjcf.model.nv):
        return None
    from .mujoco.compile import compile_world
    from .mujoco.engine import MujocoEngine
    from .read_world import read_world
    from .solver import chosen

    volumes: dict[Shape, Volume] = {}

    def compiled(world: World, dt: Fraction, warn: Warn) -> Compiled:
        options = chosen(fidelity).over(world.options)
        if mjcf is None:
            return compile_world(world, dt, options, warn, volumes=volumes)
        from graph.sim.mjcf.playing import compile_scene

        return compile_scene(mjcf, world, dt, options, warn, volumes)

    world = read_world(scan, warn)
    if not scan.dynamic and not world.softs and not (mjcf and mjcf.model.nv):
        return None
    physics = MujocoEngine(compiled(world, dt, warn), dt, scan.meters_per_unit)
    physics.world, physics.compile = world, compiled
    return physics


def __getattr__(name: str) -> Any:
    if name == "MujocoEngine":
        from .mujoco.engine import MujocoEngine

        return MujocoEngine
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
