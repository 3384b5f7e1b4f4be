"""How much memory the values of graphs may take: a graph file from a stranger must not fill the machine."""

from __future__ import annotations

from . import limits

SMALL = 2**12
"""Values of up to so many bytes are not counted."""


class Room:
    """Counts the large values that nodes have made last."""

    def __init__(self, most: int | None = None) -> None:
        self.most = limits.most("graph.bytes") if most is None else most
        self._held: dict[str, int] = {}
        self._total = 0

    def claim(self, owner: str, size: int) -> str | None:
        """Notes that a node is about to hold `size` bytes in place of what it held; what is wrong if that is too much.

        What was noted before stays so then.
        """
        held = self._held.get(owner, 0)
        if size <= SMALL:
            if held:
                self._total -= self._held.pop(owner)
            return None
        if self._total - held + size > self.most:
            return (
                f"its result would take {size:,} bytes, and all values of the graphs may take {self.most:,} together; "
                f"{limits.allowed('graph.bytes')}"
            )
        self._held[owner] = size
        self._total += size - held
        return None
