"""What public objects say about an attribute that they do not have: the one that was probably meant."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from .suggest import did_you_mean


class UnknownAttributeError(AttributeError):
    """An object has no such attribute; what was meant is looked for only when the message is read."""

    def __init__(self, name: str, owner: object) -> None:
        # Without `obj`, the interpreter adds no second suggestion of its own.
        super().__init__(name, name=name, obj=None)
        self._owner = owner

    def __str__(self) -> str:
        kind = type(self._owner)
        name = str(self.name)
        instead = getattr(kind, "_instead", {}).get(name)
        names = (one for one in dir(self._owner) if not one.startswith("_"))
        return f'{kind.__name__} has no "{name}"{f"; use {instead}" if instead else did_you_mean(name, names)}'


class Suggesting:
    """A class whose objects say which attribute was probably meant; the error is still an AttributeError."""

    __slots__ = ()
    _instead: ClassVar[Mapping[str, str]] = {}
    """What to use in the place of names that are similar to none, such as those of other programs."""

    if not TYPE_CHECKING:  # a type checker would take every name

        def __getattr__(self, name: str) -> Any:
            if hasattr(type(self), name):  # a property or slot failed: its own error says why
                return object.__getattribute__(self, name)
            if name.startswith("__"):
                raise AttributeError(name)
            raise UnknownAttributeError(name, self)
