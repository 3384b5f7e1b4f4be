"""Which node types exist: those that were added, and those that finders find.

Only the name of a shipped type is known until the type is used; then its module is imported. Installed packages are
imported when no shipped type has the name; a package that fails is left out, with a warning.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module

from graph.base.errors import UserError
from graph.base.plugins import Plugin, leave_out
from graph.base.suggest import did_you_mean_id

from . import finders
from .declaration import NodeType
from .finders import Finder
from .library import SHIPPED, Library

_SHORTEST_WORD, _NAMED = 3, 3


class UnknownNodeTypeError(UserError, KeyError):
    """No registered node type has this id or short name."""

    def __str__(self) -> str:
        return Exception.__str__(self)


class Registry:
    """Node types by id and by short name: the id's last part, with or without a leading `Ogn`."""

    def __init__(self, finders: Iterable[Finder] = (), library: Library = SHIPPED) -> None:
        # Until a shipped type is used, its value is the name of the module that registers it.
        self._types: dict[str, NodeType | str] = {}
        self._short: dict[str, list[str]] = {}
        self._broken: dict[str, str] = {}
        self._left_out: list[str] = []
        self._packages: list[str] = []
        self.library = library
        """Knows the types that are not available here, and former names."""
        self._finders = tuple(finders)
        self._asked = 0
        self._asking = threading.RLock()

    def add(self, node_type: NodeType) -> None:
        """Registers a type. Raises UserError, which names both origins, if its id is taken."""
        taken = self._types.get(node_type.id)
        if isinstance(taken, str) and node_type.origin.rpartition(":")[0] != taken:
            taken = self._loaded(node_type.id)
        if isinstance(taken, NodeType):
            raise UserError(
                f'node type "{node_type.id}" is registered twice: by {taken.origin} and by {node_type.origin}; '
                "give one of them another id"
            )
        self._note(node_type.id, node_type)

    def _note(self, type_id: str, known: NodeType | str) -> None:
        if type_id not in self._types:
            for name in short_names(type_id):
                self._short.setdefault(name, []).append(type_id)
        self._types[type_id] = known

    def add_broken(self, name: str, problem: str) -> None:
        """Records that a type's declaration cannot be used, and why."""
        self._broken.setdefault(_bare(name), problem)

    def get(self, name: str, *, suggest: bool = True) -> NodeType:
        """The type with that id or short name.

        Raises UnknownNodeTypeError: with the nearest name (`suggest=False` skips it, because the search takes time),
        with the candidates of an ambiguous name, or with the mistake in the `.ogn` file or in the package that declares
        the type.
        """
        self._load()
        found = self._find(name) or (self._search() and self._find(name))
        if found:
            return self._loaded(found)
        if candidates := self._short.get(name):
            ids = " or ".join(f'"{one}"' for one in candidates)
            raise UnknownNodeTypeError(f'node type "{name}" is ambiguous; write {ids}')
        if broken := self._broken.get(_bare(name)):
            raise UnknownNodeTypeError(f'node type "{name}" cannot be used: {broken}')
        if absent := self.library.why_absent(name):
            raise UnknownNodeTypeError(f'no node type "{name}": {absent}')
        near = ""
        if suggest:
            known = (*self._types, *self._short) if "." in name else (*self._short, *self._types)
            near = did_you_mean_id(name, known) or self._held_by(name)
        lost = "".join(f"; it may be of {problem}" for problem in self._left_out)
        raise UnknownNodeTypeError(f'no node type "{name}"{near}{lost or ("" if near else self._where_else())}')

    def _held_by(self, word: str) -> str:
        """The types that have a word such as "camera" in their names, and the command that lists them; or ""."""
        found = [name for name in self._short if word.casefold() in name.casefold() and not name.startswith("Ogn")]
        if len(word) < _SHORTEST_WORD or not word.isalnum() or not found:
            return ""
        more = f" and {len(found) - _NAMED} more" if len(found) > _NAMED else ""
        return f"; it is part of {', '.join(found[:_NAMED])}{more} (graph nodes {word})"

    def _where_else(self) -> str:
        """Advice on where an unknown type without a similar name can come from."""
        if not self._finders:
            return ""
        packages = ", ".join(self._packages)
        searched = f"none of the node packages here has it ({packages})" if packages else "no node package is installed"
        return f"; {searched}, and --nodes FILE.py brings types of your own"

    def _find(self, name: str) -> str | None:
        """The id of a type by id or short name; None if it is unknown or the short name is ambiguous."""
        if name in self._types:
            return name
        candidates = self._short.get(name, [])
        shipped = [one for one in candidates if self._shipped(one)]
        return next((group[0] for group in (shipped, candidates) if len(group) == 1), None)

    def all(self) -> list[NodeType]:
        """Every registered type, sorted by id."""
        self._load()
        self._search()
        return [self._loaded(name) for name in sorted(self._types)]

    def loaded(self) -> list[NodeType]:
        """The types that are registered now; shipped types are registered at first use."""
        return [known for known in self._types.values() if isinstance(known, NodeType)]

    def __contains__(self, name: str) -> bool:
        self._load()
        return self._knows(name) or (self._search() and self._knows(name))

    def _knows(self, name: str) -> bool:
        return name in self._types or name in self._short

    def __iter__(self) -> Iterator[NodeType]:
        return iter(self.all())

    def _loaded(self, type_id: str) -> NodeType:
        """The type with a known id; imports its module at the first call."""
        known = self._types[type_id]
        if isinstance(known, str):
            import_module(known)
            registered = DEFAULT._types[type_id]  # shipped modules register here, whatever registry asks for them
            if isinstance(registered, str):
                raise LookupError(f'{known} is to register the node type "{type_id}", and does not')
            known = self._types[type_id] = registered
        return known

    def _shipped(self, type_id: str) -> bool:
        known = self._types[type_id]
        return isinstance(known, str) or known.shipped

    def _load(self) -> None:
        """Runs the first finder, which is needed before every look-up."""
        self._ask(1)

    def _search(self) -> bool:
        """Runs the other finders, once; returns whether it ran them now."""
        before = self._asked
        self._ask(len(self._finders))
        return self._asked > before

    def _ask(self, count: int) -> None:
        with self._asking:  # other threads wait until what a finder adds is there
            while self._asked < min(count, len(self._finders)):
                self._asked += 1
                try:
                    self._finders[self._asked - 1](self)
                except UserError:
                    self._asked -= 1
                    raise

    def note(self, module: str, ids: Iterable[str]) -> None:
        """Records the types that a shipped module registers; the module is imported when one of them is used."""
        for type_id in ids:
            taken = self._types.get(type_id)
            if taken is None:
                self._note(type_id, module)
            elif isinstance(taken, NodeType) and not taken.shipped:
                import_module(module)  # says whose id it is

    def add_package(self, plugin: Plugin, add: Callable[[], object]) -> None:
        """Adds all types of a package, or none of them and a warning; `add` registers them."""
        before = set(self._types)
        try:
            add()
            self._packages.append(plugin.name)
        except (Exception, SystemExit) as error:  # a third-party module may raise anything
            for type_id in set(self._types) - before:
                self.remove(type_id)
            reason = leave_out(plugin, error)
            self._left_out.append(f'the node package "{plugin.name}" ({plugin.value}), which is left out: {reason}')

    def remove(self, type_id: str) -> None:
        """Removes a type. Raises KeyError for an unknown id."""
        del self._types[type_id]
        for name in short_names(type_id):
            self._short[name].remove(type_id)
            if not self._short[name]:
                del self._short[name]


def _bare(name: str) -> str:
    """The last part of an id, without a leading `Ogn`."""
    return name.rpartition(".")[2].removeprefix("Ogn")


def short_names(type_id: str) -> set[str]:
    """The short names of an id: its last part, with and without a leading `Ogn`."""
    short = type_id.rpartition(".")[2]
    return {short, short.removeprefix("Ogn"), f"Ogn{short}"}


DEFAULT = Registry(finders.ALL)
"""The registry that files, the command and `@node_type` use."""


def get(name: str) -> NodeType:
    """The type with that id or short name in the default registry; see `Registry.get`."""
    return DEFAULT.get(name)


def all() -> list[NodeType]:
    """Every type of the default registry, sorted by id."""
    return DEFAULT.all()
