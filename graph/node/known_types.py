"""What the `resolve` function of a node type gets: the types that are already known."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

from graph.values.types import Type


class KnownTypes(Mapping[str, "Type | None"]):
    """Resolved types by attribute name; None for those still open.

    Names are short (`a`; an input is preferred over an output of the same name) or full (`outputs:a`). `resolve`
    returns the types (or OGN names) of other open attributes; here a short name prefers the output. It is called again
    whenever more types are known, and its first answer for an attribute stays. It raises ValueError if types do not
    match.
    """

    @abstractmethod
    def value(self, name: str) -> Any:
        """The initial value of an unconnected input: as written, else its default."""

    @abstractmethod
    def end(self, name: str) -> str:
        """An input as messages name it: with its type and, if it is connected, its source."""

    @abstractmethod
    def variable(self, name: str) -> Type | None:
        """The type of a graph variable; None for an unknown name."""

    @property
    @abstractmethod
    def variables(self) -> Mapping[str, Type]:
        """The types of the graph's variables by name."""

    @property
    @abstractmethod
    def unfinished(self) -> bool:
        """Whether the graph is being edited and may still contain what a run would refuse, as in the original."""
