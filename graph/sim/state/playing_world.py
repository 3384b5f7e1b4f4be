"""The interface of the world that edits of a playing stage need."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal, Protocol

from graph.base.errors import UserError

if TYPE_CHECKING:
    from graph.sim.fidelity import Fidelity
    from graph.sim.geometry.surfaces import Mesh, Plane
    from graph.sim.physics.protocol import EngineFactory, PhysicsEngine
    from graph.sim.scene.stage import Warn
    from graph.sim.state.prim_poses import PrimPoses


WhenPlaying = Literal["refuse", "restart", "recompile"]
CHOICES: tuple[WhenPlaying, ...] = ("refuse", "restart", "recompile")


def checked_choice(value: str) -> WhenPlaying:
    """One of `CHOICES`. Raises UserError for any other."""
    for choice in CHOICES:
        if value == choice:
            return choice
    raise UserError(f"when_playing {value!r} is not one of {', '.join(CHOICES)}")


class PlayingWorld(Protocol):
    """A stage with the physics and the Fabric that were built from it (`graph.sim.world.World`)."""

    stage: Any
    mjcf: Any
    fabric: PrimPoses
    engine: EngineFactory
    fidelity: Fidelity
    warn: Warn
    when_playing: WhenPlaying
    physics: PhysicsEngine | None
    built: bool
    steps_per_second: Fraction

    @property
    def meters_per_unit(self) -> float:
        """Metres in a unit of the stage."""

    def take_rate(self) -> None:
        """Takes a rate that was authored on the active physics scene since it was last called."""

    def geometry(self) -> tuple[Mesh | Plane, ...]:
        """The geometry for rays."""

    def forget_geometry(self) -> None:
        """Makes the geometry for rays be collected again."""
