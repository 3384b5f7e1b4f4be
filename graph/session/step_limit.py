"""Refuses clocks whose updates would not end soon, before anything runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.limits import check, most

if TYPE_CHECKING:
    from graph.sim.app import App


def check_steps(app: App) -> None:
    """Raises OverLimit if an update makes more physics steps than `clock.steps`; scenes without physics make none."""
    steps = app.simulation.steps_per_second / app.loop_rate
    if steps > most("clock.steps") and _moves(app):
        said = f"physics_hz {float(app.simulation.steps_per_second):,.10g} over loop_hz {float(app.loop_rate):,.10g}"
        check("clock.steps", steps, f"{said} makes {float(steps):,.0f} steps in an update")


def _moves(app: App) -> bool:
    from graph.sim.scene.scan import scan_stage

    return app.physics is not None or bool(scan_stage(app.stage).dynamic)
