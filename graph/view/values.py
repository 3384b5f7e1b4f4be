"""Numbers of messages over time: the scalar fields of odometry, imu, joint states, twists and other small types."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field
from typing import Any

MOST_FIELDS = 12
MOST_POINTS = 2_000
LONGEST = 16
"""Elements of a list up to which each is a line of its own."""
SKIPPED = ("header:", "covariance", "child_frame_id")


@dataclass(slots=True)
class Series:
    """The numbers of one topic: times [s] and, for each name, a value at each time."""

    topic: str
    names: list[str] = field(default_factory=list)
    times: array[float] = field(default_factory=lambda: array("d"))
    columns: list[array[float]] = field(default_factory=list)

    def add(self, stamp_ns: int, type_name: str, message: Any) -> None:
        """Takes the numbers of a message; those of lists by their first elements."""
        found = dict(_numbers(type_name, message))
        if not self.names:
            self.names = list(found)[:MOST_FIELDS]
            self.columns = [array("d") for _ in self.names]
        self.times.append(stamp_ns / 1e9)
        for name, column in zip(self.names, self.columns, strict=True):
            column.append(found.get(name, float("nan")))

    def data(self) -> dict[str, Any]:
        """What the page's script draws: fields whose value never is other than 0 are left out."""
        lines = [
            {"name": name, "y": [None if one != one else float(f"{one:.7g}") for one in column]}
            for name, column in zip(self.names, self.columns, strict=True)
            if any(column)
        ]
        return {"topic": self.topic, "t": [round(one, 9) for one in self.times], "lines": lines}


def _numbers(type_name: str, message: Any) -> list[tuple[str, float]]:
    from graph.sim.messages.ros_fields import leaves, unpack

    found: list[tuple[str, float]] = []
    names = [leaf.name for leaf in leaves(type_name)]
    values = unpack(type_name, message)
    labels = _labels(names, values)
    for name, value in zip(names, values, strict=True):
        if name.startswith(SKIPPED) or name.endswith(SKIPPED) or isinstance(value, str):
            continue
        items = value.tolist() if hasattr(value, "tolist") else value
        if isinstance(items, (bool, int, float)):
            found.append((name.replace(":", "."), float(items)))
        elif isinstance(items, list) and len(items) <= LONGEST and all(isinstance(one, (int, float)) for one in items):
            said = labels if len(labels) == len(items) else [str(place) for place in range(len(items))]
            found += [
                (f"{name.replace(':', '.')}[{label}]", float(one)) for label, one in zip(said, items, strict=True)
            ]
    return found


def _labels(names: list[str], values: list[Any]) -> list[str]:
    """The names of a message's own list `name`, as joint states have them."""
    given = values[names.index("name")] if "name" in names else None
    return [str(one) for one in given] if isinstance(given, (list, tuple)) else []
