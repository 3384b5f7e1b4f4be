"""`isaacsim.core.experimental.prims`: wrappers of one prim or several."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.results import Result, numbers, result, rows, words
from graph.isaac.session import app
from graph.sim.usd import Gf, UsdGeom, UsdPhysics
from sensors.inertial import attribute_of

from .articulation import Articulation
from .own_schemas import applied
from .prim_base import Prim, attribute, found_or_new
from .xform_prim import XformPrim

__all__ = ["Articulation", "GeomPrim", "Prim", "RigidPrim", "XformPrim"]


class GeomPrim(XformPrim):
    def __init__(
        self, paths: Any, *, apply_collision_apis: bool = False, resolve_paths: bool = True, **pose: Any
    ) -> None:
        super().__init__(paths, resolve_paths=resolve_paths, **pose)
        if apply_collision_apis:
            self.apply_collision_apis()

    @property
    def geoms(self) -> list[Any]:
        return [UsdGeom.Gprim(prim) for prim in self.prims]

    def apply_collision_apis(self, *, indices: Any = None) -> None:
        for one in numbers(indices, len(self)):
            UsdPhysics.CollisionAPI.Apply(self.prims[one])

    def set_enabled_collisions(self, enabled: Any, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        for one, value in zip(chosen, words(enabled, len(chosen)), strict=True):
            UsdPhysics.CollisionAPI.Apply(self.prims[one]).CreateCollisionEnabledAttr().Set(bool(value))

    def get_enabled_collisions(self, *, indices: Any = None) -> Result:
        found = [
            UsdPhysics.CollisionAPI(self.prims[one]).GetCollisionEnabledAttr() for one in numbers(indices, len(self))
        ]
        return result([[bool(one) and bool(one.Get())] for one in found], bool)

    def apply_physics_materials(
        self, materials: Any, *, weaker_than_descendants: Any = None, indices: Any = None
    ) -> None:
        from graph.sim.usd import UsdShade

        chosen = numbers(indices, len(self))
        for one, material in zip(chosen, words(materials, len(chosen)), strict=True):
            binding = UsdShade.MaterialBindingAPI.Apply(self.prims[one])
            for prim in material.prims[:1]:
                binding.Bind(UsdShade.Material(prim), UsdShade.Tokens.weakerThanDescendants, "physics")

    def set_collision_approximations(self, approximations: Any, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        for one, value in zip(chosen, words(approximations, len(chosen)), strict=True):
            UsdPhysics.MeshCollisionAPI.Apply(self.prims[one]).CreateApproximationAttr().Set(value)

    def set_offsets(self, contact_offsets: Any = None, rest_offsets: Any = None, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        for name, values in (("contactOffset", contact_offsets), ("restOffset", rest_offsets)):
            given = rows(values, len(chosen), None, name)
            for one, row in zip(chosen, range(len(chosen)), strict=True):
                if given is not None:
                    attribute(self.prims[one], f"physxCollision:{name}", "float", float(given[row]))

    def get_offsets(self, *, indices: Any = None) -> tuple[Result, Result]:
        """Contact and rest offsets [stage units]; PhysX's own choice is -inf."""
        chosen = [self.prims[one] for one in numbers(indices, len(self))]
        names = ("contactOffset", "restOffset")
        found = [[[attribute_of(prim, f"physxCollision:{name}", -np.inf)] for prim in chosen] for name in names]
        return result(found[0]), result(found[1])

    def get_collision_approximations(self, *, indices: Any = None) -> list[str]:
        chosen = [self.prims[one] for one in numbers(indices, len(self))]
        return [str(attribute_of(prim, "physics:approximation", "none")) for prim in chosen]

    def get_applied_physics_materials(self, *, indices: Any = None) -> list[Any]:
        from graph.sim.usd import UsdShade

        from .physics_materials import PhysicsMaterial

        found = [UsdShade.MaterialBindingAPI(self.prims[one]) for one in numbers(indices, len(self))]
        bound = [one.GetDirectBinding("physics").GetMaterial() for one in found]
        return [PhysicsMaterial.fetch_instances(one.GetPrim())[0] if one else None for one in bound]

    def set_torsional_patch_radii(self, radii: Any, *, indices: Any = None, minimum: bool = False) -> None:
        chosen = numbers(indices, len(self))
        given = rows(radii, len(chosen), None, "radii")
        for one, value in zip(chosen, () if given is None else given, strict=True):
            attribute(self.prims[one], f"physxCollision:{_patch(minimum)}", "float", float(value))

    def get_torsional_patch_radii(self, *, indices: Any = None, minimum: bool = False) -> Result:
        chosen = [self.prims[one] for one in numbers(indices, len(self))]
        return result([[attribute_of(prim, f"physxCollision:{_patch(minimum)}", 0.0)] for prim in chosen])


def _patch(minimum: bool) -> str:
    return "minTorsionalPatchRadius" if minimum else "torsionalPatchRadius"


class RigidPrim(XformPrim):
    def __init__(
        self,
        paths: Any,
        *,
        masses: Any = None,
        densities: Any = None,
        contact_filter_paths: Any = None,
        max_contact_count: int = 0,
        resolve_paths: bool = True,
        **pose: Any,
    ) -> None:
        super().__init__(paths, resolve_paths=resolve_paths, **pose)
        for prim in self.prims:
            UsdPhysics.RigidBodyAPI.Apply(prim)
        self._filters = _filters(contact_filter_paths, self.paths)
        if masses is not None:
            self.set_masses(masses)
        if densities is not None:
            self.set_densities(densities)

    def _bodies(self, indices: Any) -> tuple[list[int], list[str]]:
        chosen = numbers(indices, len(self))
        return chosen, [self.paths[one] for one in chosen]

    def get_velocities(self, *, indices: Any = None) -> tuple[Result, Result]:
        chosen, paths = self._bodies(indices)
        if app().timeline.is_stopped():
            unit = np.pi / 180
            bodies = [UsdPhysics.RigidBodyAPI(self.prims[one]) for one in chosen]
            linear = [one.GetVelocityAttr().Get() or (0, 0, 0) for one in bodies]
            angular = [np.array(one.GetAngularVelocityAttr().Get() or (0, 0, 0)) * unit for one in bodies]
            return result(linear), result(angular)
        motion = app().fabric.velocities(paths)
        return result(motion[:, :3] / app().meters_per_unit), result(motion[:, 3:])

    def set_velocities(
        self, linear_velocities: Any = None, angular_velocities: Any = None, *, indices: Any = None
    ) -> None:
        chosen, paths = self._bodies(indices)
        linear = rows(linear_velocities, len(paths), 3, "linear_velocities")
        angular = rows(angular_velocities, len(paths), 3, "angular_velocities")
        if app().timeline.is_stopped():
            for row, one in enumerate(chosen):
                body = UsdPhysics.RigidBodyAPI.Apply(self.prims[one])
                if linear is not None:
                    body.CreateVelocityAttr().Set(tuple(map(float, linear[row])))
                if angular is not None:
                    body.CreateAngularVelocityAttr().Set(tuple(map(float, np.degrees(angular[row]))))
            return
        scaled = None if linear is None else linear * app().meters_per_unit
        app().simulation.tensors.set_velocities(scaled, angular, paths)

    def apply_forces(self, forces: Any, *, indices: Any = None, local_frame: bool = False) -> None:
        self.apply_forces_and_torques_at_pos(forces, indices=indices, local_frame=local_frame)

    def apply_forces_and_torques_at_pos(
        self,
        forces: Any = None,
        torques: Any = None,
        *,
        positions: Any = None,
        indices: Any = None,
        local_frame: bool = False,
    ) -> None:
        _, paths = self._bodies(indices)
        count = len(paths)
        force = rows(forces, count, 3, "forces")
        torque = rows(torques, count, 3, "torques")
        tensors = app().simulation.tensors
        turns = app().fabric.rigid_matrices(paths)[:, :3, :3]
        if local_frame:
            force = None if force is None else _turned(turns, force)
            torque = None if torque is None else _turned(turns, torque)
        if positions is not None and force is not None:
            at = rows(positions, count, 3, "positions")
            places = app().fabric.rigid_matrices(paths)
            world = places[:, :3, 3] + _turned(turns, at) if local_frame else np.asarray(at)
            centres = dict(zip(tensors.body_paths, tensors.centers_of_mass, strict=True))
            arms = world - np.array([centres[path] for path in paths])
            torque = np.cross(arms, force) + (0 if torque is None else torque)
        tensors.set_forces(force, torque, paths)
        ends: list[Any] = []

        def end() -> None:
            ends.pop()()
            if app().physics is not None:
                tensors.set_forces(None, None, paths)

        ends.append(app().on("physics_post_step", end))  # a force acts in one step

    def get_masses(self, *, indices: Any = None, inverse: bool = False) -> Result:
        chosen, paths = self._bodies(indices)
        if app().physics is not None and not app().timeline.is_stopped():
            tensors = app().simulation.tensors
            known = dict(zip(tensors.body_paths, tensors.masses, strict=True))
            found = [known.get(path, 0.0) for path in paths]
        else:
            found = [float(UsdPhysics.MassAPI(self.prims[one]).GetMassAttr().Get() or 0.0) for one in chosen]
        return result([[1 / one if inverse and one else one] for one in found])

    def set_masses(self, masses: Any, *, indices: Any = None) -> None:
        chosen, paths = self._bodies(indices)
        if self._can_change(paths):
            app().simulation.tensors.set_masses(masses=rows(masses, len(chosen), 1, "masses"), bodies=paths)
            return
        self._author(masses, indices, lambda prim: UsdPhysics.MassAPI.Apply(prim).CreateMassAttr())

    def _can_change(self, paths: list[str]) -> bool:
        """Whether these bodies are simulated, and free to take another mass."""
        physics = app().physics
        return physics is not None and all(path in physics.body_paths and physics.is_free(path) for path in paths)

    def set_densities(self, densities: Any, *, indices: Any = None) -> None:
        self._author(densities, indices, lambda prim: UsdPhysics.MassAPI.Apply(prim).CreateDensityAttr())

    def get_densities(self, *, indices: Any = None) -> Result:
        chosen = numbers(indices, len(self))
        return result([[float(UsdPhysics.MassAPI(self.prims[one]).GetDensityAttr().Get() or 0.0)] for one in chosen])

    def get_coms(self, *, indices: Any = None) -> tuple[Result, Result]:
        """Centres of mass in the bodies' axes [stage units], and orientations of the principal axes."""
        chosen, paths = self._bodies(indices)
        found = [UsdPhysics.MassAPI(self.prims[one]) for one in chosen]
        places = [np.array(one.GetCenterOfMassAttr().Get() or (0, 0, 0), float) for one in found]
        turns = [one.GetPrincipalAxesAttr().Get() for one in found]
        axes = [(1.0, 0.0, 0.0, 0.0) if one is None else (one.GetReal(), *one.GetImaginary()) for one in turns]
        if app().physics is not None:
            tensors = app().simulation.tensors
            known = dict(zip(tensors.body_paths, tensors.centers_of_mass, strict=True))
            for row, path in enumerate(paths):
                if path in known:
                    frame = app().fabric.rigid_matrices([path])[0]
                    places[row] = frame[:3, :3].T @ (known[path] / app().meters_per_unit - frame[:3, 3])
        # Without authored axes, PhysX names the body's own.
        return result(places), result([(1.0, 0, 0, 0) if not any(one) else one for one in axes])

    def set_coms(self, positions: Any = None, orientations: Any = None, *, indices: Any = None) -> None:
        """Authored: they act from the next play on."""
        chosen = numbers(indices, len(self))
        places = rows(positions, len(chosen), 3, "positions")
        turns = rows(orientations, len(chosen), 4, "orientations")
        for row, one in enumerate(chosen):
            api = UsdPhysics.MassAPI.Apply(self.prims[one])
            if places is not None:
                api.CreateCenterOfMassAttr().Set(tuple(map(float, places[row])))
            if turns is not None:
                w, *axis = map(float, turns[row])
                api.CreatePrincipalAxesAttr().Set(Gf.Quatf(w, *axis))

    def get_inertias(self, *, indices: Any = None, inverse: bool = False) -> Result:
        """(N, 9) about the centres of mass, along the bodies' axes."""
        _, paths = self._bodies(indices)
        known = {}
        if app().physics is not None:
            tensors = app().simulation.tensors
            known = dict(zip(tensors.body_paths, tensors.inertias, strict=True))
        found = [known.get(path, np.zeros((3, 3))) for path in paths]
        return result([(np.linalg.pinv(one) if inverse else one).reshape(9) for one in found])

    def set_inertias(self, inertias: Any, *, indices: Any = None) -> None:
        """The diagonals of (N, 9), about the principal axes; of jointed bodies they act from the next play on."""
        chosen, paths = self._bodies(indices)
        given = rows(inertias, len(chosen), 9, "inertias")
        if given is not None and self._can_change(paths):
            app().simulation.tensors.set_masses(inertias=given[:, [0, 4, 8]], bodies=paths)
            return
        for row, one in enumerate(chosen):
            if given is not None:
                api = UsdPhysics.MassAPI.Apply(self.prims[one])
                api.CreateDiagonalInertiaAttr().Set(tuple(map(float, given[row][[0, 4, 8]])))

    def get_sleep_thresholds(self, *, indices: Any = None) -> Result:
        chosen = [self.prims[one] for one in numbers(indices, len(self))]
        return result([[attribute_of(prim, "physxRigidBody:sleepThreshold", 0.00005)] for prim in chosen])

    def set_sleep_thresholds(self, thresholds: Any, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        given = rows(thresholds, len(chosen), None, "thresholds")
        for one, value in zip(chosen, () if given is None else given, strict=True):
            attribute(self.prims[one], "physxRigidBody:sleepThreshold", "float", float(value))

    def get_enabled_contact_tracking(self, *, indices: Any = None) -> Result:
        chosen = [self.prims[one] for one in numbers(indices, len(self))]
        return result([["PhysxContactReportAPI" in applied(prim)] for prim in chosen], bool)

    def set_enabled_contact_tracking(self, enabled: Any, *, indices: Any = None, threshold: float = 0.0) -> None:
        chosen = numbers(indices, len(self))
        for one, value in zip(chosen, words(enabled, len(chosen)), strict=True):
            prim = self.prims[one]
            change = prim.AddAppliedSchema if np.all(value) else prim.RemoveAppliedSchema
            change("PhysxContactReportAPI")
            if np.all(value):
                attribute(prim, "physxContactReport:threshold", "float", float(threshold))

    def set_enabled_gravities(self, enabled: Any, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        for one, value in zip(chosen, words(enabled, len(chosen)), strict=True):
            attribute(self.prims[one], "physxRigidBody:disableGravity", "bool", not value)

    def get_enabled_gravities(self, *, indices: Any = None) -> Result:
        found = [self.prims[one].GetAttribute("physxRigidBody:disableGravity") for one in numbers(indices, len(self))]
        return result([[not (one and one.Get())] for one in found], bool)

    def set_enabled_rigid_bodies(self, enabled: Any, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        for one, value in zip(chosen, words(enabled, len(chosen)), strict=True):
            UsdPhysics.RigidBodyAPI.Apply(self.prims[one]).CreateRigidBodyEnabledAttr().Set(bool(value))

    def get_enabled_rigid_bodies(self, *, indices: Any = None) -> Result:
        found = [
            UsdPhysics.RigidBodyAPI(self.prims[one]).GetRigidBodyEnabledAttr() for one in numbers(indices, len(self))
        ]
        return result([[bool(one.Get())] for one in found], bool)

    def get_net_contact_forces(self, *, indices: Any = None, dt: float = 1.0) -> Result:
        from graph.sim.physics.protocol import contact_force

        _, paths = self._bodies(indices)
        physics = app().physics
        return result([np.zeros(3) if physics is None else contact_force(physics, path) for path in paths])

    @property
    def num_contact_filters(self) -> int:
        return len(self._filters[0]) if self._filters else 0

    def get_contact_force_data(self, *, indices: Any = None, dt: float = 1.0) -> tuple[Result, ...]:
        """The contacts of the last step with the filtered prims, all pairs (b bodies, f filters) one after another.

        Forces along the normals (n, 1) times step over dt [N for dt = the step], points (n, 3) [stage units], normals
        (n, 3), separations (n, 1) [stage units], counts and first rows of each pair (b, f).
        """
        chosen, paths = self._bodies(indices)
        found: list[tuple[float, Any, Any, float]] = []
        counts = np.zeros((len(chosen), self.num_contact_filters), np.int32)
        starts = counts.copy()
        unit, physics = app().meters_per_unit, app().physics
        held = None if physics is None else physics.contacts()
        for row, (one, path) in enumerate(zip(chosen, paths, strict=True)):
            for column, other in enumerate(self._filters[one] if self._filters else ()):
                starts[row, column] = len(found)
                found += [] if held is None else _between(held, path, other, unit, dt)
                counts[row, column] = len(found) - starts[row, column]
        forces, points, normals, gaps = zip(*found, strict=True) if found else ((), (), (), ())
        vectors = (np.reshape(one, (-1, 3)) for one in (points, normals))
        flat = (np.reshape(one, (-1, 1)) for one in (forces, gaps))
        (place, normal), (force, gap) = vectors, flat
        numbers_of = (result(one, np.int32) for one in (counts, starts))
        return (*(result(one) for one in (force, place, normal, gap)), *numbers_of)

    def get_contact_force_matrix(self, *, indices: Any = None, dt: float = 1.0) -> Result:
        """(b, f, 3) total force on each body of each filtered prim [N for dt = the step]."""
        chosen, paths = self._bodies(indices)
        out, physics = np.zeros((len(chosen), self.num_contact_filters, 3)), app().physics
        if physics is not None:
            held = physics.contacts()
            for row, (one, path) in enumerate(zip(chosen, paths, strict=True)):
                for column, other in enumerate(self._filters[one] if self._filters else ()):
                    for size, _, normal, _ in _between(held, path, other, 1.0, dt, whole=True):
                        out[row, column] += size * np.asarray(normal)
        return result(out)

    def is_physics_tensor_entity_valid(self) -> bool:
        return app().physics is not None

    def get_default_state(self, *, indices: Any = None) -> tuple[Any, Any, Any, Any]:
        names = ("positions", "orientations", "linear", "angular")
        positions, orientations, linear, angular = (self._defaults.get(name, indices) for name in names)
        return positions, orientations, linear, angular

    def set_default_state(  # type: ignore[override]
        self,
        positions: Any = None,
        orientations: Any = None,
        linear_velocities: Any = None,
        angular_velocities: Any = None,
        *,
        indices: Any = None,
    ) -> None:
        super().set_default_state(positions, orientations, indices=indices)
        self._defaults.set("linear", linear_velocities, 3, indices)
        self._defaults.set("angular", angular_velocities, 3, indices)

    def reset_to_default_state(self, *, warn_on_non_default_state: bool = False) -> None:
        super().reset_to_default_state()
        self._defaults.apply("linear", self.set_velocities)
        self._defaults.apply("angular", lambda spins, indices: self.set_velocities(None, spins, indices=indices))

    def _author(self, values: Any, indices: Any, made: Any) -> None:
        chosen = numbers(indices, len(self))
        given = rows(values, len(chosen), None, "values")
        for one, value in zip(chosen, () if given is None else given, strict=True):
            made(self.prims[one]).Set(float(value))


def _filters(given: Any, paths: list[str]) -> list[list[str]]:
    """For each body the prims whose contacts with it are asked for; expressions count one prim a body."""
    if given is None:
        return []
    listed = [given] if isinstance(given, str) else list(given)
    if listed and not isinstance(listed[0], str):
        return [list(map(str, one)) for one in listed]
    resolved = [found_or_new(one) for one in listed]
    return [[one[row] if len(one) == len(paths) else one[0] for one in resolved] for row in range(len(paths))]


def _between(held: Any, body: str, other: str, unit: float, dt: float, *, whole: bool = False) -> list[Any]:
    """Contacts of a body with a prim or what is below it: force, place, normal towards the body, gap.

    whole: the force's size and direction instead of its part along the normal.
    """
    out = []
    for row, (bodies, pair) in enumerate(zip(held.bodies, held.pairs, strict=True)):
        sides = [{*map(str, one)} for one in zip(bodies, pair, strict=True)]
        for mine, sign in ((0, -1.0), (1, 1.0)):
            theirs = sides[1 - mine]
            if body in sides[mine] and any(one == other or one.startswith(f"{other}/") for one in theirs if one):
                normal, force = sign * held.normals[row], sign * held.forces[row] * held.dt / dt
                size = float(np.linalg.norm(force)) if whole else float(force @ normal)
                away = force / size if whole and size else normal
                out.append((size, held.positions[row] / unit, away, held.distances[row] / unit))
    return out


def _turned(turns: Any, vectors: Any) -> np.ndarray:
    out: np.ndarray = np.einsum("nij,nj->ni", turns, vectors)
    return out
