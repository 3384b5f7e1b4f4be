"""The world of an App: its stage, Fabric and physics; built by play, freed by stop, edited in between."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterable, Mapping
from contextlib import nullcontext
from fractions import Fraction
from pathlib import Path
from types import FunctionType
from typing import TYPE_CHECKING, Any

from graph.base.errors import UserError
from graph.base.plugins import MODELS, required
from graph.base.shorten import listed

from .fidelity import Fidelity
from .live.editing import EditStage, Player, remove_prims
from .physics import MUJOCO
from .renderer.view import WorldView
from .scene.placed_types import give_transforms
from .state.playing_world import WhenPlaying, checked_choice

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from .physics.protocol import EngineFactory, ModelScene
    from .scene.late_edits import LateEdits
    from .scene.stage import StageState, Warn
    from .state.prim_poses import PrimPoses

EXTERNAL_TIME = ("/ExternalSimulationTime", "omni:time")
"""The place of the renderer's clock in Fabric: prim and attribute."""


class World(WorldView):
    """Stage, Fabric and physics of one App; its player builds and frees it. Sensors see it as a `WorldView`.

    It moves no clock and no sensor: it only gives those of its App to sensors, which ask for times and other products.
    `mjcf` is the MJCF model that the stage mirrors, if any; `engine` makes the physics engine of each
    play in which something can move.
    """

    def __init__(
        self,
        stage: Any,
        *,
        mjcf: Any = None,
        engine: EngineFactory,
        fidelity: Fidelity,
        when_playing: WhenPlaying,
        warn: Warn,
    ) -> None:
        self.stage = stage
        give_transforms(stage)
        self.mjcf = mjcf
        self.engine = engine
        self.fidelity = fidelity
        self.when_playing: WhenPlaying = when_playing
        self.warn = warn
        self.folders = None
        self.steps_per_second = Fraction(60)
        """The rate with which physics is built [Hz]; see `set_rate`."""
        self._rate_taker: Callable[[], Callable[[], None] | None] = _nobody
        self.physics = None
        self.built = False
        """Whether a physical world exists: from play, or `initialize_physics`, to stop."""
        self.live = None
        self.fabric: PrimPoses = self._new_fabric()
        self._stage_state: StageState | None = None
        self._late: LateEdits | None = None
        self._geometry = None
        self.derived, self.shared = {}, {}
        self.fabric.set(*EXTERNAL_TIME, 0.0)

    @property
    def authored_rate(self) -> Fraction | None:
        """Steps per second [Hz] that the active physics scene or the MJCF model authors, or None."""
        from .scene.stage_metadata import physics_scene_rate

        return physics_scene_rate(self.stage) if self.mjcf is None else self.mjcf.physics_rate

    def set_rate(self, steps_per_second: Fraction) -> None:
        """Sets a new physics rate [Hz] from the next step on, also while playing."""
        self.steps_per_second = steps_per_second
        if self.physics is not None:
            self.physics.set_dt(1 / steps_per_second)

    def let_take_rate(self, taker: Callable[[], None]) -> None:
        """Gives the method that `take_rate` calls; held weakly, as its object holds the world."""
        self._rate_taker = weakref.WeakMethod(taker)

    def take_rate(self) -> None:
        """Takes a rate that was authored on the active physics scene since it was last called."""
        taker = self._rate_taker()
        if taker is not None:
            taker()

    # -- what rays can hit -------------------------------------------------------------------------------------------

    def forget_geometry(self) -> None:
        """Makes the geometry for rays be collected again at its next use."""
        self._geometry = None
        self.derived = {}

    # -- edits -------------------------------------------------------------------------------------------------------

    def edit(self, player: Player, when_playing: str | None = None) -> AbstractContextManager[Any]:
        """`with world.edit(player, "recompile") as stage:` changes the world, also while playing; see `EditStage`."""
        choice = self.when_playing if when_playing is None else checked_choice(when_playing)
        return EditStage(self, player, choice)

    def add_prims(
        self,
        player: Player,
        prims: Mapping[str, Mapping[str, Any]],
        when_playing: str | None = None,
        author: Callable[..., None] | None = None,
    ) -> None:
        """Authors prims inside an `edit`; path to keys as under `scene.prims` in a graph file.

        author: `author_prims` with what it must know of sensors; None knows the prim types of USD schemas alone.
        """
        from .scene.prims import author_prims

        with self.edit(player, when_playing) as stage:
            (author or author_prims)(stage, prims, warn=self.warn)

    def remove_prims(self, player: Player, *paths: str, when_playing: str | None = None) -> None:
        """Removes prims inside an `edit`. Raises UserError for a missing prim."""
        with self.edit(player, when_playing) as stage:
            remove_prims(stage, paths)

    # -- life --------------------------------------------------------------------------------------------------------

    def build(self) -> None:
        """Builds physics from the stage and binds Fabric to it; on failure the stage is restored."""
        from graph.sim.scene.diagnostics import reading

        from .live.live_stage import LiveStage
        from .physics import build_physics
        from .scene.stage import StageState
        from .scene.stage_faults import repair_turns
        from .scene.stage_metadata import scene_name

        repair_turns(self.stage, self.warn)
        self.forget_geometry()
        if self.fabric.enabled != self.fidelity.fabric:
            old, self.fabric = self.fabric, self._new_fabric()
            self.fabric.take_values(old)
            old.close()
        self._stage_state = StageState(self.stage)
        physics = None
        try:
            dt = 1 / self.steps_per_second
            with reading(scene_name(self.stage)):
                physics = build_physics(
                    self.stage, dt, self.fidelity, engine=self.engine, warn=self.warn, mjcf=self.mjcf
                )
                self.fabric.bind(physics)
        except BaseException:
            if physics is not None:
                physics.close()
            self._stage_state.restore()
            raise
        self.physics = physics
        self.live = LiveStage(self)
        self.built = True

    def release(self) -> None:
        """Frees what `build` has made; the stage stays unchanged until `restore`."""
        if self._late is not None:
            self._late.take()
        if self.live is not None:
            self.live.close()
            self.live = None
        self.fabric.unbind()
        physics, self.physics = self.physics, None
        self.built = False
        self.forget_geometry()
        if physics is not None:
            physics.close()

    def stop_requested(self) -> None:
        """Edits from now on are those of a stopped world, unless an update runs, which plays on to its end."""
        from .scene.late_edits import LateEdits

        if self.built and self._late is None and not self.phases.running:
            self._late = LateEdits(self.stage)

    def restore(self) -> None:
        """Restores the stage to its state when `build` began; what was edited since a stop was requested stays."""
        late, self._late = self._late, None
        if self._stage_state is None:
            return
        with nullcontext() if late is None else late.put_back():
            self._stage_state.restore()

    def take_stage(self, stage: Any) -> None:
        """Puts another stage in the place of the present one, while stopped; an MJCF model ends with its stage."""
        self.fabric.close()
        self.stage, self.mjcf = stage, None
        give_transforms(stage)
        self._stage_state = None
        self.forget_geometry()
        self.fabric = self._new_fabric()
        self.fabric.set(*EXTERNAL_TIME, 0.0)

    def close(self) -> None:
        """Stops listening to the stage, and lets go of what sensors made of it and of what refers to them."""
        self.fabric.close()
        self.forget_geometry()
        self.shared.clear()
        del self.rendering, self.times

    def _new_fabric(self) -> PrimPoses:
        from .state.fabric import Fabric
        from .state.stage_transforms import StageTransforms

        return (Fabric if self.fidelity.fabric else StageTransforms)(self.stage, self.warn)


def _nobody() -> None:
    """There is no clock yet."""


def open_world(
    stage: Any,
    mjcf: Any,
    *,
    engine: EngineFactory,
    fidelity: Fidelity,
    when_playing: WhenPlaying,
    warn: Warn,
    allow: Iterable[str | Path] = (),
) -> World:
    """The world of a stage (the path of a USD file, a `Usd.Stage`, None: an empty one) or of an MJCF file or model.

    allow: further folders to which the USD file may refer. Graphs of a USD file do not run here: `graphs-not-run` names
    them. Raises UserError for anything else, if both are given, and for an MJCF model that `engine` does not simulate.
    """
    from .scene.stage import open_stage, register_schemas

    if mjcf is not None and engine is not MUJOCO:
        raise UserError(f"App: {engine.name} does not simulate MJCF models; leave out physics=")
    if isinstance(mjcf, (str, Path)):
        if stage is not None:
            raise UserError("App: give a stage or an MJCF file, not both")
        mjcf = model_opener()(mjcf, warn=warn)
    if mjcf is not None:
        stage = mjcf.stage
    if stage is None or isinstance(stage, (str, Path)):
        roots = None if stage is None else [Path(stage).expanduser().absolute().parent, *allow]
        path, stage = stage, open_stage(stage, roots, warn)
        if path is not None:
            _tell_graphs(stage, path, warn)
    else:
        register_schemas()
        if not hasattr(stage, "GetRootLayer"):
            raise UserError(f"stage {stage!r}: give the path of a USD file, a Usd.Stage, or None for an empty one")
    return World(stage, mjcf=mjcf, engine=engine, fidelity=fidelity, when_playing=when_playing, warn=warn)


def model_opener() -> Callable[..., ModelScene]:
    """The function of a plug-in that opens MJCF and URDF files."""
    return required(MODELS, "mjcf", FunctionType, "scene format")


def _tell_graphs(stage: Any, path: str | Path, warn: Warn) -> None:
    paths = [str(prim.GetPath()) for prim in stage.Traverse() if prim.GetTypeName() in ("OmniGraph", "ComputeGraph")]
    if paths:
        message = f"its graphs do not run in App(stage=...): {listed(paths)}; App.from_file({str(path)!r}) runs them"
        warn("graphs-not-run", str(path), message)
