"""`isaacsim.core.utils.prims`, `.semantics` and `.bounds`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from graph.isaac.outcomes import inert
from graph.isaac.session import app_or_none, kit
from graph.sim.usd import Sdf, Tf, Usd, UsdGeom

from . import prim_utils
from .prim_utils import find_matching_prim_paths as _matching
from .prim_utils import get_labels, get_obb_corners
from .stage import refer, usd_stage
from .xforms import put

__all__ = [
    "add_labels",
    "add_update_semantics",
    "check_incorrect_labels",
    "check_missing_labels",
    "compute_aabb",
    "compute_combined_aabb",
    "compute_obb",
    "compute_obb_corners",
    "count_labels_in_scene",
    "create_bbox_cache",
    "create_prim",
    "define_prim",
    "delete_prim",
    "find_matching_prim_paths",
    "get_all_matching_child_prims",
    "get_articulation_root_api_prim_path",
    "get_first_matching_child_prim",
    "get_first_matching_parent_prim",
    "get_labels",
    "get_obb_corners",
    "get_prim_at_path",
    "get_prim_attribute_names",
    "get_prim_attribute_value",
    "get_prim_children",
    "get_prim_object_type",
    "get_prim_parent",
    "get_prim_path",
    "get_prim_property",
    "get_prim_type_name",
    "get_semantics",
    "is_prim_ancestral",
    "is_prim_hidden_in_stage",
    "is_prim_no_delete",
    "is_prim_non_root_articulation_link",
    "is_prim_path_valid",
    "is_prim_root_path",
    "move_prim",
    "query_parent_path",
    "recompute_extents",
    "remove_all_semantics",
    "remove_labels",
    "set_prim_attribute_value",
    "set_prim_hide_in_stage_window",
    "set_prim_no_delete",
    "set_prim_property",
    "set_prim_visibility",
    "set_targets",
    "upgrade_prim_semantics_to_labels",
]


def get_prim_attribute_names(prim_path: str, fabric: bool = False) -> list[str]:
    return prim_utils.get_prim_attribute_names(prim_path)


def get_prim_attribute_value(prim_path: str, attribute_name: str, fabric: bool = False) -> Any:
    return prim_utils.get_prim_attribute_value(prim_path, attribute_name)


def is_prim_non_root_articulation_link(prim_path: str) -> bool:
    return prim_utils.is_prim_non_root_articulation_link(prim_path)


def compute_aabb(bbox_cache: Any, prim_path: str, include_children: bool = False) -> np.ndarray:
    return prim_utils.compute_aabb(prim_path, bbox_cache=bbox_cache, include_children=include_children)


def compute_combined_aabb(bbox_cache: Any, prim_paths: list[str]) -> np.ndarray:
    return prim_utils.compute_combined_aabb(prim_paths, bbox_cache=bbox_cache)


def compute_obb(bbox_cache: Any, prim_path: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centre, axes as long as the prim's scales, and half extents before scaling."""
    centre, axes, _ = prim_utils.compute_obb(prim_path, bbox_cache=bbox_cache)
    box = bbox_cache.ComputeWorldBound(get_prim_at_path(prim_path))
    scales = np.linalg.norm(np.array(box.GetMatrix())[:3, :3], axis=1)
    return centre, axes * scales[:, None], np.array(box.GetRange().GetSize()) / 2


def compute_obb_corners(bbox_cache: Any, prim_path: str) -> np.ndarray:
    return prim_utils.get_obb_corners(*compute_obb(bbox_cache, prim_path))


def add_labels(prim: Any, labels: list[str], instance_name: str = "class", overwrite: bool = True) -> None:
    if overwrite and prim.HasAttribute(f"semantics:labels:{instance_name}"):
        prim.GetAttribute(f"semantics:labels:{instance_name}").Set([])
    prim_utils.add_labels(prim, labels=labels, taxonomy=instance_name)


def remove_labels(prim: Any, instance_name: str | None = None, include_descendants: bool = False) -> None:
    for one in Usd.PrimRange(prim) if include_descendants else [prim]:
        for name in [each.GetName() for each in one.GetAttributes()]:
            taxonomy = name.removeprefix("semantics:labels:")
            if taxonomy != name and instance_name in (None, taxonomy):
                one.RemoveAppliedSchema(f"SemanticsLabelsAPI:{taxonomy}")
                one.RemoveProperty(name)


def upgrade_prim_semantics_to_labels(prim: Any, include_descendants: bool = False) -> int:
    return len(prim_utils.upgrade_prim_semantics_to_labels(prim, include_descendants=include_descendants))


def _labelled(prim_path: str | None) -> list[tuple[Any, list[str]]]:
    """The geometry at and below a path, each with all its labels."""
    root = usd_stage().GetPrimAtPath(prim_path) if prim_path else usd_stage().GetPseudoRoot()
    shown = (one for one in Usd.PrimRange(root) if one.IsA(UsdGeom.Gprim))
    return [(one, [label for held in get_labels(one).values() for label in held]) for one in shown]


def check_missing_labels(prim_path: str | None = None) -> list[str]:
    return [str(one.GetPath()) for one, labels in _labelled(prim_path) if not labels]


def check_incorrect_labels(prim_path: str | None = None, validate_against_prim_path: bool = False) -> list[list[str]]:
    """Geometry with an empty first label; or, validated against paths, whose path holds none of its labels.

    Each with its first label.
    """

    def is_wrong(path: str, labels: list[str]) -> bool:
        return validate_against_prim_path and not any(label.lower() in path.lower() for label in labels)

    named = [(str(one.GetPath()), labels) for one, labels in _labelled(prim_path) if labels]
    return [[path, labels[0]] for path, labels in named if not labels[0] or is_wrong(path, labels)]


def count_labels_in_scene(prim_path: str | None = None) -> dict[str, int]:
    found = [labels for _, labels in _labelled(prim_path)]
    counts = Counter(label for labels in found for label in labels)
    return {"missing_labels": sum(not labels for labels in found), **counts}


def get_prim_at_path(prim_path: Any, fabric: bool = False) -> Any:
    return usd_stage().GetPrimAtPath(str(prim_path))


def is_prim_path_valid(prim_path: Any, fabric: bool = False) -> bool:
    path = str(prim_path)
    if app_or_none() is None or kit().stage_closed or not Sdf.Path.IsValidPathString(path):
        return False
    return path.startswith("/") and bool(usd_stage().GetPrimAtPath(path))


def get_prim_path(prim: Any) -> str:
    return str(prim.GetPath())


def define_prim(prim_path: str, prim_type: str = "Xform", fabric: bool = False) -> Any:
    if is_prim_path_valid(prim_path):
        raise ValueError(f"A prim already exists at prim path: {prim_path}")
    return usd_stage().DefinePrim(prim_path, prim_type)


def create_prim(
    prim_path: str,
    prim_type: str = "Xform",
    position: Any = None,
    translation: Any = None,
    orientation: Any = None,
    scale: Any = None,
    usd_path: str | None = None,
    semantic_label: str | None = None,
    semantic_type: str = "class",
    attributes: Mapping[str, Any] | None = None,
) -> Any:
    if is_prim_path_valid(prim_path):
        raise ValueError(f"A prim already exists at prim path: {prim_path}")
    prim = usd_stage().DefinePrim(prim_path, prim_type)
    for name, value in (attributes or {}).items():
        _set(prim, name, value)
    if usd_path is not None:
        refer(prim, usd_path)
    if semantic_label is not None:
        add_labels(prim, [semantic_label], semantic_type)
    if UsdGeom.Xformable(prim):
        put(prim, position=position, translation=translation, orientation=orientation, scale=scale)
    return prim


def delete_prim(prim_path: str) -> None:
    usd_stage().RemovePrim(prim_path)


def move_prim(path_from: str, path_to: str) -> None:
    from .stage import move_prim as moved

    moved(path_from, path_to)


def set_targets(prim: Any, attribute: str, target_prim_paths: Sequence[Any]) -> None:
    relationship = prim.GetRelationship(attribute) or prim.CreateRelationship(attribute)
    relationship.SetTargets([Sdf.Path(str(path)) for path in target_prim_paths])


def _set(prim: Any, name: str, value: Any) -> None:
    from graph.sim.scene.prim_attributes import set_property

    attribute = prim.GetAttribute(name)
    if attribute:
        try:
            attribute.Set(value)
            return
        except (Tf.ErrorException, TypeError, OverflowError):  # of another type: converted below
            pass
    set_property(prim, name, np.asarray(value).tolist() if isinstance(value, np.ndarray) else value)


def set_prim_property(prim_path: str, property_name: str, property_value: Any) -> None:
    _set(get_prim_at_path(prim_path), property_name, property_value)


def get_prim_property(prim_path: str, property_name: str) -> Any:
    attribute = get_prim_at_path(prim_path).GetAttribute(property_name)
    return attribute.Get() if attribute else None


def set_prim_attribute_value(prim_path: Any, attribute_name: str, value: Any, fabric: bool = False) -> None:
    _set(get_prim_at_path(getattr(prim_path, "GetPath", lambda: prim_path)()), attribute_name, value)


def get_prim_children(prim: Any) -> list[Any]:
    return list(prim.GetChildren())


def get_prim_parent(prim: Any) -> Any:
    return prim.GetParent()


def get_prim_type_name(prim_path: Any, fabric: bool = False) -> str:
    prim = get_prim_at_path(prim_path) if isinstance(prim_path, str) else prim_path
    return str(prim.GetTypeName())


def get_prim_object_type(prim_path: str) -> str | None:
    prim = get_prim_at_path(prim_path)
    applied = prim.GetAppliedSchemas()
    if "PhysicsArticulationRootAPI" in applied:
        return "articulation"
    return "rigid_body" if "PhysicsRigidBodyAPI" in applied else "xform" if UsdGeom.Xformable(prim) else None


def get_all_matching_child_prims(
    prim_path: str, predicate: Callable[[str], bool] = lambda path: True, depth: int | None = None
) -> list[Any]:
    return prim_utils.get_all_matching_child_prims(
        prim_path, predicate=lambda prim, path: predicate(path), include_self=True, max_depth=depth
    )


def get_first_matching_child_prim(prim_path: str, predicate: Callable[[str], bool], fabric: bool = False) -> Any:
    return prim_utils.get_first_matching_child_prim(
        prim_path, predicate=lambda prim, path: predicate(path), include_self=True
    )


def get_first_matching_parent_prim(prim_path: str, predicate: Callable[[str], bool]) -> Any:
    return prim_utils.get_first_matching_parent_prim(
        prim_path, predicate=lambda prim, path: predicate(path), include_self=True
    )


def find_matching_prim_paths(prim_path_regex: str, prim_type: str | None = None) -> list[str]:
    found = _matching(prim_path_regex)
    return [path for path in found if prim_type is None or get_prim_object_type(path) == prim_type]


def get_articulation_root_api_prim_path(prim_path: str) -> str:
    from .articulation import Articulation

    found = Articulation.fetch_articulation_root_api_prim_paths(prim_path)[0]
    return found or prim_path


def is_prim_ancestral(prim_path: str) -> bool:
    from .usd import check_ancestral

    return check_ancestral(get_prim_at_path(prim_path))


def is_prim_root_path(prim_path: str) -> bool:
    return prim_path == "/"


def is_prim_no_delete(prim_path: str) -> bool:
    return bool(get_prim_at_path(prim_path).GetMetadata("no_delete"))


def is_prim_hidden_in_stage(prim_path: str) -> bool:
    return bool(get_prim_at_path(prim_path).GetMetadata("hide_in_stage_window"))


@inert("isaacsim.core.utils.prims")
def set_prim_no_delete(prim: Any, no_delete: bool) -> None:
    return None


@inert("isaacsim.core.utils.prims")
def set_prim_hide_in_stage_window(prim: Any, hide: bool) -> None: ...


def set_prim_visibility(prim: Any, visible: bool) -> None:
    imageable = UsdGeom.Imageable(prim.GetPrim())
    (imageable.MakeVisible if visible else imageable.MakeInvisible)()


def query_parent_path(prim_path: str, predicate: Callable[[str], bool]) -> bool:
    path = prim_path
    while path not in ("", "/"):
        if predicate(path):
            return True
        path = path.rpartition("/")[0]
    return False


def create_bbox_cache(time: Any = None, use_extents_hint: bool = True) -> Any:
    return prim_utils.create_bbox_cache(time, use_extents_hint=use_extents_hint)


def recompute_extents(prim: Any, time: Any = None, include_children: bool = False) -> None:
    root = prim.GetPrim()
    for one in Usd.PrimRange(root) if include_children else [root]:
        boundable = UsdGeom.Boundable(one)
        if boundable:
            boundable.CreateExtentAttr().Set(UsdGeom.Boundable.ComputeExtentFromPlugins(boundable, 0))


def add_update_semantics(prim: Any, semantic_label: str, type_label: str = "class", suffix: str = "") -> None:
    add_labels(prim, [semantic_label], type_label)


def get_semantics(prim: Any) -> dict[str, tuple[str, str]]:
    return {f"{name}_{one}": (name, one) for name, held in get_labels(prim).items() for one in held}


def remove_all_semantics(prim: Any, recursive: bool = False) -> None:
    remove_labels(prim, include_descendants=recursive)
