"""Values that several owners have in common: made for the first of them, freed with the last."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Generic, TypeVar
from weakref import WeakValueDictionary

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


class Shared(Generic[K, V]):
    """Values by what decides them, for all Apps of this process; owners hold them and do not change them."""

    def __init__(self) -> None:
        self._found: WeakValueDictionary[K, V] = WeakValueDictionary()

    def of(self, key: K, make: Callable[[], V]) -> V:
        """The value of a key; `make` makes it if nobody has it."""
        found = self._found.get(key)
        return self._found.setdefault(key, make()) if found is None else found
