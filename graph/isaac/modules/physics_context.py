"""`isaacsim.core.api.physics_context`: the settings of the physics scene."""

from __future__ import annotations

from typing import Any

from graph.isaac.outcomes import tell_inert
from graph.isaac.parameters import renamed
from graph.isaac.session import app
from graph.sim.usd import UsdGeom, UsdPhysics

from .prim_base import attribute

__all__ = ["PhysicsContext"]


class PhysicsContext:
    _gravity = 9.81

    def __init__(
        self,
        physics_dt: float | None = None,
        prim_path: str = "/physicsScene",
        sim_params: Any = None,
        set_defaults: bool = True,
    ) -> None:
        from graph.sim.scene.scene_attributes import scene_prims

        stage = app().stage
        found = next(scene_prims(stage), None)
        self.prim_path = prim_path if found is None else str(found.GetPath())
        self._scene = UsdPhysics.Scene.Define(stage, self.prim_path)
        self.device = "cpu"
        if set_defaults and found is None:
            self.set_gravity(-self._gravity / app().meters_per_unit)
        if physics_dt is not None or (set_defaults and found is None):
            self.set_physics_dt(physics_dt or 1 / 60)

    def get_current_physics_scene_prim(self) -> Any:
        return app().stage.GetPrimAtPath(self.prim_path)

    def set_physics_dt(self, dt: float = 1 / 60, substeps: int = 1) -> None:
        app().simulation.setup_simulation(dt=dt)

    def get_physics_dt(self) -> float:
        return float(app().simulation.get_physics_dt())

    def set_gravity(self, value: float) -> None:
        up = (0.0, 1.0, 0.0) if UsdGeom.GetStageUpAxis(app().stage) == "Y" else (0.0, 0.0, 1.0)
        sign = -1.0 if value <= 0 else 1.0
        self._scene.CreateGravityDirectionAttr().Set(tuple(sign * one for one in up))
        self._scene.CreateGravityMagnitudeAttr().Set(abs(float(value)))

    def get_gravity(self) -> tuple[list[float], float]:
        direction = self._scene.GetGravityDirectionAttr().Get() or (0, 0, -1)
        return list(direction), float(self._scene.GetGravityMagnitudeAttr().Get() or 0.0)

    def warm_start(self) -> None:
        app().simulation.initialize_physics()

    @property
    def use_fabric(self) -> bool:
        return bool(app().simulation.is_fabric_enabled())

    def enable_fabric(self, enable: bool) -> None:
        app().simulation.enable_fabric(enable)

    def _setting(self, name: str) -> Any:
        return self.get_current_physics_scene_prim().GetAttribute(f"physxScene:{name}")

    def set_physx_update_transformations_settings(
        self,
        update_to_usd: bool | None = None,
        update_velocities_to_usd: bool | None = None,
        output_velocities_local_space: bool | None = None,
    ) -> None:
        given = (update_to_usd, update_velocities_to_usd, output_velocities_local_space)
        for name, value in zip(_UPDATES, given, strict=True):
            if value is not None:
                app().settings.set(f"/physics/{name}", bool(value))

    def get_physx_update_transformations_settings(self) -> tuple[bool, bool, bool]:
        first, second, third = (bool(app().settings.get(f"/physics/{name}", False)) for name in _UPDATES)
        return first, second, third

    def __getattr__(self, name: str) -> Any:
        """Settings of GPUs and others that nothing here has: they do nothing."""
        word, _, rest = name.partition("_")
        if name.startswith("__") or word not in ("set", "get", "enable", "is", "use") or not rest:
            raise AttributeError(f"PhysicsContext has no {name}")

        def nothing(*_: Any, **__: Any) -> Any:
            tell_inert(f"isaacsim.core.api.PhysicsContext.{name}")
            return False if word in ("is", "get") else None

        return nothing


_UPDATES = ("updateToUsd", "updateVelocitiesToUsd", "outputVelocitiesLocalSpace")
_SCENE: dict[str, tuple[str, str, Any]] = {
    "ccd": ("enableCCD", "bool", False),
    "stablization": ("enableStabilization", "bool", False),
    "stabilization": ("enableStabilization", "bool", False),
    "gpu_dynamics": ("enableGPUDynamics", "bool", False),
    "solver_type": ("solverType", "token", "TGS"),
    "broadphase_type": ("broadphaseType", "token", "MBP"),
    "bounce_threshold": ("bounceThreshold", "float", 0.2),
    "friction_offset_threshold": ("frictionOffsetThreshold", "float", 0.04),
    "friction_correlation_distance": ("frictionCorrelationDistance", "float", 0.025),
    "enable_scene_query_support": ("enableSceneQuerySupport", "bool", True),
    "invert_collision_group_filter": ("invertCollisionGroupFilter", "bool", False),
    "solve_articulation_contact_last": ("solveArticulationContactLast", "bool", False),
}


def _scene_settings() -> None:
    """Gives PhysicsContext the calls for the settings of the scene's prim."""
    flags = ("ccd", "stablization", "stabilization", "gpu_dynamics")
    given = {"solver_type": "solver_type", "broadphase_type": "broadcast_type"}
    for word, (name, kind, default) in _SCENE.items():

        def setter(self: PhysicsContext, value: Any, name: str = name, kind: str = kind) -> None:
            attribute(self.get_current_physics_scene_prim(), f"physxScene:{name}", kind, value)

        def getter(self: PhysicsContext, name: str = name, default: Any = default) -> Any:
            found = self._setting(name)
            return found.Get() if found and found.HasAuthoredValue() else default

        parameter = "flag" if word in flags else given.get(word, word if "_" in word and kind == "bool" else "value")
        calls = (f"enable_{word}", f"is_{word}_enabled") if word in flags else (f"set_{word}", f"get_{word}")
        setattr(PhysicsContext, calls[0], renamed(setter, calls[0], parameter))
        setattr(PhysicsContext, calls[1], renamed(getter, calls[1]))


_scene_settings()
