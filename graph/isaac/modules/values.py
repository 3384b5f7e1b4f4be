"""`isaacsim.core.utils.types`, `.string`, `.carb` and `isaacsim.core.utils.nucleus`-like small things."""

from __future__ import annotations

from typing import Any

from .carb_settings import get_settings

__all__ = [
    "ArticulationAction",
    "ArticulationActions",
    "DOFInfo",
    "DataFrame",
    "DynamicState",
    "DynamicsViewState",
    "JointsState",
    "XFormPrimState",
    "XFormPrimViewState",
    "find_root_prim_path_from_regex",
    "find_unique_string_name",
    "get_carb_setting",
    "set_carb_setting",
]


class _Fields:
    _names: tuple[str, ...] = ()

    def __init__(self, *values: Any, **named: Any) -> None:
        for name in self._names:
            setattr(self, name, None)
        for name, value in (*zip(self._names, values, strict=False), *named.items()):
            setattr(self, name, value)

    def get_dict(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in self._names}

    get_dof_action = get_dict

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.get_dict()})"


class ArticulationAction(_Fields):
    _names = ("joint_positions", "joint_velocities", "joint_efforts", "joint_indices")

    def get_length(self) -> int | None:
        values = (getattr(self, name) for name in self._names[:3])
        return next((len(value) for value in values if value is not None), None)

    def get_dof_action(self, index: int) -> dict[str, Any]:  # type: ignore[override]
        return {
            name[6:-1]: None if (values := getattr(self, name)) is None else values[index] for name in self._names[:3]
        }


class ArticulationActions(_Fields):
    _names = ("joint_positions", "joint_velocities", "joint_efforts", "joint_indices", "joint_names")


class JointsState(_Fields):
    _names = ("positions", "velocities", "efforts")


class XFormPrimState(_Fields):
    _names = ("position", "orientation")


class XFormPrimViewState(_Fields):
    _names = ("positions", "orientations")


class DynamicState(_Fields):
    _names = ("position", "orientation", "linear_velocity", "angular_velocity")


class DynamicsViewState(_Fields):
    _names = ("positions", "orientations", "linear_velocities", "angular_velocities")


class DOFInfo(_Fields):
    _names = ("prim_path", "handle", "prim", "index")


class DataFrame(_Fields):
    _names = ("current_time_step", "current_time", "data")


def find_unique_string_name(initial_name: str, is_unique_fn: Any) -> str:
    name, number = initial_name, 1
    while not is_unique_fn(name):
        name, number = f"{initial_name}_{number}", number + 1
    return name


def find_root_prim_path_from_regex(prim_path_regex: str) -> tuple[str, int]:
    """The path above the first expression and that one's depth; a path without expressions and its own depth."""
    parts = prim_path_regex.split("/")
    plain = 0
    while plain < len(parts) and not any(letter in parts[plain] for letter in ".*[](|)+?"):
        plain += 1
    return "/".join(parts[:plain]) or "/", plain if plain < len(parts) else plain - 1


def set_carb_setting(carb_settings: Any, setting: str, value: Any) -> None:
    (carb_settings or get_settings()).set(setting, value)


def get_carb_setting(carb_settings: Any, setting: str) -> Any:
    return (carb_settings or get_settings()).get(setting)
