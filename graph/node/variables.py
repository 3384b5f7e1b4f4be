"""The variables of one graph: typed values that its nodes read and write."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from graph.base.suggest import did_you_mean
from graph.values.coercion import coerce
from graph.values.types import Type


class Variables(Mapping[str, Any]):
    """Values by name. Assigning converts to the variable's type; `reset` restores the values of the file."""

    def __init__(self, types: Mapping[str, Type], initial: Mapping[str, Any]) -> None:
        self.types = dict(types)
        self.changes = 0
        """Counts the writes that changed something."""
        self._initial = dict(initial)
        self._values = dict(initial)
        self._watchers: list[Callable[[str], None]] = []

    def __getitem__(self, name: str) -> Any:
        """The value. Raises KeyError with the nearest name if the graph has no such variable."""
        self._check(name)
        return self._values[name]

    def __setitem__(self, name: str, value: Any) -> None:
        """Sets a value. Raises KeyError for an unknown name and ValueError for a value that does not fit the type."""
        self._check(name)
        self._values[name] = coerce(self.types[name], value)
        self.changes += 1
        for told in self._watchers:
            told(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def watch(self, told: Callable[[str], None]) -> Callable[[], None]:
        """Calls `told(name)` after every write. Returns a function that ends the calls."""
        self._watchers.append(told)
        return lambda: self._watchers.remove(told)

    def initial(self, name: str) -> Any:
        """The value that a reset restores."""
        self._check(name)
        return self._initial[name]

    def take(self, fresh: Variables) -> None:
        """Takes over the variables of an edited graph; variables that keep their type keep their values."""
        kept = {
            name: self._values[name] if self.types.get(name) is type_ else fresh[name]
            for name, type_ in fresh.types.items()
        }
        self.types, self._initial, self._values = fresh.types, fresh._initial, kept

    def reset(self) -> None:
        """Restores the values of the file."""
        self._values = dict(self._initial)

    def _check(self, name: str) -> None:
        if name not in self._values:
            raise KeyError(f'the graph has no variable "{name}"{did_you_mean(name, self._values)}')
