"""The sentence about ticks that a sensor missed, and why: of `graph explain`, `graph run`, `--strict` and tests."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from graph.sim.app import App

FASTER_THAN_LOOP = "sensor-faster-than-loop"
OFF_THE_GRID = "sensor-ticks-off-grid"


def missed_ticks(app: App, path: str, rate: Fraction | float, missed: int, due: int) -> tuple[str, str, str]:
    """Code, place and message for a sensor of this rate [Hz] that missed some of its ticks."""
    counted = f"{missed:,} of {due:,} ticks are passed over"
    if rate > app.loop_rate:
        cause = "at most one frame an update; raise loop_hz and physics_hz, or lower the tick rate"
        return FASTER_THAN_LOOP, path, f"{counted}: {cause}"
    cause = (
        "updates end between two ticks and then hold none, or two; make physics_hz a multiple of both loop_hz "
        f"({float(app.loop_rate):g} Hz) and the tick rate ({float(rate):g} Hz)"
    )
    return OFF_THE_GRID, path, f"{counted}: {cause}"


def missed_in_run(app: App) -> Iterator[tuple[str, str, str]]:
    """The same for each sensor of a run that missed ticks."""
    counts: dict[str, tuple[Fraction, int, int]] = {}
    for product in app.rendering.history:
        if product.missed:
            _, missed, due = counts.get(product.camera_path, (0, 0, 0))
            counts[product.camera_path] = product.sensor.rate, missed + product.missed, due + product.due
    for path, (rate, missed, due) in counts.items():
        yield missed_ticks(app, path, rate, missed, due)
