"""Local folders for the addresses by which scenes name their assets: `--asset-root PREFIX=DIR` (or `mapped`).

with asset_roots.mapped({"package://my_robot": "/models/my_robot"}):
    App.from_file("graph.yaml")
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from urllib.parse import unquote

_ADDRESS = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://")
"""How an address begins that no local file has; a drive letter is one character."""
_mapped: ContextVar[Mapping[str, Path]] = ContextVar("asset_roots", default={})  # noqa: B039 (never changed in place)


def present() -> Mapping[str, Path]:
    """The present folders by prefix."""
    return _mapped.get()


def is_address(text: str) -> bool:
    """Whether a text is an address instead of a file name."""
    return _ADDRESS.match(text) is not None


def names_asset(text: str) -> bool:
    """Whether a text names an asset of the product, which is found by the asset roots, instead of a file of ours."""
    return is_address(text) or text.startswith(("/Isaac/", "Isaac/"))


def local_file(address: str) -> Path | None:
    """The file that an address stands for: its longest prefix that is mapped decides; None if none is.

    A prefix ends at a `/` of the address. Raises ValueError for an address that leads out of its folder.
    """
    for prefix, folder in sorted(_mapped.get().items(), key=lambda item: -len(item[0])):
        start = prefix if prefix.endswith("://") else prefix.rstrip("/")
        rest = address.removeprefix(start)
        if address.startswith(start) and (start.endswith("//") or rest[:1] in ("", "/")):
            path = (folder / unquote(rest).lstrip("/")).resolve()
            if not path.is_relative_to(folder):
                raise ValueError(f"{address} leads out of {folder}, its asset root")
            return path
    return None


def checked_roots(roots: Mapping[str, str | Path]) -> dict[str, Path]:
    """The folder of each prefix, links resolved. Raises ValueError for an empty prefix and for a missing folder."""
    found: dict[str, Path] = {}
    for prefix, folder in roots.items():
        path = Path(folder).expanduser().resolve()
        if not prefix:
            raise ValueError("an asset root needs a prefix, such as package://my_robot")
        if not path.is_dir():
            raise ValueError(f"{folder}, the asset root of {prefix}, is not a folder")
        found[prefix] = path
    return found


@contextmanager
def mapped(roots: Mapping[str, str | Path]) -> Iterator[None]:
    """Maps prefixes to folders within a `with` block, besides those outside of it; raises as `checked_roots`."""
    token = _mapped.set({**_mapped.get(), **checked_roots(roots)})
    try:
        yield
    finally:
        _mapped.reset(token)
