"""`Articulation` of `isaacsim.core.experimental.prims`: joints of one robot or several alike."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from graph.base.errors import RunError
from graph.isaac.results import Result, numbers, result, rows, words
from graph.isaac.session import app
from graph.sim.scene.assets import missing_above
from graph.sim.scene.mechanisms import freedoms, mechanisms_of
from graph.sim.transforms import rotation_matrices
from graph.sim.usd import UsdPhysics

from .articulation_properties import Properties, at_once
from .prim_base import attribute
from .xform_prim import XformPrim
from .xforms import world_parts

__all__ = ["Articulation"]


class Articulation(Properties, XformPrim):
    def __init__(self, paths: Any, *, resolve_paths: bool = True, **pose: Any) -> None:
        super().__init__(paths, resolve_paths=resolve_paths, **pose)
        self._gains: np.ndarray | None = None
        """Stiffnesses and dampings before the first `switch_dof_control_mode`."""

    @staticmethod
    def fetch_articulation_root_api_prim_paths(paths: Any) -> list[str | None]:
        from graph.sim.usd import Usd

        from .prim_utils import usd_prim

        out: list[str | None] = []
        for path in [paths] if isinstance(paths, str) else paths:
            prims = Usd.PrimRange(usd_prim(path))
            out.append(next((str(one.GetPath()) for one in prims if one.HasAPI(UsdPhysics.ArticulationRootAPI)), None))
        return out

    # -- joints, playing or not ----------------------------------------------------------------------------------------

    def _live(self, one: int = 0) -> Any:
        physics = app().physics
        return None if physics is None else physics.articulation(self.paths[one])

    def _joints(self, one: int = 0) -> list[Any]:
        """The prims of the joints with one degree of freedom."""
        stage = app().stage
        found = self._live(one)
        if found is not None:
            return [stage.GetPrimAtPath(path.partition(":")[0]) for path in found.joint_paths]
        return [stage.GetPrimAtPath(path) for path in freedoms(stage, self.paths[one])]

    @property
    def dof_paths(self) -> list[list[str]]:
        return [[str(prim.GetPath()) for prim in self._joints(one)] for one in range(len(self))]

    @property
    def dof_names(self) -> list[str]:
        found = self._live()
        return list(found.joint_names) if found is not None else [prim.GetName() for prim in self._joints()]

    joint_names = dof_names

    @property
    def num_dofs(self) -> int:
        return len(self.dof_names)

    num_joints = num_dof = num_dofs

    @property
    def dof_types(self) -> list[str]:
        return ["translation" if prim.IsA(UsdPhysics.PrismaticJoint) else "rotation" for prim in self._joints()]

    @property
    def link_names(self) -> list[str]:
        return [path.rpartition("/")[2] for path in self.link_paths[0]]

    @property
    def link_paths(self) -> list[list[str]]:
        """The base first, then what hangs on it, nearest first."""
        mechanisms = mechanisms_of(app().stage)
        return [_from_the_base(path, mechanisms.carriers(path)) for path in self.paths]

    @property
    def num_links(self) -> int:
        return len(self.link_paths[0])

    def get_link_indices(self, names: Any) -> Result:
        known = self.link_names
        return result([known.index(one) for one in ([names] if isinstance(names, str) else names)], np.int32)

    def get_dof_indices(self, names: Any) -> Result:
        found = self._live()
        known = found.numbers if found is not None else {name: row for row, name in enumerate(self.dof_names)}
        listed = [names] if isinstance(names, str) else list(names)
        for name in listed:
            if name not in known:
                lack = missing_above(app().stage, self.paths[0])
                why = f": {lack}" if lack and not known else f"; it has {', '.join(known) or 'none'}"
                raise ValueError(f"{self.paths[0]} has no joint {name!r}{why}")
        return result([known[name] for name in listed], np.int32)

    get_joint_indices = get_dof_indices

    def is_physics_tensor_entity_valid(self) -> bool:
        return app().physics is not None

    def get_world_poses(self, *, indices: Any = None) -> tuple[Result, Result]:
        """Of the base link while physics moves it, which the wrapped prim does not follow; else of the prim."""
        chosen = numbers(indices, len(self))
        links = self.link_paths if any(self._live(one) is not None for one in chosen) else []
        found = [world_parts(links[one][0] if links and links[one] else self.paths[one]) for one in chosen]
        return result([one for one, _ in found]), result([one for _, one in found])

    def set_world_poses(self, positions: Any = None, orientations: Any = None, *, indices: Any = None) -> None:
        """While physics plays, a robot whose base is free moves with its root link, its joints as they are."""
        world, chosen = app(), numbers(indices, len(self))
        places = rows(positions, len(chosen), 3, "positions")
        turns = rows(orientations, len(chosen), 4, "orientations")
        for row, one in enumerate(chosen):
            place, turn = (None if each is None else each[row] for each in (places, turns))
            links = mechanisms_of(world.stage).carriers(self.paths[one])
            base = next(filter(_is_free, links), None)
            if base is None:
                super().set_world_poses(place, turn, indices=[one])
                continue
            root, now = world.fabric.rigid_matrices((next(iter(links)), base))
            wanted = root.copy()
            if place is not None:
                wanted[:3, 3] = place * world.meters_per_unit
            if turn is not None:
                wanted[:3, :3] = rotation_matrices((turn / np.linalg.norm(turn))[None])[0]
            pose = wanted @ np.linalg.inv(root) @ now
            pose[:3, 3] /= world.meters_per_unit
            world.fabric.place_body(base, pose)

    # -- states --------------------------------------------------------------------------------------------------------

    def _read(self, what: str, indices: Any, dofs: Any) -> Result:
        out = []
        for one in numbers(indices, len(self)):
            found = self._live(one)
            values = np.zeros(self.num_dofs) if found is None else getattr(found, what)
            if found is None:
                values = np.array([_stated(prim, what) for prim in self._joints(one)])
            out.append(values[numbers(dofs, len(values))])
        return result(out)

    def get_dof_positions(self, *, indices: Any = None, dof_indices: Any = None) -> Result:
        return self._read("positions", indices, dof_indices)

    def get_dof_velocities(self, *, indices: Any = None, dof_indices: Any = None) -> Result:
        return self._read("velocities", indices, dof_indices)

    def get_dof_projected_joint_forces(self, *, indices: Any = None, dof_indices: Any = None) -> Result:
        return self._read("efforts", indices, dof_indices)

    def get_dof_efforts(self, *, indices: Any = None, dof_indices: Any = None) -> Result:
        return self._commanded("efforts", indices, dof_indices)

    def get_dof_position_targets(self, *, indices: Any = None, dof_indices: Any = None) -> Result:
        return self._commanded("positions", indices, dof_indices, "targetPosition")

    def get_dof_velocity_targets(self, *, indices: Any = None, dof_indices: Any = None) -> Result:
        return self._commanded("velocities", indices, dof_indices, "targetVelocity")

    def _commanded(self, name: str, indices: Any, dofs: Any, authored: str = "") -> Result:
        out = []
        for one in numbers(indices, len(self)):
            found = self._live(one)
            if found is not None:
                values = found.commanded(name)
            else:
                values = np.array([_drive(prim, authored) if authored else 0.0 for prim in self._joints(one)])
            out.append(values[numbers(dofs, len(values))])
        return result(out)

    def _command(self, name: str, values: Any, indices: Any, dofs: Any) -> None:
        chosen = numbers(indices, len(self))
        joints = numbers(dofs, self.num_dofs)
        given = rows(values, len(chosen), len(joints), name)
        if given is None:
            return
        for row, one in enumerate(chosen):
            found = self._live(one)
            if found is not None:
                found.set_targets(**{name: given[row]}, joints=joints)
            elif name != "efforts":
                for number, value in zip(joints, given[row], strict=True):
                    _author_drive(
                        self._joints(one)[number], f"target{'Position' if name == 'positions' else 'Velocity'}", value
                    )

    def set_dof_position_targets(self, positions: Any, *, indices: Any = None, dof_indices: Any = None) -> None:
        self._command("positions", positions, indices, dof_indices)

    def set_dof_velocity_targets(self, velocities: Any, *, indices: Any = None, dof_indices: Any = None) -> None:
        self._command("velocities", velocities, indices, dof_indices)

    def set_dof_efforts(self, efforts: Any, *, indices: Any = None, dof_indices: Any = None) -> None:
        self._command("efforts", efforts, indices, dof_indices)

    def set_dof_positions(self, positions: Any, *, indices: Any = None, dof_indices: Any = None) -> None:
        self._place("set_positions", positions, indices, dof_indices)
        self._command("positions", positions, indices, dof_indices)  # or a drive pulls the joints back

    def set_dof_velocities(self, velocities: Any, *, indices: Any = None, dof_indices: Any = None) -> None:
        self._place("set_velocities", velocities, indices, dof_indices)
        self._command("velocities", velocities, indices, dof_indices)

    def _place(self, call: str, values: Any, indices: Any, dofs: Any) -> None:
        chosen = numbers(indices, len(self))
        joints = numbers(dofs, self.num_dofs)
        given = rows(values, len(chosen), len(joints), "values")
        for row, one in enumerate(chosen):
            found = self._live(one)
            if found is None:
                raise RunError(f"{self.paths[one]}: joints can be placed only while the timeline plays; play first")
            getattr(found, call)(() if given is None else given[row], joints)
            app().fabric.touched()

    # -- properties ----------------------------------------------------------------------------------------------------

    def get_dof_limits(self, *, indices: Any = None, dof_indices: Any = None) -> tuple[Result, Result]:
        out = []
        for one in numbers(indices, len(self)):
            found = self._live(one)
            limits = np.array([_limits(prim) for prim in self._joints(one)]) if found is None else found.limits
            out.append(limits.reshape(-1, 2)[numbers(dof_indices, len(limits))])
        both = np.array(out)
        return result(both[..., 0]), result(both[..., 1])

    @at_once
    def set_dof_limits(
        self, lower: Any = None, upper: Any = None, *, indices: Any = None, dof_indices: Any = None
    ) -> None:
        for name, values in (("physics:lowerLimit", lower), ("physics:upperLimit", upper)):
            for prim, value in self._each(values, indices, dof_indices):
                prim.GetAttribute(name).Set(float(value if prim.IsA(UsdPhysics.PrismaticJoint) else np.degrees(value)))

    def get_dof_gains(self, *, indices: Any = None, dof_indices: Any = None) -> tuple[Result, Result]:
        found = [self._joints(one) for one in numbers(indices, len(self))]
        chosen = [[joints[number] for number in numbers(dof_indices, len(joints))] for joints in found]
        return tuple(  # type: ignore[return-value]
            result([[_gain(prim, name) for prim in joints] for joints in chosen]) for name in ("stiffness", "damping")
        )

    @at_once
    def set_dof_gains(
        self,
        stiffnesses: Any = None,
        dampings: Any = None,
        *,
        indices: Any = None,
        dof_indices: Any = None,
        update_default_gains: bool = True,
    ) -> None:
        for name, values in (("stiffness", stiffnesses), ("damping", dampings)):
            for prim, value in self._each(values, indices, dof_indices):
                angular = not prim.IsA(UsdPhysics.PrismaticJoint)
                _author_drive(prim, name, float(value) * (np.pi / 180 if angular else 1.0), turned=False)

    def switch_dof_control_mode(self, mode: str, *, indices: Any = None, dof_indices: Any = None) -> None:
        stiffness, damping = self.get_dof_gains(indices=indices, dof_indices=dof_indices)
        if self._gains is None:
            self._gains = np.stack([stiffness, damping])
        kept = self._gains
        zero = np.zeros_like(kept[0])
        gains = {"position": (kept[0], kept[1]), "velocity": (zero, kept[1]), "effort": (zero, zero)}[mode]
        self.set_dof_gains(*gains, indices=indices, dof_indices=dof_indices)

    def get_dof_max_efforts(self, *, indices: Any = None, dof_indices: Any = None) -> Result:
        found = [self._joints(one) for one in numbers(indices, len(self))]
        return result(
            [[_drive(joints[n], "maxForce", np.inf) for n in numbers(dof_indices, len(joints))] for joints in found]
        )

    @at_once
    def set_dof_max_efforts(self, max_efforts: Any, *, indices: Any = None, dof_indices: Any = None) -> None:
        for prim, value in self._each(max_efforts, indices, dof_indices):
            _author_drive(prim, "maxForce", value, turned=False)

    def get_dof_drive_types(self, *, indices: Any = None, dof_indices: Any = None) -> list[list[str]]:
        found = [self._joints(one) for one in numbers(indices, len(self))]
        return [[str(_api(prim).GetTypeAttr().Get() or "force") for prim in joints] for joints in found]

    @at_once
    def set_dof_drive_types(self, types: Any, *, indices: Any = None, dof_indices: Any = None) -> None:
        for one in numbers(indices, len(self)):
            joints = self._joints(one)
            chosen = numbers(dof_indices, len(joints))
            for number, kind in zip(chosen, words(types, len(chosen)), strict=True):
                if kind not in ("force", "acceleration"):
                    raise ValueError(f'the type of a drive is "force" or "acceleration", not {kind!r}')
                _api(joints[number]).CreateTypeAttr().Set(kind)

    def _each(self, values: Any, indices: Any, dofs: Any) -> list[tuple[Any, Any]]:
        chosen = numbers(indices, len(self))
        out: list[tuple[Any, Any]] = []
        for row, one in enumerate(chosen):
            joints = self._joints(one)
            numbered = numbers(dofs, len(joints))
            given = rows(values, len(chosen), len(numbered), "values")
            if given is not None:
                out += [(joints[number], value) for number, value in zip(numbered, given[row], strict=True)]
        return out

    # -- the root ------------------------------------------------------------------------------------------------------

    def get_velocities(self, *, indices: Any = None) -> tuple[Result, Result]:
        motion = app().fabric.velocities([self._root(one) for one in numbers(indices, len(self))])
        return result(motion[:, :3] / app().meters_per_unit), result(motion[:, 3:])

    def set_velocities(
        self, linear_velocities: Any = None, angular_velocities: Any = None, *, indices: Any = None
    ) -> None:
        paths = [self._root(one) for one in numbers(indices, len(self))]
        linear = rows(linear_velocities, len(paths), 3, "linear_velocities")
        angular = rows(angular_velocities, len(paths), 3, "angular_velocities")
        scaled = None if linear is None else linear * app().meters_per_unit
        app().simulation.tensors.set_velocities(scaled, angular, paths)

    def _root(self, one: int) -> str:
        path = self.paths[one]
        return next(iter(mechanisms_of(app().stage).carriers(path)), path)

    def get_enabled_self_collisions(self, *, indices: Any = None) -> Result:
        name = "physxArticulation:enabledSelfCollisions"
        found = [self.prims[one].GetAttribute(name) for one in numbers(indices, len(self))]
        return result([[bool(one and one.Get())] for one in found], bool)

    def set_enabled_self_collisions(self, enabled: Any, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        for one, value in zip(chosen, words(enabled, len(chosen)), strict=True):
            attribute(self.prims[one], "physxArticulation:enabledSelfCollisions", "bool", bool(value))

    def get_default_state(self, *, indices: Any = None, dof_indices: Any = None) -> tuple[Any, ...]:
        names = ("positions", "orientations", "linear", "angular", "dof_positions", "dof_velocities", "dof_efforts")
        return tuple(self._defaults.get(name, indices) for name in names)

    def set_default_state(  # type: ignore[override]
        self,
        positions: Any = None,
        orientations: Any = None,
        linear_velocities: Any = None,
        angular_velocities: Any = None,
        dof_positions: Any = None,
        dof_velocities: Any = None,
        dof_efforts: Any = None,
        *_: Any,
        indices: Any = None,
        dof_indices: Any = None,
    ) -> None:
        super().set_default_state(positions, orientations, indices=indices)
        count = self.num_dofs
        given = {
            "linear": (linear_velocities, 3),
            "angular": (angular_velocities, 3),
            "dof_positions": (dof_positions, count),
            "dof_velocities": (dof_velocities, count),
            "dof_efforts": (dof_efforts, count),
        }
        for name, (values, width) in given.items():
            self._defaults.set(name, values, width, indices)

    def reset_to_default_state(self, *, warn_on_non_default_state: bool = False) -> None:
        super().reset_to_default_state()
        self._defaults.apply("dof_positions", self.set_dof_positions)
        self._defaults.apply("dof_positions", self.set_dof_position_targets)
        self._defaults.apply("dof_velocities", self.set_dof_velocities)


def _from_the_base(root: str, links: Iterable[str]) -> list[str]:
    held = sorted(links)
    below: dict[str, list[str]] = {}
    for prim in app().stage.Traverse():
        joint = UsdPhysics.Joint(prim)
        if joint:
            ends = (joint.GetBody0Rel().GetTargets(), joint.GetBody1Rel().GetTargets())
            first, second = (str(one[0]) if one else "" for one in ends)
            if second in held:
                below.setdefault(first if first in held else "", []).append(second)
    children = {one for key, listed in below.items() if key for one in listed}
    bases = [root] if root in held else [one for one in below.get("", []) if one not in children]
    ordered = list(dict.fromkeys([*bases, *(one for one in held if one not in children)]))
    for one in ordered:  # grows while it is walked
        ordered += [child for child in below.get(one, []) if child not in ordered]
    return [*ordered, *(one for one in held if one not in ordered)]


def _api(prim: Any) -> Any:
    return UsdPhysics.DriveAPI(prim, "linear" if prim.IsA(UsdPhysics.PrismaticJoint) else "angular")


def _drive(prim: Any, name: str, default: float = 0.0) -> float:
    """An attribute of a joint's drive in SI units; angles in radians."""
    attribute = getattr(_api(prim), f"Get{name[0].upper()}{name[1:]}Attr")()
    value = attribute.Get() if attribute else None
    if value is None:
        return default
    turned = not prim.IsA(UsdPhysics.PrismaticJoint) and name.startswith("target")
    return float(np.radians(value)) if turned else float(value)


def _gain(prim: Any, name: str) -> float:
    value = _drive(prim, name)
    return value if prim.IsA(UsdPhysics.PrismaticJoint) else value * 180 / np.pi


def _author_drive(prim: Any, name: str, value: Any, *, turned: bool = True) -> None:
    kind = "linear" if prim.IsA(UsdPhysics.PrismaticJoint) else "angular"
    api = UsdPhysics.DriveAPI.Apply(prim, kind)
    number = float(np.degrees(value)) if turned and kind == "angular" else float(value)
    getattr(api, f"Create{name[0].upper()}{name[1:]}Attr")().Set(number)


def _stated(prim: Any, what: str) -> float:
    """The position or velocity that a joint's state authors; 0 without."""
    kind = "linear" if prim.IsA(UsdPhysics.PrismaticJoint) else "angular"
    name = {"positions": "position", "velocities": "velocity"}.get(what)
    attribute = prim.GetAttribute(f"state:{kind}:physics:{name}") if name else None
    value = float(attribute.Get() or 0.0) if attribute else 0.0
    return value if kind == "linear" else float(np.radians(value))


def _limits(prim: Any) -> tuple[float, float]:
    scale = 1.0 if prim.IsA(UsdPhysics.PrismaticJoint) else np.pi / 180
    values = [prim.GetAttribute(f"physics:{name}Limit").Get() for name in ("lower", "upper")]
    low, high = (-np.inf if values[0] is None else values[0]), (np.inf if values[1] is None else values[1])
    return float(low) * scale, float(high) * scale


def _is_free(path: str) -> bool:
    """Whether physics moves a link that no joint holds."""
    physics = app().physics
    return physics is not None and path in physics.body_paths and physics.is_free(path)
