"""What a node type's `resolve` gets to know before it settles open types."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

from graph.values.types import Type


class KnownTypes(Mapping[str, "Type | None"]):
    """Settled types by attribute name, None for those still open.

    Names are short (`a`; an input goes before an output of that name) or full (`outputs:a`). `resolve` returns the
    types (or OGN names) of other open attributes, outputs before inputs where a short name means both; it is called
    again whenever more is known, and the first answer stays. It raises ValueError where types do not go together.
    """

    @abstractmethod
    def value(self, name: str) -> Any:
        """The value that an unconnected input will start with: as written, else its default."""

    @abstractmethod
    def end(self, name: str) -> str:
        """How a message names an input with its type and, if it is connected, with where it comes from."""

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
        """Whether the graph may hold what a run will refuse, as the original allows while it is edited."""
