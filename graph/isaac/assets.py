"""Where the assets of a script are: addresses and relative names to local files."""

from __future__ import annotations

import os
import re
from pathlib import Path

from graph.base import asset_roots

from .run import RUN
from .session import app_or_none, warn

ROOT_SETTING = "/persistent/isaac/asset_root/default"
UNMAPPED = "https://omniverse-content-production.s3-us-west-2.amazonaws.com/Assets/Isaac/6.0"
"""The address that scripts get while no asset root is mapped."""


def root() -> str:
    """The root of the product's assets: the setting, else the mapped root, else the public address."""
    app = app_or_none()
    given = app.settings.get(ROOT_SETTING) if app is not None else None
    if given:
        return str(given).rstrip("/")
    for prefix in asset_roots.present():
        if "Isaac" in prefix or prefix.startswith(("omniverse://", "http")):
            return prefix.rstrip("/")
    return UNMAPPED


def local_path(address: str) -> str | None:
    """The local file of an address or a path; None if it is remote and not mapped, or missing."""
    text = str(address)
    found = asset_roots.local_file(text)
    if found is None and "://" in text:
        if not text.startswith("file://"):
            return None
        text = text.removeprefix("file://")
    if found is None:
        found = Path(os.path.expanduser(text))
    return str(found) if found.exists() else None


def missing(address: str, wanted_by: str) -> None:
    """Says that an asset is not here, and what makes it available."""
    from graph.sim.scene.assets import not_here

    warn("asset-missing", wanted_by, f"{not_here(str(address))}; {wanted_by} stays empty")
    if (run := RUN.get()) is not None:
        run.missing[wanted_by] = str(address).rpartition("/")[2]


def missing_below(text: str) -> str:
    """Which missing asset explains a complaint about a prim, in brackets; "" if none does."""
    run = RUN.get()
    for path, name in run.missing.items() if run is not None else ():
        if f"{path}/" in text or re.search(rf"{re.escape(path)}(?!\w)", text):
            return f"({path} is empty because {name} is missing)"
    return ""


def found_asset(address: str, wanted_by: str, *, must_exist: bool = True) -> str:
    """The local file of an asset, or the layer of its stand-in; "" for a remote one that is not here, which is said.

    Raises FileNotFoundError for a missing local file, unless it need not exist.
    """
    from graph.sim.scene.assets import stand_in

    file = local_path(address)
    if file is None and (found := stand_in(str(address))) is not None:
        code, message = found.note()
        warn(code, str(address), message)  # once for all prims that refer to it
        return str(found.layer.identifier)
    if file is None:
        if must_exist and "://" not in str(address):
            raise FileNotFoundError(f"{address} does not exist")
        missing(address, wanted_by)
    return file or ""
