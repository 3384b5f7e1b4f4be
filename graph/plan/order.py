"""The dependency order of nodes, and the cycles that prevent it."""

from __future__ import annotations

import heapq
from collections.abc import Sequence


def dependency_order(count: int, readers: Sequence[Sequence[int]]) -> list[int]:
    """Orders the nodes 0 .. count-1 so that every node precedes its readers; ties go to the lowest number.

    Nodes on a cycle, and those behind one, are left out.
    """
    waiting = [0] * count
    for targets in readers:
        for target in targets:
            waiting[target] += 1
    ready = [node for node in range(count) if not waiting[node]]
    order = []
    while ready:
        node = heapq.heappop(ready)
        order.append(node)
        for target in readers[node]:
            waiting[target] -= 1
            if not waiting[target]:
                heapq.heappush(ready, target)
    return order


def cycles(count: int, readers: Sequence[Sequence[int]], *, most: int) -> list[list[int]]:
    """At most `most` cycles without a common node, each as nodes in the direction of the data."""
    found: list[list[int]] = []
    removed: set[int] = set()
    while True:
        kept = [[target for target in targets if target not in removed] for targets in readers]
        for node in removed:
            kept[node] = []
        left = set(range(count)) - set(dependency_order(count, kept)) - removed
        if not left or len(found) == most:
            return found
        # Every remaining node waits for another remaining node, so going upstream must return to a visited one.
        upstream: dict[int, int] = {}
        for node in sorted(left):
            for target in kept[node]:
                if target in left:
                    upstream.setdefault(target, node)
        node, seen = min(left), dict[int, int]()
        while node not in seen:
            seen[node] = len(seen)
            node = upstream[node]
        round_ = list(seen)[seen[node] :][::-1]
        start = round_.index(min(round_))
        found.append(round_[start:] + round_[:start])
        removed.update(round_)
