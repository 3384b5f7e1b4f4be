"""Physics scenes in PhysX's terms: Isaac Sim's calls, stored on the prim if MuJoCo has no such setting."""

from __future__ import annotations

from dataclasses import dataclass, fields
from fractions import Fraction

from graph.base import exact

from .physics_scene import PhysicsScene

_CPU = "the physics runs on the CPU"
_ENGINE = "MuJoCo solves contacts its own way"


@dataclass(kw_only=True)
class PhysxGpuCfg:
    """Sizes of PhysX's GPU buffers (bytes or counts); None means unchanged, or not authored."""

    gpu_collision_stack_size: int | None = None
    gpu_found_lost_aggregate_pairs_capacity: int | None = None
    gpu_found_lost_pairs_capacity: int | None = None
    gpu_heap_capacity: int | None = None
    gpu_max_deformable_surface_contacts: int | None = None
    gpu_max_num_partitions: int | None = None
    gpu_max_particle_contacts: int | None = None
    gpu_max_rigid_contact_count: int | None = None
    gpu_max_rigid_patch_count: int | None = None
    gpu_max_soft_body_contacts: int | None = None
    gpu_temp_buffer_capacity: int | None = None
    gpu_total_aggregate_pairs_capacity: int | None = None


class PhysxScene(PhysicsScene):
    """A physics scene with PhysX's settings.

    Rate, gravity and iterations work as in `PhysicsScene`. All other settings are stored on the prim for PhysX and have
    no effect here: setting one gives the warning `physics-setting-stored`.
    """

    def get_steps_per_second(self) -> int | float:
        """Physics steps per second [Hz]; whole numbers as int."""
        rate = self._rate()
        return rate.numerator if rate.denominator == 1 else float(rate)

    def set_steps_per_second(self, steps_per_second: float | Fraction) -> None:
        """Sets the rate [Hz]; whole numbers only in the profile `isaacsim-6.0.1`. Raises ValueError below 0."""
        rate = exact.rate(steps_per_second)
        if rate < 0:
            raise ValueError(f"steps per second {steps_per_second}: give 0 or more")
        truncated = self._setup is not None and self._setup.truncates
        self._set_rate(Fraction(int(rate)) if truncated else rate)

    def get_solver_type(self) -> str:
        """The PhysX solver of the prim: "TGS" (default) or "PGS"."""
        return str(self._authored("physxScene:solverType", "TGS"))

    def set_solver_type(self, solver_type: str) -> None:
        """Stores "TGS" or "PGS" on the prim. Raises ValueError for another."""
        self._choose("solverType", solver_type, ("TGS", "PGS"), f"{_ENGINE}; `NewtonMjcScene.set_solver` chooses how")

    def get_broadphase_type(self) -> str:
        """The PhysX broad phase of the prim: "MBP", "GPU" (default) or "SAP"."""
        return str(self._authored("physxScene:broadphaseType", "GPU"))

    def set_broadphase_type(self, broadphase_type: str) -> None:
        """Stores "MBP", "GPU" or "SAP" on the prim. Raises ValueError for another."""
        self._choose("broadphaseType", broadphase_type, ("MBP", "GPU", "SAP"), "MuJoCo has one broad phase of its own")

    def get_enabled_gpu_dynamics(self) -> bool:
        """Whether the prim requests GPU dynamics of PhysX; True unless authored."""
        return bool(self._authored("physxScene:enableGPUDynamics", True))

    def set_enabled_gpu_dynamics(self, enabled: bool) -> None:
        """Stores the switch on the prim; enabling it turns CCD off."""
        self._switch("enableGPUDynamics", enabled, _CPU)
        if enabled:
            self.set_enabled_ccd(False)

    def get_enabled_ccd(self) -> bool:
        """Whether the prim requests continuous collision detection; False unless authored."""
        return bool(self._authored("physxScene:enableCCD", False))

    def set_enabled_ccd(self, enabled: bool) -> None:
        """Stores the switch on the prim."""
        self._switch("enableCCD", enabled, "MuJoCo does not sweep; fast and thin bodies want a higher physics_hz")

    def get_enabled_stabilization(self) -> bool:
        """Whether the prim requests stabilization of resting bodies by PhysX; False unless authored."""
        return bool(self._authored("physxScene:enableStabilization", False))

    def set_enabled_stabilization(self, enabled: bool) -> None:
        """Stores the switch on the prim."""
        self._switch("enableStabilization", enabled, _ENGINE)

    def get_gpu_configuration(self) -> PhysxGpuCfg:
        """The sizes of GPU buffers that the prim authors, PhysX's own for the others."""
        return PhysxGpuCfg(**{name: self._authored(_gpu_attribute(name), size) for name, size in _GPU_SIZES.items()})

    def set_gpu_configuration(self, cfg: PhysxGpuCfg | dict[str, int]) -> None:
        """Stores the given sizes on the prim. Raises ValueError below 0."""
        configuration = PhysxGpuCfg(**cfg) if isinstance(cfg, dict) else cfg
        sizes = {each.name: getattr(configuration, each.name) for each in fields(PhysxGpuCfg)}
        for name, size in sizes.items():
            if size is not None and size < 0:
                raise ValueError(f"{name} {size}: give 0 or more")
        for name, size in sizes.items():
            if size is not None:
                self._author(_gpu_attribute(name), "UInt", int(size))
                self._stored_only(_gpu_attribute(name), _CPU)

    def _choose(self, name: str, value: str, choices: tuple[str, ...], why: str) -> None:
        if value not in choices:
            raise ValueError(f"{name} {value!r} is not one of {', '.join(choices)}")
        self._author(f"physxScene:{name}", "Token", value)
        self._stored_only(f"physxScene:{name}", why)

    def _switch(self, name: str, value: bool, why: str) -> None:
        self._author(f"physxScene:{name}", "Bool", bool(value))
        if value:
            self._stored_only(f"physxScene:{name}", why)


_GPU_SIZES = {
    "gpu_collision_stack_size": 1 << 26,
    "gpu_found_lost_aggregate_pairs_capacity": 1 << 10,
    "gpu_found_lost_pairs_capacity": 1 << 18,
    "gpu_heap_capacity": 1 << 26,
    "gpu_max_deformable_surface_contacts": 1 << 20,
    "gpu_max_num_partitions": 8,
    "gpu_max_particle_contacts": 1 << 20,
    "gpu_max_rigid_contact_count": 1 << 19,
    "gpu_max_rigid_patch_count": 81920,
    "gpu_max_soft_body_contacts": 1 << 20,
    "gpu_temp_buffer_capacity": 1 << 24,
    "gpu_total_aggregate_pairs_capacity": 1 << 10,
}


def _gpu_attribute(name: str) -> str:
    present = {"gpu_max_soft_body_contacts": "gpu_max_deformable_volume_contacts"}
    return f"physxScene:{_camel(present.get(name, name))}"


def _camel(name: str) -> str:
    first, *others = name.split("_")
    return first + "".join(word.capitalize() for word in others)
