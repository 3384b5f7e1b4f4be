"""`omni.kit.undo`: takes back commands that made prims, and those of classes with an `undo`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from graph.isaac.outcomes import tell_inert
from graph.isaac.session import kit

__all__ = ["begin_group", "clear_stack", "end_group", "group", "redo", "undo"]


@dataclass
class Done:
    """A command, or a group of them: how to take it back (None: nothing does), and how to do it again."""

    name: str
    back: Callable[[], Any] | None
    again: Callable[[], Any]


@dataclass
class _Stacks:
    done: list[Done] = field(default_factory=list)
    undone: list[Done] = field(default_factory=list)
    groups: list[int] = field(default_factory=list)
    """Where in `done` each open group begins."""


def _stacks() -> _Stacks:
    return kit().singleton(_Stacks, _Stacks)


def note(one: Done) -> None:
    """A command was executed."""
    _stacks().done.append(one)
    _stacks().undone.clear()


def undo() -> bool:
    held = _stacks()
    if not held.done:
        return False
    one = held.done.pop()
    if one.back is None:
        tell_inert(f"omni.kit.undo.undo of {one.name}")
        return False
    one.back()
    held.undone.append(one)
    return True


def redo() -> bool:
    held = _stacks()
    if not held.undone:
        return False
    one = held.undone.pop()
    one.again()
    held.done.append(one)
    return True


def begin_group() -> None:
    _stacks().groups.append(len(_stacks().done))


def end_group() -> None:
    held = _stacks()
    if not held.groups:
        return  # no group is open
    first = held.groups.pop()
    ones, held.done[first:] = held.done[first:], []
    if ones:
        backs = [one.back for one in reversed(ones)]

        def back() -> None:
            for call in backs:
                if call is not None:
                    call()

        def again() -> None:
            for one in ones:
                one.again()

        held.done.append(Done("a group", back if all(backs) else None, again))


@contextmanager
def group() -> Iterator[None]:
    begin_group()
    try:
        yield
    finally:
        end_group()


def clear_stack() -> None:
    held = _stacks()
    held.done.clear()
    held.undone.clear()
