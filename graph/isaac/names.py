"""The table `names.txt`: which modules and names of Isaac Sim exist here, and what becomes of each.

    omni.timeline = timeline               the module has the names of graph/isaac/modules/timeline.py, or of a wing's
                                           module that pyproject.toml declares under this name in "tickgraph.names"
    usdrt.Sdf = usdrt:Sdf                  those of an object in that file
    omni.isaac.kit > isaacsim              an old name of another module
    omni.isaac.core.prims > isaacsim.core.prims old_meanings    the same, with names that meant something else
    omni.ui                                a module without code of its own
      B Window class                       exists and does nothing; the value that it gives
      C Painter why; what instead          refuses at its first use

Rows below a module line belong to it; the name `*` stands for every name.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from importlib import import_module, resources
from typing import Any

from graph.base.plugins import NAMES, load, shipped


@dataclass(frozen=True, slots=True)
class Row:
    """A name without behaviour: `kind` B (does nothing, gives `text`) or C (refuses, because of `text`)."""

    kind: str
    text: str


@dataclass(slots=True)
class Names:
    """What a module has."""

    known: bool = False
    homes: tuple[str, ...] = ()
    """Modules in graph/isaac/modules or in wings whose `__all__` it has."""
    rows: dict[str, Row] = field(default_factory=dict)
    instead: str = ""
    """The present name of a module with an old name."""
    submodules: set[str] = field(default_factory=set)

    def row(self, name: str) -> Row | None:
        """The row of a name, or of all names that are not modules."""
        return self.rows.get(name) or (None if name in self.submodules else self.rows.get("*"))

    def add_homes(self, homes: list[str]) -> None:
        """Adds homes, without those of a wing that is not installed: then names that are not elsewhere say so."""
        for home in homes:
            plugin = shipped(NAMES).get(home)
            if plugin and plugin.absence:
                self.rows["*"] = Row("C", plugin.absence)
            else:
                self.homes += (home,)

    def public(self) -> list[str]:
        """All names, sorted."""
        homes = [public_names(home_of(home)) for home in self.homes]
        return sorted({name for home in homes for name in home} | (self.rows.keys() - {"*"}))


@cache
def table() -> dict[str, Names]:
    """Every module by its full name, parents included."""
    found: dict[str, Names] = {}
    old: dict[str, str] = {}
    present = Names()
    for line in resources.files(__package__).joinpath("names.txt").read_text(encoding="utf-8").splitlines():
        if not line or line.startswith("#"):
            continue
        if line.startswith(" "):
            kind, names, text = line.split(maxsplit=2)
            present.rows.update(dict.fromkeys(names.split(","), Row(kind, text)))
            continue
        name, sign, rest = (part.strip() for part in (*line.split(maxsplit=2), "", "")[:3])
        present = found.setdefault(name, Names())
        present.known = True
        if sign == "=":
            present.add_homes(rest.split())
        elif sign == ">":
            old[name], *homes = rest.split()
            present.add_homes(homes)
    for name, instead in old.items():
        target = found[instead]
        made = found[name]
        made.homes, made.rows = (*made.homes, *target.homes), {**target.rows, **made.rows}
        made.instead = instead
    for name in list(found):
        while name:
            parent, _, last = name.rpartition(".")
            if parent:
                above = found.setdefault(parent, Names())
                above.known = True
                above.submodules.add(last)
            name = parent
    found.pop("pxr", None)
    return found


def home_of(home: str) -> Any:
    """The module in graph/isaac/modules, or the object in it, that a table's line names: `file` or `file:object`.

    For a name that is declared, what a wing has. Raises PluginError without the wing.
    """
    if home in shipped(NAMES):
        return load(NAMES, home, object)
    file, _, name = home.partition(":")
    module = import_module(f"graph.isaac.modules.{file}")
    return getattr(module, name) if name else module


def public_names(place: Any) -> list[str]:
    """The names that scripts may import from it."""
    return getattr(place, "__all__", None) or [name for name in dir(place) if not name.startswith("_")]


_NONE = Names()


def names_of(module: str) -> Names:
    """What a module has; an unknown one has nothing."""
    return table().get(module, _NONE)
