"""`isaacsim.storage.native`: paths and addresses of files, and the USD files below a folder."""

from __future__ import annotations

import os
import posixpath
import re
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import urlparse, urlunparse

from graph.isaac.assets import local_path, root
from graph.isaac.session import warn

__all__ = [
    "_URL_SCHEMES",
    "count_asset_references",
    "find_absolute_paths_in_usds",
    "find_external_references",
    "find_files_recursive",
    "find_filtered_files",
    "find_filtered_files_async",
    "find_missing_references",
    "get_stage_references",
    "is_absolute_path",
    "is_local_path",
    "is_mdl_file",
    "is_path_external",
    "is_valid_usd_file",
    "layer_has_missing_references",
    "path_dirname",
    "path_exists",
    "path_join",
    "path_relative",
    "prim_has_missing_references",
    "prim_spec_has_missing_references",
    "resolve_asset_path",
    "resolve_asset_path_async",
]
_URL_SCHEMES = ("omniverse://", "https://", "http://", "ftp://", "sftp://")


def path_join(base: str, name: str) -> str:
    if "://" not in base:
        return os.path.join(base, name)
    rest = name.replace("\\", "/").removeprefix("./")
    while rest.startswith("../"):
        base, rest = base.rpartition("/")[0], rest[3:]
    return f"{base.removesuffix('/')}/{rest}"


def path_dirname(path: str) -> str:
    parts = urlparse(path)
    if not (parts.scheme and parts.netloc):
        return os.path.dirname(os.path.normpath(path)) + os.sep
    return urlunparse((parts.scheme, parts.netloc, f"{posixpath.dirname(parts.path).rstrip('/')}/", "", "", ""))


def path_relative(path: str, start: str) -> str:
    one, other = urlparse(path), urlparse(start.rstrip("/\\"))
    if not (one.scheme and one.netloc):
        return os.path.relpath(os.path.normpath(path), os.path.normpath(start))
    if (one.scheme, one.netloc) != (other.scheme, other.netloc):
        raise ValueError(f"{path} is on another server than {start}")
    return posixpath.relpath(one.path, other.path)


def is_local_path(path: str) -> bool:
    return not path.strip().startswith(_URL_SCHEMES)


def is_absolute_path(path: str) -> bool:
    return "://" in path or os.path.isabs(path)


def is_path_external(path: str, base_path: str) -> bool:
    return str(base_path) not in str(path)


def is_valid_usd_file(item: str, excludes: Any) -> bool:
    return item.lower().endswith((".usd", ".usda", ".usdc", ".usdz")) and not any(one in item for one in excludes)


def is_mdl_file(item: str) -> bool:
    return item.lower().endswith(".mdl")


async def path_exists(path: str) -> bool:
    return local_path(path) is not None


def resolve_asset_path(original_path: str) -> str | None:
    below_root = f"{root()}/{original_path.removeprefix('/')}"
    return next((one for one in (original_path, below_root) if local_path(one) is not None), None)


async def resolve_asset_path_async(original_path: str) -> str | None:
    return resolve_asset_path(original_path)


def _files(path: str, max_depth: int | None = None) -> Iterator[str]:
    """The files below a path or address, as this names them, folders in order."""
    found = local_path(path)
    if found is None or not os.path.isdir(found):
        warn("asset-missing", path, "it is not a folder here; no file of it is listed")
        return
    for folder, inner, names in os.walk(found):
        below = os.path.relpath(folder, found)
        depth = 0 if below == os.curdir else below.count(os.sep) + 1
        inner[:] = sorted(inner) if max_depth is None or depth < max_depth else []
        place = path if below == os.curdir else path_join(path, below)
        yield from (path_join(place, name) for name in sorted(names))


def find_files_recursive(abs_path: Any, filter_fn: Callable[[str], bool] = lambda a: True) -> Any:
    paths = [abs_path] if isinstance(abs_path, str) else abs_path
    return [one for path in paths for one in _files(path) if filter_fn(os.path.basename(one))]


def find_filtered_files(
    abs_paths: Any,
    max_depth: int | None = None,
    filepath_excludes: Any = None,
    filter_patterns: Any = None,
    match_all: bool = False,
) -> set[str]:
    patterns: list[re.Pattern[str]] = []
    for text in filter_patterns or ():
        try:
            patterns.append(re.compile(text))
        except re.error as error:
            warn("pattern-invalid", text, f"it is not a regular expression ({error}); it matches nothing")
    fits = all if match_all else any
    return {
        one
        for path in abs_paths
        for one in _files(path, max_depth)
        if is_valid_usd_file(one, filepath_excludes or ())
        and (not filter_patterns or fits(pattern.search(one) for pattern in patterns))
    }


async def find_filtered_files_async(
    root_path: str,
    filter_patterns: Any = None,
    match_all: bool = False,
    filepath_excludes: Any = None,
    max_depth: int | None = None,
) -> set[str]:
    return find_filtered_files([root_path], max_depth, filepath_excludes, filter_patterns, match_all)


def get_stage_references(stage_path: str, resolve_relatives: bool = True) -> Any:
    from graph.sim.usd import Sdf

    layer = Sdf.Layer.FindOrOpen(local_path(stage_path) or stage_path)
    found = [] if layer is None else layer.GetExternalReferences()
    return [layer.ComputeAbsolutePath(one) if resolve_relatives else one for one in found if one]


def _references(base_path: str, which: Callable[[str], bool], *, resolve: bool) -> dict[str, list[str]]:
    """The references of each USD file below a path that fulfil a condition; files without any are left out."""
    files = find_filtered_files([base_path])
    found = {one: [ref for ref in get_stage_references(one, resolve) if which(ref)] for one in sorted(files)}
    return {one: references for one, references in found.items() if references}


async def find_absolute_paths_in_usds(base_path: str) -> dict[str, list[str]]:
    return _references(base_path, is_absolute_path, resolve=False)


async def find_external_references(base_path: str) -> dict[str, list[str]]:
    inside = local_path(base_path) or base_path
    return _references(base_path, lambda one: is_path_external(one, inside), resolve=True)


async def count_asset_references(base_path: str) -> dict[str, int]:
    counts = dict.fromkeys(find_files_recursive([base_path]), 0)
    for references in _references(base_path, bool, resolve=True).values():
        for one in references:
            counts[one] = counts.get(one, 0) + 1
    return counts


def find_missing_references(base_path: str) -> None:
    for file, missing in _references(base_path, lambda one: local_path(one) is None, resolve=True).items():
        print(file, missing)


def layer_has_missing_references(layer_identifier: str) -> bool:
    return any(local_path(one) is None for one in get_stage_references(layer_identifier))


def prim_spec_has_missing_references(prim_spec: Any) -> bool:
    names = [one.assetPath for one in prim_spec.referenceList.GetAddedOrExplicitItems()]
    return any(one and local_path(prim_spec.layer.ComputeAbsolutePath(one)) is None for one in names)


def prim_has_missing_references(prim: Any) -> bool:
    return any(map(prim_spec_has_missing_references, prim.GetPrimStack()))
