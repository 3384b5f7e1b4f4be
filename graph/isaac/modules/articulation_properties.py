"""Properties of `Articulation`: masses of links, frictions of joints, equations of motion, tendons."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import nullcontext
from functools import wraps
from typing import Any

import numpy as np

from graph.base.errors import RunError
from graph.isaac.results import Result, numbers, result, rows
from graph.isaac.session import app
from graph.sim.usd import Sdf, UsdPhysics


def at_once(setter: Callable[..., None]) -> Callable[..., None]:
    """Makes a setter of authored values act while physics runs, as the product's tensors do."""

    @wraps(setter)
    def live(self: Any, *values: Any, **chosen: Any) -> None:
        world = app()
        with nullcontext() if world.physics is None else world.edit(when_playing="recompile"):
            setter(self, *values, **chosen)

    return live


class Properties:
    """Properties are authored, and act at once; equations of motion are those of the present state."""

    paths: list[str]
    prims: list[Any]

    @property
    def num_dofs(self) -> int:
        raise NotImplementedError

    @property
    def link_paths(self) -> list[list[str]]:
        raise NotImplementedError

    def __len__(self) -> int:
        return len(self.paths)

    def _live(self, one: int = 0) -> Any:
        raise NotImplementedError

    def _joints(self, one: int = 0) -> list[Any]:
        raise NotImplementedError

    def is_physics_tensor_entity_initialized(self) -> bool:
        return app().physics is not None

    # -- authored numbers of joints, links and the whole ---------------------------------------------------------------

    def _dofs(self, indices: Any, dofs: Any) -> list[list[Any]]:
        found = [self._joints(one) for one in numbers(indices, len(self))]
        return [[joints[number] for number in numbers(dofs, len(joints))] for joints in found]

    def _links(self, indices: Any, links: Any) -> list[list[Any]]:
        stage = app().stage
        found = [self.link_paths[one] for one in numbers(indices, len(self))]
        return [[stage.GetPrimAtPath(paths[number]) for number in numbers(links, len(paths))] for paths in found]

    def get_dof_armatures(self, *, indices: Any = None, dof_indices: Any = None) -> Result:
        return result(_read(self._dofs(indices, dof_indices), "physxJoint:armature"))

    @at_once
    def set_dof_armatures(self, armatures: Any, *, indices: Any = None, dof_indices: Any = None) -> None:
        _write(self._dofs(indices, dof_indices), "physxJoint:armature", armatures)

    def get_dof_max_velocities(self, *, indices: Any = None, dof_indices: Any = None) -> Result:
        """[rad/s or stage units/s]."""
        found = self._dofs(indices, dof_indices)
        values = np.array(_read(found, "physxJoint:maxJointVelocity", np.inf))
        return result(values * [[_per_degree(prim) for prim in row] for row in found])

    @at_once
    def set_dof_max_velocities(self, max_velocities: Any, *, indices: Any = None, dof_indices: Any = None) -> None:
        found = self._dofs(indices, dof_indices)
        given = _matrix(max_velocities, found)
        _write(found, "physxJoint:maxJointVelocity", given / [[_per_degree(prim) for prim in row] for row in found])

    def get_dof_friction_properties(self, *, indices: Any = None, dof_indices: Any = None) -> tuple[Result, ...]:
        """Static, dynamic [N or N m] and viscous friction."""
        found = self._dofs(indices, dof_indices)
        return tuple(result(_read(found, f"physxJointAxis:{{axis}}:{name}")) for name in _FRICTIONS)

    @at_once
    def set_dof_friction_properties(
        self,
        static_frictions: Any = None,
        dynamic_frictions: Any = None,
        viscous_frictions: Any = None,
        *,
        indices: Any = None,
        dof_indices: Any = None,
    ) -> None:
        found = self._dofs(indices, dof_indices)
        for name, values in zip(_FRICTIONS, (static_frictions, dynamic_frictions, viscous_frictions), strict=True):
            if values is not None:
                for row in found:
                    for prim in row:
                        prim.AddAppliedSchema(f"PhysxJointAxisAPI:{_axis(prim)}")
                _write(found, f"physxJointAxis:{{axis}}:{name}", values)

    def get_link_masses(self, *, indices: Any = None, link_indices: Any = None, inverse: bool = False) -> Result:
        links = self._links(indices, link_indices)
        known = _by_path("masses")
        values = [[known.get(str(prim.GetPath()), _mass(prim)) for prim in row] for row in links]
        return result([[1 / one if inverse and one else one for one in row] for row in values])

    @at_once
    def set_link_masses(self, masses: Any, *, indices: Any = None, link_indices: Any = None) -> None:
        links = self._links(indices, link_indices)
        for prim, value in _each(links, masses):
            UsdPhysics.MassAPI.Apply(prim).CreateMassAttr().Set(float(value))

    def get_link_inertias(self, *, indices: Any = None, link_indices: Any = None, inverse: bool = False) -> Result:
        """(N, L, 9) about the centres of mass, along the links' axes."""
        links, known = self._links(indices, link_indices), _by_path("inertias")
        zero = np.zeros((3, 3))
        found = [[known.get(str(prim.GetPath()), zero) for prim in row] for row in links]
        turned = [[np.linalg.pinv(one) if inverse else one for one in row] for row in found]
        return result(np.reshape(turned, (len(links), -1, 9)))

    def get_link_enabled_gravities(self, *, indices: Any = None, link_indices: Any = None) -> Result:
        found = _read(self._links(indices, link_indices), "physxRigidBody:disableGravity")
        return result(np.array(found) == 0, bool)

    @at_once
    def set_link_enabled_gravities(self, enabled: Any, *, indices: Any = None, link_indices: Any = None) -> None:
        for prim, value in _each(self._links(indices, link_indices), np.asarray(enabled, float)):
            made = prim.CreateAttribute("physxRigidBody:disableGravity", Sdf.ValueTypeNames.Bool, custom=False)
            made.Set(not value)

    def get_sleep_thresholds(self, *, indices: Any = None) -> Result:
        return self._whole("sleepThreshold", indices)

    def set_sleep_thresholds(self, thresholds: Any, *, indices: Any = None) -> None:
        self._author("sleepThreshold", thresholds, indices)

    def get_stabilization_thresholds(self, *, indices: Any = None) -> Result:
        return self._whole("stabilizationThreshold", indices)

    def set_stabilization_thresholds(self, thresholds: Any, *, indices: Any = None) -> None:
        self._author("stabilizationThreshold", thresholds, indices)

    def get_solver_iteration_counts(self, *, indices: Any = None) -> tuple[Result, Result]:
        return (
            self._whole("solverPositionIterationCount", indices, 32),
            self._whole("solverVelocityIterationCount", indices, 1),
        )

    def set_solver_iteration_counts(
        self, position_counts: Any = None, velocity_counts: Any = None, *, indices: Any = None
    ) -> None:
        self._author("solverPositionIterationCount", position_counts, indices, "int")
        self._author("solverVelocityIterationCount", velocity_counts, indices, "int")

    def _whole(self, name: str, indices: Any, default: float = 0.0) -> Result:
        chosen = [[self.prims[one]] for one in numbers(indices, len(self))]
        return result(_read(chosen, f"physxArticulation:{name}", default))

    def _author(self, name: str, values: Any, indices: Any, kind: str = "float") -> None:
        if values is not None:
            chosen = [[self.prims[one]] for one in numbers(indices, len(self))]
            _write(chosen, f"physxArticulation:{name}", values, kind)

    # -- equations of motion -------------------------------------------------------------------------------------------

    def _terms(self, one: int) -> Any:
        found = self._live(one)
        if found is None:
            raise RunError(f"{self.paths[one]}: its equations of motion are known while the timeline plays; play first")
        return found.motion_terms(self.link_paths[one])

    @property
    def jacobian_matrix_shape(self) -> tuple[int, int, int]:
        shape = self.get_jacobian_matrices(indices=[0]).shape
        return int(shape[1]), int(shape[2]), int(shape[3])

    @property
    def mass_matrix_shape(self) -> tuple[int, int]:
        shape = self.get_mass_matrices(indices=[0]).shape
        return int(shape[1]), int(shape[2])

    def get_jacobian_matrices(self, *, indices: Any = None) -> Result:
        """(N, links, 6, joints), linear above angular; a fixed base is left out, a free one adds 6 columns."""
        found = [self._terms(one).jacobians for one in numbers(indices, len(self))]
        return result([one if one.shape[2] > self.num_dofs else one[1:] for one in found])

    def get_mass_matrices(self, *, indices: Any = None) -> Result:
        return result([self._terms(one).masses for one in numbers(indices, len(self))])

    def get_dof_gravity_compensation_forces(self, *, indices: Any = None, dof_indices: Any = None) -> Result:
        found = np.array([self._terms(one).gravity for one in numbers(indices, len(self))])
        return result(found if dof_indices is None else found[:, numbers(dof_indices, found.shape[1])])

    def get_dof_coriolis_and_centrifugal_compensation_forces(
        self, *, indices: Any = None, dof_indices: Any = None
    ) -> Result:
        found = np.array([self._terms(one).coriolis for one in numbers(indices, len(self))])
        return result(found if dof_indices is None else found[:, numbers(dof_indices, found.shape[1])])

    # -- fixed tendons -------------------------------------------------------------------------------------------------

    def _tendons(self, one: int = 0) -> list[tuple[Any, str]]:
        """The joint and the name of each fixed tendon's root."""
        roots = "PhysxTendonAxisRootAPI:"
        return [
            (prim, str(schema).removeprefix(roots))
            for prim in self._joints(one)
            for schema in prim.GetAppliedSchemas()
            if str(schema).startswith(roots)
        ]

    @property
    def num_fixed_tendons(self) -> int:
        return len(self._tendons())

    @property
    def fixed_tendon_names(self) -> list[str]:
        return [name for _, name in self._tendons()]

    def _tendon(self, name: str, indices: Any, tendons: Any, default: float = 0.0) -> Result:
        out = []
        for one in numbers(indices, len(self)):
            found = self._tendons(one)
            chosen = [found[number] for number in numbers(tendons, len(found))]
            out.append([_value(prim, f"physxTendon:{instance}:{name}", default) for prim, instance in chosen])
        return result(out)

    def get_fixed_tendon_stiffnesses(self, *, indices: Any = None, tendon_indices: Any = None) -> Result:
        return self._tendon("stiffness", indices, tendon_indices)

    def get_fixed_tendon_dampings(self, *, indices: Any = None, tendon_indices: Any = None) -> Result:
        return self._tendon("damping", indices, tendon_indices)

    def get_fixed_tendon_limit_stiffnesses(self, *, indices: Any = None, tendon_indices: Any = None) -> Result:
        return self._tendon("limitStiffness", indices, tendon_indices)

    def get_fixed_tendon_rest_lengths(self, *, indices: Any = None, tendon_indices: Any = None) -> Result:
        return self._tendon("restLength", indices, tendon_indices)

    def get_fixed_tendon_offsets(self, *, indices: Any = None, tendon_indices: Any = None) -> Result:
        return self._tendon("offset", indices, tendon_indices)

    def get_fixed_tendon_limits(self, *, indices: Any = None, tendon_indices: Any = None) -> tuple[Result, Result]:
        return (
            self._tendon("lowerLimit", indices, tendon_indices, -np.inf),
            self._tendon("upperLimit", indices, tendon_indices, np.inf),
        )


_FRICTIONS = ("staticFrictionEffort", "dynamicFrictionEffort", "viscousFrictionCoefficient")


def _axis(prim: Any) -> str:
    return "linear" if prim.IsA(UsdPhysics.PrismaticJoint) else "angular"


def _per_degree(prim: Any) -> float:
    return 1.0 if prim.IsA(UsdPhysics.PrismaticJoint) else float(np.pi / 180)


def _mass(prim: Any) -> float:
    return float(UsdPhysics.MassAPI(prim).GetMassAttr().Get() or 0.0)


def _by_path(name: str) -> dict[str, Any]:
    if app().physics is None:
        return {}
    tensors = app().simulation.tensors
    return dict(zip(tensors.body_paths, getattr(tensors, name), strict=True))


def _value(prim: Any, name: str, default: float = 0.0) -> float:
    attribute = prim.GetAttribute(name.format(axis=_axis(prim)))
    value = attribute.Get() if attribute else None
    return default if value is None else float(value)


def _read(prims: list[list[Any]], name: str, default: float = 0.0) -> list[list[float]]:
    return [[_value(prim, name, default) for prim in row] for row in prims]


def _matrix(values: Any, prims: list[list[Any]]) -> np.ndarray:
    width = len(prims[0]) if prims else 0
    array = np.asarray(values.numpy() if hasattr(values, "numpy") else values, np.float64)
    if array.size == 1:
        return np.full((len(prims), width), float(array.reshape(-1)[0]))
    found = rows(array, len(prims), width, "values")
    return np.zeros((0, width)) if found is None else found


def _each(prims: list[list[Any]], values: Any) -> Iterator[tuple[Any, float]]:
    for row, given in zip(prims, _matrix(values, prims), strict=True):
        yield from zip(row, given, strict=True)


def _write(prims: list[list[Any]], name: str, values: Any, kind: str = "float") -> None:
    for prim, value in _each(prims, values):
        full = name.format(axis=_axis(prim))
        made = prim.CreateAttribute(full, Sdf.ValueTypeNames.Find(kind), custom=False)
        made.Set(int(value) if kind == "int" else float(value))
