"""Execution outputs at run time, and the storage and copying of attribute values."""

from __future__ import annotations

import keyword
from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

from graph.node.attribute_names import python_name

if TYPE_CHECKING:
    from graph.node.database import Database

Copy = Callable[[], None]


Step = tuple["Database", Any, Any, "Copy | None", list[Any]]
"""A node to compute, why it computes, and what the walk needs of it.

The reason is an execution input's name, STARTED or RETURNED; the walk needs its compute function, its copies and the
list of fired outputs.
"""


def step_to(db: Database, cause: Any) -> Step:
    """The step that computes a connected node for this reason."""
    return db, cause, db._compute, db._push, db._enabled


class Wire:
    """An execution output.

    Its targets are stored last connection first, because a walk is a stack; `only`: the single target.
    """

    __slots__ = ("count", "name", "only", "targets")

    def __init__(self, name: str) -> None:
        self.name = name
        self.count = 0
        self.targets: tuple[Step, ...] = ()
        self.only: Step | None = None

    def lead_to(self, targets: Sequence[tuple[Database, str]]) -> None:
        """Sets the targets, in the order in which they are followed; their nodes are connected already."""
        self.targets = tuple([step_to(db, name) for db, name in reversed(targets)])
        self.only = self.targets[0] if len(targets) == 1 else None

    def renew(self) -> None:
        """Reads the present compute functions of the targets."""
        self.targets = tuple(step_to(db, cause) for db, cause, *_ in self.targets)
        self.only = self.targets[0] if len(self.targets) == 1 else None


def storage(owner: str, names: Sequence[str]) -> type:
    """A class of objects with exactly these attributes; any other name is an AttributeError that says who has it."""
    return _storage_class(owner, tuple(map(python_name, names)))


@cache
def _storage_class(owner: str, names: tuple[str, ...]) -> type:
    return type(owner, (), {"__slots__": names, "__doc__": f"Values of the {owner}."})


def copy_between(source: Any, source_name: str, target: Any, target_name: str, convert: Any = None) -> Copy:
    """The function that copies one attribute's value to another; `convert`, if given, converts it.

    A closure over both objects with the names compiled in: half the time of getattr and setattr.
    """
    make = _copier(python_name(source_name), python_name(target_name), convert is not None)
    return make(source, target) if convert is None else make(source, target, convert)  # type: ignore[no-any-return]


def all_of(copies: Sequence[Copy]) -> Copy | None:
    """One function that calls all these copies; None for an empty list."""
    if not copies:
        return None
    if len(copies) == 1:
        return copies[0]
    each = tuple(copies)

    def copy_all() -> None:
        for copy in each:
            copy()

    return copy_all


@cache
def _copier(source_name: str, target_name: str, converts: bool) -> Any:
    # The names are attribute names, checked here; nothing else goes into the source text.
    if not all(name.isidentifier() and not keyword.iskeyword(name) for name in (source_name, target_name)):
        return _slow_copier(source_name, target_name)
    value = f"convert(source.{source_name})" if converts else f"source.{source_name}"
    text = (
        f"def make(source, target{', convert' if converts else ''}):\n"
        "    def copy():\n"
        f"        target.{target_name} = {value}\n"
        "    return copy\n"
    )
    scope: dict[str, Any] = {}
    exec(compile(text, f"<copy {source_name} to {target_name}>", "exec"), scope)
    return scope["make"]


def _slow_copier(source_name: str, target_name: str) -> Any:
    def make(source: Any, target: Any, convert: Any = lambda value: value) -> Copy:
        return lambda: setattr(target, target_name, convert(getattr(source, source_name)))

    return make
