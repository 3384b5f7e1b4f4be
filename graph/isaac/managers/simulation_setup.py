"""The settings of a simulation: physics scenes and their rates, the engine, the device, Fabric."""

from __future__ import annotations

import logging
from dataclasses import replace
from fractions import Fraction
from typing import Any

from graph.base.errors import RunError
from graph.sim.attributes import applied_schemas
from graph.sim.fidelity import Fidelity
from graph.sim.physics import MUJOCO
from graph.sim.scene.scene_attributes import author, scene_prims
from graph.sim.simulation import Milestone, Simulation

from .physics_scene import DEFAULT_PATH, PhysicsScene, steps_per_second

DEFAULT_ENGINE = "/exts/isaacsim.core.simulation_manager/default_engine"
WRITE_BACK = ("updateToUsd", "updateParticlesToUsd", "updateVelocitiesToUsd", "updateForceSensorsToUsd")
_log = logging.getLogger("tickgraph.physics")


class SimulationSetup(Simulation):
    """The choices of Isaac Sim's SimulationManager on how a world is simulated."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.scene_path = DEFAULT_PATH
        """The path of the simulated scene, looked up when the world is built."""
        self._follow_stage = True
        self._set_while_playing: dict[tuple[str, str], tuple[str, Any]] = {}
        engine, active = self.get_default_engine(), self._world.engine.name
        if engine not in (MUJOCO.name, active):
            message = f'there is no physics engine "{engine}"; the active engine is "{active}"'
            self.warn("physics-engine-unavailable", DEFAULT_ENGINE, message)

    @property
    def stage(self) -> Any:
        """The stage that is simulated."""
        return self._world.stage

    @property
    def next_rate(self) -> Fraction:
        """The rate of the next step [Hz]: before play, that which play would take."""
        if not self.built:
            self._world.take_rate()
        return self.steps_per_second

    def warn(self, code: str, where: str, message: str) -> None:
        """Gives a warning."""
        self._world.warn(code, where, message)

    def setup_simulation(self, dt: float | Fraction | None = None, device: str | None = None) -> None:
        """Sets the length of a physics step [s] on every physics scene, also while playing.

        Creates a scene if the stage does not have one.

        While playing no prim is created, but the rate still takes effect. Raises ValueError unless 0 < dt <= 1, or for
        a device other than "cpu"; then nothing has changed.
        """
        rate = None if dt is None else steps_per_second(dt, truncate=self.truncates)
        if rate == 0:
            raise ValueError(f"dt {dt}: a physics step lasts more than 0 and at most 1 s")
        if device is not None:
            self.set_device(device)
        scenes = self._scenes()
        if rate is not None:
            self.set_rate(rate)
            for scene in scenes:
                scene.store_rate(rate)

    def set_physics_dt(self, dt: float | Fraction = 1 / 60, physics_scene: str | None = None) -> None:
        """Sets the dt [s] of one physics scene, or of all if the path is empty or invalid.

        Deprecated: use `PhysicsScene.set_dt`.

        Raises RuntimeError while playing, ValueError unless 0 <= dt <= 1.
        """
        if self._timeline.is_playing():
            raise RuntimeError("the physics dt cannot be set while playing; use setup_simulation(dt=...) or stop first")
        rate = steps_per_second(dt, truncate=self.truncates)
        scenes = self._scenes()
        chosen = [scene for scene in scenes if scene.path == physics_scene] or scenes
        for scene in chosen:
            scene.store_rate(rate)
        if not rate:
            self.refuse_rate_zero(chosen[0].path if chosen else DEFAULT_PATH)
        elif not scenes or chosen[0].path == scenes[0].path:
            self.set_rate(rate)

    def get_physics_dt(self, physics_scene: str | None = None) -> float:
        """The dt [s] of a physics scene.

        For an empty or invalid path, of the first scene; creates one if none exists and the timeline is stopped.
        """
        if self.built and physics_scene in (None, self.scene_path):
            prim = self.stage.GetPrimAtPath(self.scene_path)
            return PhysicsScene(prim, setup=self).get_dt() if prim else float(1 / self.next_rate)
        scenes = self._scenes()
        for scene in scenes:
            if scene.path == physics_scene:
                return scene.get_dt()
        return scenes[0].get_dt() if scenes else float(1 / self.next_rate)

    def get_physics_scenes(self) -> list[PhysicsScene]:
        """The physics scenes of the stage: `NewtonMjcScene` where MjcSceneAPI is applied, else `PhysxScene`."""
        from .mjc_scene import NewtonMjcScene
        from .physx_scene import PhysxScene

        return [
            (NewtonMjcScene if "MjcSceneAPI" in applied_schemas(prim) else PhysxScene)(prim, setup=self)
            for prim in scene_prims(self.stage)
        ]

    def _scenes(self) -> list[PhysicsScene]:
        """The stage's scenes; creates the first one if needed, unless the simulation plays."""
        scenes = [PhysicsScene(prim, setup=self) for prim in scene_prims(self.stage)]
        if not scenes and not self.built:
            scenes = [PhysicsScene(DEFAULT_PATH, setup=self)]
        return scenes

    def _reached(self, milestone: Milestone) -> None:
        if milestone == "built":
            self._world.fabric.follow_stage = self._follow_stage
            first = next(scene_prims(self.stage), None)
            self.scene_path = DEFAULT_PATH if first is None else str(first.GetPath())
        elif milestone == "restored":
            self._keep_scene_changes()

    def scene_changed(self, scene: PhysicsScene, name: str, kind: str, value: Any) -> None:
        """Called when an attribute of a scene was set while playing.

        Gravity changes at once, and the value outlasts the stop.
        """
        self._set_while_playing[scene.path, name] = kind, value
        if self._world.physics is not None and scene.path == self.scene_path and "ravity" in name:
            meters = self._world.meters_per_unit
            enabled = scene.get_enabled_gravity()
            gravity = scene.get_gravity() if enabled else (0.0, 0.0, 0.0)
            self._world.physics.set_gravity([each * meters for each in gravity])

    def _keep_scene_changes(self) -> None:
        """Authors values again, after stop has restored the stage, that were set on scenes while playing."""
        changes, self._set_while_playing = self._set_while_playing, {}
        for (path, name), (kind, value) in changes.items():
            prim = self.stage.GetPrimAtPath(path)
            if prim:
                author(prim, name, kind, value)

    def set_device(self, device: str) -> None:
        """Chooses the device of the physics. Raises ValueError for any other than "cpu"."""
        if str(device).lower() not in ("cpu", "cpu:0"):
            raise ValueError(
                f'device "{device}" is not available: the physics is MuJoCo on the CPU, and an engine that runs on a '
                'GPU is missing; use "cpu"'
            )

    def get_device(self) -> str:
        """The device of the physics: "cpu"."""
        return "cpu"

    def get_default_engine(self) -> str:
        """The engine in the settings; "mujoco" unless set."""
        return str(self._settings.get(DEFAULT_ENGINE))

    def get_active_physics_engine(self) -> str:
        """The engine that steps the world: "mujoco", unless the App was given another."""
        return self._world.engine.name

    def get_available_physics_engines(self, verbose: bool = False) -> list[tuple[str, bool]]:
        """(name, whether it is active) of each available engine; `verbose` also logs them."""
        engines = [(self.get_active_physics_engine(), True)]
        if verbose:
            _log.info("physics engines: %s", ", ".join(f"{name} (active)" if on else name for name, on in engines))
        return engines

    def switch_physics_engine(self, engine_name: str, verbose: bool = False) -> bool:
        """Makes an engine active, by its name in any case; False, and an error in the log, for an unknown one."""
        active = self.get_active_physics_engine()
        if engine_name.lower() != active.lower():
            _log.error('physics engine "%s" is not available; there is "%s"', engine_name, active)
            return False
        if verbose:
            _log.info("physics engine: %s", active)
        return True

    def enable_fabric(self, enable: bool) -> None:
        """Whether poses are written to Fabric instead of USD, from the next play on. Raises RunError while playing."""
        if self.built:
            raise RunError("Fabric cannot be switched while the simulation plays; call app.stop() first")
        Fidelity.from_mapping({"fabric": bool(enable)})  # refuses what cannot be run
        self._world.fidelity = replace(self._world.fidelity, fabric=bool(enable))
        for name in WRITE_BACK:
            self._settings.set(f"/physics/{name}", not enable)

    def is_fabric_enabled(self) -> bool:
        """Whether poses are written to Fabric."""
        return self._world.fidelity.fabric

    def enable_fabric_usd_notice_handler(self, stage_id: Any, enable: bool) -> None:
        """Whether Fabric follows edits of the stage; when switched on again it reads the whole stage.

        `stage_id` is this App's stage, or its id in `UsdUtils.StageCache`; ValueError for another.
        """
        self._check_stage(stage_id)
        self._world.fabric.follow_stage = self._follow_stage = bool(enable)
        if enable:
            self._world.fabric.forget()

    def is_fabric_usd_notice_handler_enabled(self, stage_id: Any) -> bool:
        """Whether Fabric follows edits of the stage. Raises ValueError for a stage of another App."""
        self._check_stage(stage_id)
        return self._follow_stage

    def _check_stage(self, stage_id: Any) -> None:
        from graph.sim.usd import UsdUtils

        stage = self.stage
        if isinstance(stage_id, int):
            known = UsdUtils.StageCache.Get().GetId(stage)
            if not known.IsValid() or known.ToLongInt() != stage_id:
                raise ValueError(f"stage id {stage_id} is not that of this App's stage; app.stage itself will do")
        elif stage_id != stage:
            raise ValueError("this is not the App's stage; give app.stage")

    def assets_loading(self) -> bool:
        """False: everything that a stage needs is loaded when it is opened."""
        return False
