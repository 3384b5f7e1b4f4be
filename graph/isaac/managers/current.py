"""Isaac Sim's managers under their own names: calls on the class act on the most recently entered App.

    from graph.sim import App, RenderingManager, SimulationManager
    with App(...):
        SimulationManager.setup_simulation(dt=1 / 240)

`SimulationManager.step` is `App.current().simulation.step`, `RenderingManager.set_dt` that of `.rendering`.
"""

from __future__ import annotations

from typing import Any

from graph.base.errors import UserError
from graph.sim import entered


class _OfCurrentApp(type):
    """Looks up every name of the class on a part of the current App."""

    part: str

    def __new__(cls, name: str, bases: tuple[type, ...], body: dict[str, Any], part: str) -> _OfCurrentApp:
        made = super().__new__(cls, name, bases, body)
        made.part = part
        return made

    def __init__(cls, name: str, bases: tuple[type, ...], body: dict[str, Any], part: str) -> None:
        super().__init__(name, bases, body)

    def __getattr__(cls, name: str) -> Any:
        if name.startswith("__"):  # attributes that Python itself reads from a class
            raise AttributeError(name)
        return getattr(cls._target(), name)

    def __dir__(cls) -> list[str]:
        try:
            return dir(cls._target())
        except UserError:
            return []

    def _target(cls) -> Any:
        return getattr(entered.current(), cls.part)


class SimulationManager(metaclass=_OfCurrentApp, part="simulation"):
    """`app.simulation` of the current App: `simulation_manager.ManagedSimulation` documents the calls."""


class RenderingManager(metaclass=_OfCurrentApp, part="rendering"):
    """`app.rendering` of the current App: `graph.isaac.managers.rendering.Rendering` documents the calls."""
