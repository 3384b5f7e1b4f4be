"""The world of an App: built when it plays, freed when it stops, changed while it does."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from graph.base.errors import UserError

from . import settings as keys
from .fidelity import Fidelity
from .options import frames_come_later
from .scene.editing import EditStage, WhenPlaying, checked_choice, remove_prims
from .simulation import EXTERNAL_TIME
from .state.reset import Reset, reset

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from .app import App
    from .managers.simulation_manager import ManagedSimulation
    from .messages.bus import MessageBus
    from .renderer.rendering import Rendering
    from .settings import Settings


class World:
    """The part of an App that holds its stage, Fabric and physics together."""

    if TYPE_CHECKING:  # what the App brings
        stage: Any
        mjcf: Any
        settings: Settings
        fidelity: Fidelity
        simulation: ManagedSimulation
        rendering: Rendering
        bus: MessageBus
        warn: Callable[[str, str, str], None]

    def _make_world(self, when_playing: WhenPlaying) -> None:
        self.when_playing: WhenPlaying = when_playing
        self.fabric: Any = None
        self._stage_state: Any = None
        self.live: Any = None
        """Keeps the playing world and its stage together (`scene.live_stage.LiveStage`); None while stopped."""
        self.animation: Any = None
        """Plays transforms with time samples (`scene.animation.Animation`); None while stopped or without any."""
        self._geometry: Any = None
        self._renew_fabric()

    def _open_mjcf(self, mjcf: Any, stage: Any) -> Any:
        if isinstance(mjcf, (str, Path)):
            if stage is not None:
                raise UserError("App: give a stage or an MJCF file, not both")
            from .mjcf.scene import open_mjcf

            return open_mjcf(mjcf, warn=self.warn)
        return mjcf

    def geometry(self) -> Any:
        """What rays can hit (`graph.sim.geometry.collect.collect_geometry`), collected once per play."""
        if self._geometry is None:
            from .geometry.collect import collect_geometry
            from .scene.scan import scan_stage

            scan = scan_stage(self.stage, self.fabric.promoted)
            fine = self.fidelity.mesh_subdivision == "refined"
            self._geometry = collect_geometry(self.stage, self.fidelity.mesh_tolerance, self.warn, scan, refine=fine)
        return self._geometry

    def forget_geometry(self) -> None:
        """Has what rays can hit collected anew when it is needed next."""
        self._geometry = None

    def edit(self, when_playing: str | None = None) -> AbstractContextManager[Any]:
        """`with app.edit(when_playing="recompile") as stage:` changes the world while it plays too; see `EditStage`."""
        return EditStage(cast("App", self), self.when_playing if when_playing is None else checked_choice(when_playing))

    def add_prims(self, prims: Mapping[str, Mapping[str, Any]], when_playing: str | None = None) -> None:
        """Authors prims, path to keys as under `scene.prims` in a graph file, inside an `edit`."""
        from .scene.prims import author_prims

        with self.edit(when_playing) as stage:
            author_prims(stage, prims, warn=self.warn)

    def remove_prims(self, *paths: str, when_playing: str | None = None) -> None:
        """Removes prims, inside an `edit`. Raises UserError for one that is not there."""
        with self.edit(when_playing) as stage:
            remove_prims(stage, paths)

    def reset(self, scope: str | Reset = "all") -> None:
        """Begins anew while playing: the clocks, the bodies, without what was added, or all of it; see `Reset`."""
        reset(cast("App", self), scope)

    def _renew_fabric(self) -> None:
        from .state.fabric import Fabric
        from .state.stage_transforms import StageTransforms

        old = self.fabric
        kind: Any = Fabric if self.fidelity.fabric else StageTransforms
        self.fabric = kind(self.stage, self.warn)
        if old is None:
            self.fabric.set(*EXTERNAL_TIME, 0.0)
        else:
            self.fabric.take_values(old)
            old.close()

    def build_world(self) -> None:
        """Builds physics from the stage and binds Fabric and sensors to it; playing does so by itself."""
        from .physics import build_physics
        from .scene.animation import animate
        from .scene.live_stage import LiveStage
        from .scene.stage import StageState

        self._geometry = None
        if self.fabric.enabled != self.fidelity.fabric:
            self._renew_fabric()
        self._stage_state = StageState(self.stage)
        physics = None
        try:
            dt = 1 / self.simulation.steps_per_second
            physics = build_physics(self.stage, dt, self.fidelity, warn=self.warn, mjcf=self.mjcf)
            self.fabric.bind(physics)
        except BaseException:
            if physics is not None:
                physics.close()
            self._stage_state.restore()
            raise
        self._read_rendering_settings()
        self.rendering.capture_state = self.fabric.capture
        self.rendering.begin_play()
        self.simulation.physics = physics
        self.live = LiveStage(cast("App", self))
        self.animation = animate(cast("App", self))
        self.simulation.begin(physics)

    def free_world(self) -> None:
        """Frees what `build_world` has built and puts the stage back; stopping does so by itself."""
        if self.live is not None:
            self.live.close()
            self.live = None
        if self.animation is not None:
            self.animation.close()
            self.animation = None
        self.fabric.unbind()
        self.simulation.end()
        self.rendering.capture_state = None
        self.rendering.end_play()
        self.bus.restart()
        self._geometry = None
        self._stage_state.restore()
        self.simulation.keep_scene_changes()

    def _read_rendering_settings(self) -> None:
        settings, rendering = self.settings, self.rendering
        rendering.multi_tick = settings.get(keys.MULTI_TICK)
        rendering.capture_at_ticks = self.fidelity.tlas == "sensor" and settings.get(keys.SENSOR_TICK_TLAS)
        rendering.autotrigger_idle = settings.get(keys.AUTOTRIGGER_IDLE)
        rendering.frames_later = frames_come_later(settings)
