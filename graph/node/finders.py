"""Where a registry finds node types: the shipped library with its wings, and packages that declare entry points."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from importlib import import_module
from typing import Any, Protocol

from graph.base.plugins import NODES, OGN, Plugin, of_others, of_wings

from .library import Library


class TypeList(Protocol):
    """The interface that receives the types: a registry."""

    @property
    def library(self) -> Library:
        """What ships, by module."""

    def note(self, module: str, ids: Iterable[str]) -> None:
        """Records the types that a shipped module registers."""

    def add_broken(self, name: str, problem: str) -> None:
        """Records that a type cannot be used, and why."""

    def add_package(self, plugin: Plugin, add: Callable[[], object]) -> None:
        """Adds all types of a package, or none of them and a warning; `add` registers them."""


Finder = Callable[[Any], None]
"""Adds the types it finds to a registry; called once, when an unknown name is first looked up."""

_OGN = "graph.ogn.packages"
"""The module that reads packages with `.ogn` files; named here and not imported, because it imports this package."""


def shipped_types(registry: TypeList) -> None:
    """Adds the names of the shipped types; a type's module is imported when the type is first used."""
    for module, ids in registry.library.types.items():
        registry.note(f"{registry.library.package}.{module}", ids)
    for type_id, plugin in of_wings(NODES).items():
        if plugin.absence:
            registry.add_broken(type_id, plugin.absence)
        else:
            registry.note(plugin.module, (type_id,))


def installed_packages(registry: TypeList) -> None:
    """Imports the types of installed packages."""
    types, ogn = of_others(NODES, OGN)
    for plugin in types:
        registry.add_package(plugin, plugin.load)
    for plugin in ogn:
        add = partial(import_module(_OGN).register_package, registry, plugin.name, plugin.value)
        registry.add_package(plugin, add)


ALL = (shipped_types, installed_packages)
"""The finders of the default registry, in order."""
