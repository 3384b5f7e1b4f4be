"""Limits the memory that the values of graphs take, so that an untrusted graph file cannot fill the machine."""

from __future__ import annotations

from . import limits

SMALL = 2**12
"""Values of at most this many bytes are not counted."""


class Room:
    """Counts the bytes of the large values that nodes hold now."""

    def __init__(self, most: int | None = None) -> None:
        self.most = limits.most("graph.bytes") if most is None else most
        self._held: dict[str, int] = {}
        self._total = 0

    def claim(self, owner: str, size: int) -> str | None:
        """Records that a node is about to hold `size` bytes instead of its last value.

        Returns an error message, and leaves the former record, if that is over the limit.
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
