"""Where a registry finds node types: the shipped library, and packages that declare entry points."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from importlib import import_module
from typing import Any, Protocol

from graph.base.entry_points import entry_points

from .library import Library


class TypeList(Protocol):
    """The interface that receives the types: a registry."""

    @property
    def library(self) -> Library:
        """What ships, by module."""

    def note(self, module: str, ids: Iterable[str]) -> None:
        """Records the types that a shipped module registers."""

    def add_package(self, name: str, add: Callable[[], object]) -> None:
        """Adds all types of a package, or none of them and a warning; `add` registers them."""


Finder = Callable[[Any], None]
"""Adds the types it finds to a registry; called once, when an unknown name is first looked up."""

ENTRY_POINTS = "tickgraph.nodes"
"""Entry point group of third-party node packages: each entry names a module that registers its types at import."""

OGN_ENTRY_POINTS = "tickgraph.ogn"
"""Entry point group of packages with `.ogn` files, see `graph.ogn`."""

_OGN = "graph.ogn.packages"
"""The module that reads them; named here and not imported, because it imports this package."""


def shipped_types(registry: TypeList) -> None:
    """Adds the names of the shipped types; a type's module is imported when the type is first used."""
    for module, ids in registry.library.types.items():
        registry.note(f"{registry.library.package}.{module}", ids)


def installed_packages(registry: TypeList) -> None:
    """Imports the types of installed packages."""
    types, ogn = entry_points(ENTRY_POINTS, OGN_ENTRY_POINTS)
    for entry in types:
        registry.add_package(f"{entry.name} ({entry.value})", entry.load)
    for entry in ogn:
        add = partial(import_module(_OGN).register_package, registry, entry.name, entry.value)
        registry.add_package(f"{entry.name} ({entry.value})", add)


ALL = (shipped_types, installed_packages)
"""The finders of the default registry, in order."""
