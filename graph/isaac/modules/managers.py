"""`isaacsim.core.simulation_manager` and `isaacsim.core.rendering_manager`."""

from __future__ import annotations

from typing import Any, ClassVar

from graph.isaac.managers.mjc_scene import NewtonMjcScene
from graph.isaac.managers.physics_scene import PhysicsScene
from graph.isaac.managers.physx_scene import PhysxGpuCfg, PhysxScene
from graph.isaac.managers.rendering import RenderingEvent
from graph.isaac.managers.simulation_events import IsaacEvents, SimulationEvent
from graph.isaac.outcomes import tell_inert
from graph.isaac.run import RUN
from graph.isaac.session import app, kit
from graph.sim.scene.scene_attributes import scene_prims

from .prim_base import attribute

__all__ = [
    "IsaacEvents",
    "NewtonMjcScene",
    "PhysicsScene",
    "PhysxGpuCfg",
    "PhysxScene",
    "RenderingEvent",
    "RenderingManager",
    "SimulationEvent",
    "SimulationManager",
]


class _Of(type):
    """Looks up every other name of the class on a part of the App."""

    def __getattr__(cls, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(getattr(app(), cls._part), name)


class SimulationManager(metaclass=_Of):
    _part: ClassVar[str] = "simulation"
    _backend: ClassVar[str] = "numpy"

    @classmethod
    def step(cls, *, steps: int = 1, callback: Any = None, update_fabric: bool = False) -> None:
        run = RUN.get()
        if run is not None:
            run.check()
        app().simulation.step(steps=steps, callback=callback, update_fabric=update_fabric)

    @classmethod
    def set_backend(cls, val: str) -> None:
        SimulationManager._backend = val

    @classmethod
    def get_backend(cls) -> str:
        return cls._backend

    @classmethod
    def set_physics_sim_device(cls, val: str) -> None:
        app().simulation.set_device("cpu" if str(val).startswith("cpu") else val)

    @classmethod
    def get_physics_sim_device(cls) -> str:
        return str(app().simulation.get_device())

    @classmethod
    def get_physics_sim_view(cls) -> Any:
        return app().simulation.get_physics_simulation_view()

    @classmethod
    def get_default_physics_scene(cls) -> str | None:
        found = next(scene_prims(app().stage), None)
        return None if found is None else str(found.GetPath())

    @classmethod
    def set_default_physics_scene(cls, physics_scene_prim_path: str) -> None:
        """The first scene of the stage is in force. Raises ValueError if the path is not that of a physics scene."""
        path = str(physics_scene_prim_path)
        if path not in (str(one.GetPath()) for one in scene_prims(app().stage)):
            raise ValueError(f"{path} is not a physics scene")
        if path != cls.get_default_physics_scene():
            tell_inert("isaacsim.core.simulation_manager.SimulationManager.set_default_physics_scene")

    @classmethod
    def _scene(cls, path: str | None) -> Any:
        return app().stage.GetPrimAtPath(path or cls.get_default_physics_scene() or PhysicsScene().path)

    @classmethod
    def enable_ccd(cls, flag: bool, physics_scene: str | None = None) -> None:
        attribute(cls._scene(physics_scene), "physxScene:enableCCD", "bool", bool(flag))

    @classmethod
    def enable_gpu_dynamics(cls, flag: bool, physics_scene: str | None = None) -> None:
        attribute(cls._scene(physics_scene), "physxScene:enableGPUDynamics", "bool", bool(flag))

    @classmethod
    def enable_stablization(cls, flag: bool, physics_scene: str | None = None) -> None:
        attribute(cls._scene(physics_scene), "physxScene:enableStabilization", "bool", bool(flag))

    @classmethod
    def _setting(cls, name: str, scene: str | None, default: Any) -> Any:
        found = cls._scene(scene).GetAttribute(f"physxScene:{name}")
        return found.Get() if found and found.HasAuthoredValue() else default

    @classmethod
    def is_ccd_enabled(cls, physics_scene: str | None = None) -> bool:
        return bool(cls._setting("enableCCD", physics_scene, False))

    @classmethod
    def is_gpu_dynamics_enabled(cls, physics_scene: str | None = None) -> bool:
        return bool(cls._setting("enableGPUDynamics", physics_scene, False))

    @classmethod
    def is_stablization_enabled(cls, physics_scene: str | None = None) -> bool:
        return bool(cls._setting("enableStabilization", physics_scene, False))

    @classmethod
    def set_solver_type(cls, solver_type: str, physics_scene: str | None = None) -> None:
        attribute(cls._scene(physics_scene), "physxScene:solverType", "token", solver_type)

    @classmethod
    def get_solver_type(cls, physics_scene: str | None = None) -> str:
        return str(cls._setting("solverType", physics_scene, "TGS"))

    @classmethod
    def set_broadphase_type(cls, val: str, physics_scene: str | None = None) -> None:
        attribute(cls._scene(physics_scene), "physxScene:broadphaseType", "token", val)

    @classmethod
    def get_broadphase_type(cls, physics_scene: str | None = None) -> str:
        return str(cls._setting("broadphaseType", physics_scene, "MBP"))


class RenderingManager(metaclass=_Of):
    _part: ClassVar[str] = "rendering"

    @classmethod
    def render(cls) -> None:
        run = RUN.get()
        if run is not None:
            run.check()
        app().rendering.render()
        kit().turn()

    @classmethod
    async def render_async(cls) -> None:
        await app().rendering.render_async()
