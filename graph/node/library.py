"""What the package of shipped node types provides beside declarations: tables that are imported at first use."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from importlib import import_module
from typing import Any, Protocol, cast


class Renames(Protocol):
    """Names that types and attributes had in older files; see `nodes.catalog.renames`."""

    PREFIXES: Mapping[str, tuple[str, ...]]
    TYPES: Mapping[str, str]
    RENAMED: Mapping[str, Mapping[str, str]]
    REMOVED: Mapping[str, str]
    MEANT_NOTHING: Mapping[str, tuple[int, Mapping[str, Any]]]
    KINDS: Mapping[tuple[str, str], Mapping[str, str]]


class Library:
    """A package of node types: `TYPES` says which module registers which type, `catalog` holds the other tables."""

    def __init__(self, package: str) -> None:
        self.package = package

    @property
    def types(self) -> Mapping[str, tuple[str, ...]]:
        """Type ids by the module that registers them."""
        types: Mapping[str, tuple[str, ...]] = import_module(self.package).TYPES
        return types

    @cached_property
    def renames(self) -> Renames:
        """The names that types and attributes had in older files."""
        return cast("Renames", import_module(f"{self.package}.catalog.renames"))

    def why_absent(self, name: str) -> str | None:
        """Why a type of the original is not available here, by its id or its last part; None for any other name."""
        absent: Mapping[str, str] = import_module(f"{self.package}.catalog.absent").ABSENT
        if name in absent or "." in name:
            return absent.get(name)
        return next((why for known, why in absent.items() if known.rpartition(".")[2] == name), None)


SHIPPED = Library("nodes")
"""The library of the shipped types; they are preferred when two types share a short name."""
