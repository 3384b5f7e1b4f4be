"""The interface of the world that sensors need."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from graph.sim.fidelity import Fidelity
    from graph.sim.geometry.surfaces import Mesh, Plane
    from graph.sim.live.live_stage import LiveStage
    from graph.sim.phases import Callback, Unsubscribe
    from graph.sim.physics.protocol import PhysicsEngine
    from graph.sim.scene.stage import Warn
    from graph.sim.settings import Settings
    from graph.sim.state.prim_poses import PrimPoses
    from graph.sim.timing.time_queries import TimeQueries

    from .scheduler import SensorScheduler


class WorldView(Protocol):
    """What sensors see of a world (`graph.sim.world.World`), which is the same object for all frames.

    A `Tick` brings it to what measures; a sensor also gets it when it is made, for what it does between frames.
    """

    stage: Any
    fabric: PrimPoses
    """The present poses of all prims, and past ones."""
    physics: PhysicsEngine | None
    live: LiveStage | None
    fidelity: Fidelity
    settings: Settings
    seed: int
    """Of all random numbers."""
    warn: Warn
    folders: tuple[Path, ...] | None
    """Folders from which textures may be read, the first for relative names; None: from any."""
    times: TimeQueries
    """The exact time of physics [s], and past times."""
    rendering: SensorScheduler
    """The exact time of sensors [s], and the render products."""
    derived: dict[str, Any]
    """What sensors have made of the geometry, until that is collected again."""
    shared: dict[str, Any]
    """What sensors share as long as the world lives."""

    @property
    def meters_per_unit(self) -> float:
        """Metres in a unit of the stage."""

    @property
    def steps_per_second(self) -> Fraction:
        """The physics rate [Hz]."""

    def geometry(self) -> tuple[Mesh | Plane, ...]:
        """The geometry for rays."""

    def on(self, phase: str, callback: Callback, order: int = 0) -> Unsubscribe:
        """Calls `callback()` in a phase of every update or at an event; see `Phases.on`."""
