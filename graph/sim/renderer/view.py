"""What sensors see of the world."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graph.sim.fidelity import Fidelity
    from graph.sim.geometry.surfaces import Mesh, Plane
    from graph.sim.live.live_stage import LiveStage
    from graph.sim.phases import Callback, Phases, Unsubscribe
    from graph.sim.physics.protocol import PhysicsEngine
    from graph.sim.scene.stage import Warn
    from graph.sim.settings import Settings
    from graph.sim.state.prim_poses import PrimPoses
    from graph.sim.timing.time_queries import TimeQueries

    from .scheduler import SensorScheduler


class WorldView:
    """What sensors see of a world: the part of `graph.sim.world.World` that they read. One object for all frames.

    A `Tick` brings it to what measures; a sensor also gets it when it is made, for what it does between frames.
    """

    stage: Any
    fabric: PrimPoses
    """The present poses of all prims, and past ones."""
    physics: PhysicsEngine | None
    """The physics engine; None while stopped or when nothing is dynamic."""
    live: LiveStage | None
    """Keeps the playing world and its stage consistent; None while stopped."""
    fidelity: Fidelity
    settings: Settings
    steps_per_second: Fraction
    """The physics rate [Hz]."""
    seed: int
    """Of all random numbers."""
    warn: Warn
    folders: tuple[Path, ...] | None
    """Folders from which nodes and textures may read files: the file's own, then those the user allows.

    Relative names are below the first. None: no file describes the scene; the program that does may read any.
    """
    phases: Phases
    times: TimeQueries
    """The exact time of physics [s], and past times."""
    rendering: SensorScheduler
    """The exact time of sensors [s], and the render products."""
    derived: dict[str, Any]
    """What sensors have made of the geometry, until that is collected again."""
    _geometry: tuple[Mesh | Plane, ...] | None
    shared: dict[str, Any]
    """What sensors share as long as the world lives."""

    @property
    def meters_per_unit(self) -> float:
        """Metres in a unit of the stage, as Fabric has them."""
        return self.fabric.meters_per_unit

    def geometry(self) -> tuple[Mesh | Plane, ...]:
        """The geometry for rays (`graph.sim.geometry.collect.collect_geometry`), collected once per play."""
        if self._geometry is None:
            from graph.sim.geometry.collect import collect_geometry
            from graph.sim.scene.diagnostics import quiet
            from graph.sim.scene.scan import scan_stage
            from graph.sim.scene.stage_metadata import scene_name

            fine, exact = self.fidelity.mesh_subdivision == "refined", self.fidelity.mesh_solids == "exact"
            with quiet(self.warn, scene_name(self.stage)):
                scan = scan_stage(self.stage, self.fabric.promoted)
                self._geometry = collect_geometry(
                    self.stage, self.fidelity.mesh_tolerance, self.warn, scan, refine=fine, exact=exact
                )
        return self._geometry

    def on(self, phase: str, callback: Callback, order: int = 0) -> Unsubscribe:
        """Calls `callback()` in a phase of every update or at an event; see `Phases.on`."""
        return self.phases.on(phase, callback, order)
