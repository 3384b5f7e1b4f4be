"""`isaacsim.storage.native` and `omni.client`: where assets are."""

from __future__ import annotations

import os
from collections import namedtuple
from enum import IntEnum
from types import SimpleNamespace
from typing import Any
from urllib.parse import urljoin, urlparse

from graph.isaac.assets import ROOT_SETTING, UNMAPPED, local_path, root
from graph.isaac.outcomes import inert
from graph.isaac.session import app, warn

__all__ = [
    "Result",
    "Version",
    "break_url",
    "build_server_list",
    "check_server",
    "check_server_async",
    "combine_urls",
    "find_nucleus_server",
    "get_assets_root_path",
    "get_assets_root_path_async",
    "get_assets_server",
    "get_full_asset_path",
    "get_full_asset_path_async",
    "get_isaac_asset_root_path",
    "get_nvidia_asset_root_path",
    "get_server_path",
    "get_server_path_async",
    "get_url_root",
    "is_dir",
    "is_dir_async",
    "is_file",
    "is_file_async",
    "list",
    "list_folder",
    "read_file",
    "recursive_list_folder",
    "set_hang_detection_time_ms",
    "stat",
    "verify_asset_root_path",
]
Version = namedtuple("Version", "major minor patch")
Result = IntEnum(
    "Result",
    "OK OK_LATEST OK_NOT_YET_FOUND ERROR ERROR_CONNECTION ERROR_NOT_SUPPORTED ERROR_ACCESS_DENIED ERROR_NOT_FOUND "
    "ERROR_BAD_VERSION ERROR_ALREADY_EXISTS ERROR_ACCESS_LOST",
    start=0,
)


def get_assets_root_path(*, skip_check: bool = False) -> str:
    given = app().settings.get(ROOT_SETTING)
    if given is not None and not given:
        raise RuntimeError(f"{ROOT_SETTING} setting is not set")
    found = root()
    if found == UNMAPPED:
        message = (
            "its files are not downloaded; map them with --asset-root PREFIX=DIR. Prims of missing assets stay empty"
        )
        warn("asset-root-unmapped", found, message)
    return found


async def get_assets_root_path_async(*, skip_check: bool = False) -> str:
    return get_assets_root_path()


def get_isaac_asset_root_path() -> str:
    return f"{get_assets_root_path()}/Isaac"


def get_nvidia_asset_root_path() -> str:
    return f"{get_assets_root_path()}/NVIDIA"


def get_full_asset_path(path: str) -> str | None:
    full = f"{root()}{path}"
    return full if local_path(full) else None


async def get_full_asset_path_async(path: str) -> str | None:
    return get_full_asset_path(path)


def get_server_path(suffix: str = "") -> str:
    return f"{root()}{suffix}"


async def get_server_path_async(suffix: str = "") -> str:
    return get_server_path(suffix)


def get_assets_server() -> str:
    return root()


def get_url_root(url: str) -> str:
    parts = urlparse(url)
    return f"{parts.scheme}://{parts.netloc}" if parts.netloc else ""


def find_nucleus_server(suffix: str) -> tuple[bool, str]:
    return True, root()


def build_server_list() -> Any:
    return [root()]


def check_server(server: str, path: str, timeout: float = 10.0) -> bool:
    return local_path(f"{server}{path}") is not None


async def check_server_async(server: str, path: str, timeout: float = 10.0) -> bool:
    return check_server(server, path)


def verify_asset_root_path(path: str) -> tuple[Any, str]:
    return (Result["OK"], "6.0.1") if local_path(path) else (Result["ERROR_NOT_FOUND"], "")


def is_file(path: str) -> bool:
    found = local_path(path)
    return found is not None and os.path.isfile(found)


async def is_file_async(path: str) -> bool:
    return is_file(path)


def is_dir(path: str) -> bool:
    found = local_path(path)
    return found is not None and os.path.isdir(found)


async def is_dir_async(path: str) -> bool:
    return is_dir(path)


async def list_folder(path: str) -> tuple[Any, Any]:
    found = local_path(path)
    names = sorted(os.listdir(found)) if found and os.path.isdir(found) else []
    full = [f"{path.rstrip('/')}/{name}" for name in names]
    return [one for one in full if is_file(one)], [f"{one}/" for one in full if is_dir(one)]


async def recursive_list_folder(path: str) -> Any:
    files, folders = await list_folder(path)
    for folder in folders:
        files += await recursive_list_folder(folder.rstrip("/"))
    return files


def break_url(url: str) -> Any:
    parts = urlparse(url)
    return SimpleNamespace(scheme=parts.scheme, host=parts.netloc, path=parts.path, query=parts.query)


def combine_urls(base: str, other: str, add_trailing_slash: bool = False) -> str:
    out = urljoin(base, other)
    return f"{out}/" if add_trailing_slash and not out.endswith("/") else out


@inert("omni.client")
def set_hang_detection_time_ms(ms: int) -> None:
    return None


def stat(url: str) -> tuple[Any, Any]:
    found = local_path(url)
    if found is None:
        return Result["ERROR_NOT_FOUND"], None
    return Result["OK"], SimpleNamespace(relative_path=os.path.basename(found), size=os.path.getsize(found))


def read_file(url: str) -> tuple[Any, str, Any]:
    from graph.base.inputs import start_of

    found = local_path(url)
    if found is None:
        return Result["ERROR_NOT_FOUND"], "", b""
    return Result["OK"], "", memoryview(start_of(found, 100_000_000))


def list(url: str) -> tuple[Any, Any]:
    found = local_path(url)
    if found is None or not os.path.isdir(found):
        return Result["ERROR_NOT_FOUND"], ()
    names = sorted(os.listdir(found))
    inside = [os.path.isdir(os.path.join(found, name)) for name in names]  # the flag 4: it can have children
    return Result["OK"], tuple(
        SimpleNamespace(relative_path=a, flags=4 if b else 0) for a, b in zip(names, inside, strict=True)
    )
