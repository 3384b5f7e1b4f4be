"""Which node types exist: those of the `nodes` package, then those that installed packages add by entry point."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module, metadata

from .absent import why_absent
from .declaration import NodeType
from .errors import UserError
from .suggest import did_you_mean

ENTRY_POINTS = "tickgraph.nodes"
"""Entry point group of third-party node packages: each names a module whose import registers its types."""

OGN_ENTRY_POINTS = "tickgraph.ogn"
"""Entry point group of packages with `.ogn` files, see `graph.ogn`."""

SHIPPED = "nodes"
"""The package of the shipped types; they win when two types share a short name."""


class UnknownNodeTypeError(UserError, KeyError):
    """No registered node type has that id or short name."""

    def __str__(self) -> str:
        return Exception.__str__(self)


class Registry:
    """Node types by id and by short name: the id's last part, with or without a leading `Ogn`."""

    def __init__(self, *, shipped: bool = False) -> None:
        self._types: dict[str, NodeType] = {}
        self._short: dict[str, list[NodeType]] = {}
        self._broken: dict[str, str] = {}
        # Only the default registry fills itself, at the first look-up.
        self._to_load = shipped

    def add(self, node_type: NodeType) -> None:
        """Registers a type. Raises UserError, naming both origins, if its id is taken."""
        taken = self._types.get(node_type.id)
        if taken is not None:
            raise UserError(
                f'node type "{node_type.id}" is registered twice: by {taken.origin} and by {node_type.origin}; '
                "give one of them another id"
            )
        self._types[node_type.id] = node_type
        for name in _short_names(node_type):
            self._short.setdefault(name, []).append(node_type)

    def add_broken(self, name: str, problem: str) -> None:
        """Notes that the type of that short name has a declaration that cannot be used, and what is wrong with it."""
        self._broken.setdefault(_bare(name), problem)

    def get(self, name: str, *, suggest: bool = True) -> NodeType:
        """The type of that id or short name.

        Raises UnknownNodeTypeError with the nearest name (not without `suggest`: looking for one takes its time), with
        the candidates of an ambiguous one, or with what is wrong with the `.ogn` file that declares it.
        """
        self._load()
        if name in self._types:
            return self._types[name]
        candidates = self._short.get(name, [])
        shipped = [one for one in candidates if one.shipped]
        for group in (shipped, candidates):
            if len(group) == 1:
                return group[0]
        if candidates:
            ids = " or ".join(f'"{one.id}"' for one in candidates)
            raise UnknownNodeTypeError(f'node type "{name}" is ambiguous; write {ids}')
        if broken := self._broken.get(_bare(name)):
            raise UnknownNodeTypeError(f'node type "{name}" cannot be used: {broken}')
        if absent := why_absent(name):
            raise UnknownNodeTypeError(f'no node type "{name}": {absent}')
        if not suggest:
            raise UnknownNodeTypeError(f'no node type "{name}"')
        known = (*self._types, *self._short) if "." in name else (*self._short, *self._types)
        raise UnknownNodeTypeError(f'no node type "{name}"{did_you_mean(name, known)}')

    def all(self) -> list[NodeType]:
        """Every registered type, sorted by id."""
        self._load()
        return [self._types[name] for name in sorted(self._types)]

    def __contains__(self, name: str) -> bool:
        self._load()
        return name in self._types or name in self._short

    def __iter__(self) -> Iterator[NodeType]:
        return iter(self.all())

    def _load(self) -> None:
        if not self._to_load:
            return
        self._to_load = False
        import_module(SHIPPED)
        for entry in sorted(metadata.entry_points(group=ENTRY_POINTS), key=lambda entry: (entry.name, entry.value)):
            try:
                entry.load()
            except UserError:
                raise
            except Exception as error:
                raise UserError(
                    f'the node package "{entry.name}" ({entry.value}) cannot be imported: {error}; '
                    "repair or uninstall it"
                ) from error
        self._load_ogn_packages()

    def _load_ogn_packages(self) -> None:
        """Registers the types that installed packages declare by `.ogn` files."""
        for entry in sorted(metadata.entry_points(group=OGN_ENTRY_POINTS), key=lambda entry: (entry.name, entry.value)):
            from .ogn import register_package

            try:
                register_package(self, entry.name, entry.value)
            except ImportError as error:
                raise UserError(
                    f'the node package "{entry.name}" ({entry.value}) cannot be imported: {error}; '
                    "repair or uninstall it"
                ) from error


def _bare(name: str) -> str:
    """The last part of an id, without a leading `Ogn`."""
    return name.rpartition(".")[2].removeprefix("Ogn")


def _short_names(node_type: NodeType) -> set[str]:
    short = node_type.short_name
    return {short, short.removeprefix("Ogn"), f"Ogn{short}"}


DEFAULT = Registry(shipped=True)
"""The registry that files, the command and `@node_type` use."""


def get(name: str) -> NodeType:
    """The type of that id or short name in the default registry; see `Registry.get`."""
    return DEFAULT.get(name)


def all() -> list[NodeType]:
    """Every type of the default registry, sorted by id."""
    return DEFAULT.all()
