"""Rigid-body physics of a stage, built when the simulation plays and freed when it stops."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from graph.sim.stage import Warn, ignore_warning

if TYPE_CHECKING:
    from graph.sim.fidelity import Fidelity
    from graph.sim.scan import Scan

    from .compile import Compiled
    from .engine import Physics as Physics
    from .model import World


def build_physics(
    stage: Any,
    dt: Fraction,
    fidelity: Fidelity | None = None,
    *,
    warn: Warn = ignore_warning,
    scan: Scan | None = None,
) -> Physics | None:
    """The stage's dynamics with time step `dt` [s], at the state the stage describes; None if nothing can move.

    fidelity: its knobs `physics.*` choose how the engine solves (see `solver`); they beat the scene's own attributes.
    Where neither says it, the integrator is `discrete` with driven joints (it alone keeps stiff drives and contacts
    stable together) and the cheaper `implicitfast` without, or with contacts that bounce. Raises UserError if the
    engine refuses the scene.
    """
    from graph.sim.scan import scan_stage

    scan = scan or scan_stage(stage)
    if not scan.dynamic:
        return None
    from .compile import compile_world
    from .engine import Physics
    from .read_world import read_world
    from .solver import chosen

    def compiled(world: World, dt: Fraction, warn: Warn) -> Compiled:
        return compile_world(world, dt, chosen(fidelity).over(world.options), warn)

    world = read_world(scan, warn)
    physics = Physics(compiled(world, dt, warn), dt, scan.meters_per_unit)
    physics.world, physics.compile = world, compiled
    return physics


def __getattr__(name: str) -> Any:
    if name == "Physics":
        from .engine import Physics

        return Physics
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
