"""`isaacsim.core.experimental.utils.prim`, `.semantics` and `.bounds`."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from graph.sim.usd import Sdf, Usd, UsdGeom

from .stage import asks_fabric, offered, usd_stage

__all__ = [
    "add_labels",
    "compute_aabb",
    "compute_combined_aabb",
    "compute_obb",
    "compute_obb_corners",
    "create_bbox_cache",
    "create_prim_attribute",
    "ensure_api",
    "find_matching_prim_paths",
    "get_all_matching_child_prims",
    "get_first_matching_child_prim",
    "get_first_matching_parent_prim",
    "get_labels",
    "get_obb_corners",
    "get_prim_at_path",
    "get_prim_attribute_names",
    "get_prim_attribute_value",
    "get_prim_path",
    "get_prim_variant_collection",
    "get_prim_variants",
    "has_api",
    "is_prim_non_root_articulation_link",
    "remove_all_labels",
    "remove_labels",
    "set_prim_attribute_value",
    "set_prim_variants",
    "upgrade_prim_semantics_to_labels",
]


def usd_prim(path: Any) -> Any:
    """The prim of USD at a path, or of an object with a path."""
    return path if isinstance(path, Usd.Prim) else usd_stage().GetPrimAtPath(get_prim_path(path))


def get_prim_at_path(path: Any) -> Any:
    return offered(usd_prim(path))


def get_prim_path(prim: Any) -> str:
    return str(prim.GetPath()) if hasattr(prim, "GetPath") else str(prim)


def find_matching_prim_paths(path: str, *, traverse: bool = False) -> list[str]:
    if traverse:
        pattern = re.compile(path)
        return [str(one.GetPath()) for one in usd_stage().Traverse() if pattern.match(str(one.GetPath()))]
    found = [usd_stage().GetPseudoRoot()]
    for part in path.strip("/").split("/"):
        pattern = re.compile(f"^{part}$")
        found = [child for prim in found for child in prim.GetAllChildren() if pattern.match(child.GetName())]
    return [str(prim.GetPath()) for prim in found]


def _nearest_first(prim: Any, max_depth: int | None) -> Iterator[Any]:
    """A prim and what is below it, level by level."""
    level, depth = [prim], 0
    while level:
        yield from level
        if depth == max_depth:
            return
        level = [child for one in level for child in one.GetFilteredChildren(Usd.TraverseInstanceProxies())]
        depth += 1


def get_all_matching_child_prims(
    prim: Any, *, predicate: Callable[[Any, str], bool], include_self: bool = False, max_depth: int | None = None
) -> list[Any]:
    if max_depth is not None and max_depth < 0:
        raise ValueError(f"max_depth is 0 or more, not {max_depth}")
    root = usd_prim(prim)
    found = [one for one in _nearest_first(root, max_depth) if include_self or one != root]
    return [one for one in map(offered, found) if predicate(one, str(one.GetPath()))]


def get_first_matching_child_prim(
    prim: Any, *, predicate: Callable[[Any, str], bool], include_self: bool = False
) -> Any:
    return next(iter(get_all_matching_child_prims(prim, predicate=predicate, include_self=include_self)), None)


def get_first_matching_parent_prim(
    prim: Any, *, predicate: Callable[[Any, str], bool], include_self: bool = False
) -> Any:
    one = usd_prim(prim)
    one = one if include_self else one.GetParent()
    while one and not one.IsPseudoRoot():
        if predicate(offered(one), str(one.GetPath())):
            return offered(one)
        one = one.GetParent()
    return None


def create_prim_attribute(prim: Any, *, name: str, type_name: Any, exist_ok: bool = True) -> Any:
    found = usd_prim(prim)
    if found.HasAttribute(name) and not exist_ok:
        raise RuntimeError(f"{found.GetPath()} has an attribute {name} already")
    from .foundation import resolve_value_type_name

    made = found.CreateAttribute(name, resolve_value_type_name(type_name, backend="usd"))
    return offered(found).GetAttribute(name) if asks_fabric() else made


def get_prim_attribute_names(prim: Any) -> list[str]:
    return [one.GetName() for one in usd_prim(prim).GetAttributes()]


def get_prim_attribute_value(prim: Any, attribute_name: str) -> Any:
    return _attribute(prim, attribute_name).Get()


def set_prim_attribute_value(prim: Any, attribute_name: str, value: Any) -> None:
    _attribute(prim, attribute_name).Set(value)


def _attribute(prim: Any, name: str) -> Any:
    found = usd_prim(prim).GetAttribute(name)
    if not found:
        raise ValueError(f"{get_prim_path(prim)} has no attribute {name!r}")
    return found


def ensure_api(prim: Any, api: Any, *args: Any, **kwargs: Any) -> Any:
    found = usd_prim(prim)
    return api(found, *args) if found.HasAPI(api, *args) else api.Apply(found, *args, **kwargs)


def has_api(prim: Any, api: Any, *, test: str = "all") -> bool:
    found = usd_prim(prim)
    listed = api if isinstance(api, (list, tuple)) else [api]
    applied = [str(one) for one in found.GetAppliedSchemas()]
    has = [
        any(one == name or one.startswith(f"{name}:") for one in applied)
        if isinstance(name, str)
        else found.HasAPI(name)
        for name in listed
    ]
    found_by = {"all": all(has), "any": any(has), "none": not any(has)}
    if test not in found_by:
        raise ValueError(f'the test is "all", "any" or "none", not {test!r}')
    return found_by[test]


def get_prim_variants(prim: Any) -> list[tuple[str, str]]:
    sets = usd_prim(prim).GetVariantSets()
    return [(name, sets.GetVariantSelection(name)) for name in sets.GetNames()]


def get_prim_variant_collection(prim: Any) -> dict[str, list[str]]:
    sets = usd_prim(prim).GetVariantSets()
    return {name: sets.GetVariantSet(name).GetVariantNames() for name in sets.GetNames()}


def set_prim_variants(prim: Any, *, variants: list[tuple[str, str]]) -> None:
    for name, choice in variants:
        usd_prim(prim).GetVariantSet(name).SetVariantSelection(choice)


def is_prim_non_root_articulation_link(prim: Any) -> bool:
    from graph.sim.scene.mechanisms import mechanisms_of

    found = usd_prim(prim)
    links = mechanisms_of(found.GetStage()).carriers(str(found.GetPath()))
    return bool(links) and "PhysicsArticulationRootAPI" not in found.GetAppliedSchemas() and len(links) > 1


def add_labels(prim: Any, *, labels: Any, taxonomy: str = "class") -> None:
    found = usd_prim(prim)
    listed = [labels] if isinstance(labels, str) else list(labels)
    name = f"semantics:labels:{taxonomy}"
    present = list(found.GetAttribute(name).Get() or ()) if found.HasAttribute(name) else []
    found.AddAppliedSchema(f"SemanticsLabelsAPI:{taxonomy}")
    merged = [*present, *(one for one in listed if one not in present)]
    found.CreateAttribute(name, Sdf.ValueTypeNames.TokenArray, custom=False).Set(merged)


def get_labels(prim: Any, *, include_descendants: bool = False) -> dict[str, list[str]]:
    out: dict[str, list[str]] = {}
    root = usd_prim(prim)
    for one in Usd.PrimRange(root) if include_descendants else [root]:
        for attribute in one.GetAttributes():
            if attribute.GetName().startswith("semantics:labels:"):
                taxonomy = attribute.GetName().rpartition(":")[2]
                held = out.setdefault(taxonomy, [])
                held += [str(label) for label in attribute.Get() or () if label not in held]
    return out


def remove_labels(prim: Any, *, labels: Any, taxonomy: str | None = None, include_descendants: bool = False) -> None:
    gone = {labels} if isinstance(labels, str) else set(labels)
    root = usd_prim(prim)
    for one in Usd.PrimRange(root) if include_descendants else [root]:
        for attribute in one.GetAttributes():
            name = attribute.GetName()
            if name.startswith("semantics:labels:") and taxonomy in (None, name.rpartition(":")[2]):
                attribute.Set([label for label in attribute.Get() or () if label not in gone])


def remove_all_labels(prim: Any, *, remove_taxonomies: bool = False, include_descendants: bool = False) -> None:
    root = usd_prim(prim)
    for one in Usd.PrimRange(root) if include_descendants else [root]:
        for name in [each.GetName() for each in one.GetAttributes()]:
            if not name.startswith("semantics:labels:"):
                continue
            one.GetAttribute(name).Set([])
            if remove_taxonomies:
                one.RemoveAppliedSchema(f"SemanticsLabelsAPI:{name.rpartition(':')[2]}")
                one.RemoveProperty(name)


def upgrade_prim_semantics_to_labels(prim: Any, *, include_descendants: bool = False) -> list[str]:
    """Turns labels of the former schema, `SemanticsAPI`, into present ones; gives the paths of the changed prims."""
    root, changed = usd_prim(prim), []
    for one in list(Usd.PrimRange(root)) if include_descendants else [root]:
        listed = one.GetPrimTypeInfo().GetAppliedAPISchemas()  # those that USD does not know, too
        former = [str(name) for name in listed if str(name).startswith("SemanticsAPI:")]
        for schema in former:
            name = f"semantic:{schema.partition(':')[2]}:params:semantic"
            taxonomy, label = (one.GetAttribute(name + part).Get() for part in ("Type", "Data"))
            if not taxonomy or not label:
                continue
            add_labels(one, labels=[str(label)], taxonomy=str(taxonomy))
            one.RemoveAppliedSchema(schema)
            for part in ("Type", "Data"):
                one.RemoveProperty(name + part)
            changed.append(str(one.GetPath()))
    return list(dict.fromkeys(changed))


def create_bbox_cache(time: Any = None, *, use_extents_hint: bool = True, use_extents: bool = True) -> Any:
    return UsdGeom.BBoxCache(time or Usd.TimeCode.Default(), ["default", "render", "proxy"], use_extents_hint)


def compute_aabb(prim: Any, *, bbox_cache: Any = None, include_children: bool = False) -> np.ndarray:
    cache = bbox_cache or create_bbox_cache(use_extents_hint=False)
    found = usd_prim(prim)
    if not found:
        raise ValueError(f"there is no prim {prim}")
    box = cache.ComputeWorldBound(found).ComputeAlignedRange()
    for one in Usd.PrimRange(found) if include_children else ():  # USD leaves out what is below a shape
        if one.IsA(UsdGeom.Boundable):
            box.UnionWith(cache.ComputeWorldBound(one).ComputeAlignedRange())
    return np.array([*box.GetMin(), *box.GetMax()])


def compute_combined_aabb(prims: list[Any], *, bbox_cache: Any = None) -> np.ndarray:
    if not len(prims):
        raise ValueError("give the prims whose common box is asked for; the list is empty")
    boxes = np.array([compute_aabb(one, bbox_cache=bbox_cache) for one in prims])
    return np.concatenate([boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)])


def compute_obb(prim: Any, *, bbox_cache: Any = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    box = (bbox_cache or create_bbox_cache(use_extents_hint=False)).ComputeWorldBound(usd_prim(prim))
    matrix = np.array(box.GetMatrix())
    low, high = np.array(box.GetRange().GetMin()), np.array(box.GetRange().GetMax())
    axes = matrix[:3, :3]
    lengths = np.linalg.norm(axes, axis=1)
    centre = np.append((low + high) / 2, 1.0) @ matrix
    return centre[:3], axes / lengths[:, None], (high - low) / 2 * lengths


def get_obb_corners(centroid: Any, axes: Any, half_extent: Any) -> np.ndarray:
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    out: np.ndarray = np.asarray(centroid) + (signs * np.asarray(half_extent)) @ np.asarray(axes)
    return out


def compute_obb_corners(prim: Any, *, bbox_cache: Any = None) -> np.ndarray:
    return get_obb_corners(*compute_obb(prim, bbox_cache=bbox_cache))
