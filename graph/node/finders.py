"""Where a registry finds node types: the shipped library with its wings, and packages that declare entry points."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from types import FunctionType
from typing import Any, Protocol

from graph.base.plugins import NODES, OGN, READERS, Plugin, of_others, required, shipped

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


def shipped_types(registry: TypeList) -> None:
    """Adds the names of the shipped types; a type's module is imported when the type is first used."""
    for module, ids in registry.library.types.items():
        registry.note(f"{registry.library.package}.{module}", ids)
    for type_id, plugin in shipped(NODES).items():
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
        read = required(READERS, "ogn", FunctionType, "reader")
        registry.add_package(plugin, partial(read, registry, plugin.name, plugin.value))


ALL = (shipped_types, installed_packages)
"""The finders of the default registry, in order."""
