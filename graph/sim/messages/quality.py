"""Quality of service: the offer of a publisher, as ROS 2 records it beside a topic."""

from __future__ import annotations

from graph.base.records import dataclass

# Numbers of rmw/types.h, which every rosbag2 since Foxy can read (it cannot read the newer words).
_HISTORY = {"systemDefault": 0, "keepLast": 1, "keepAll": 2, "unknown": 3}
_RELIABILITY = {"systemDefault": 0, "reliable": 1, "bestEffort": 2, "unknown": 3}
_DURABILITY = {"systemDefault": 0, "transientLocal": 1, "volatile": 2, "unknown": 3}
_LIVELINESS = {"systemDefault": 0, "automatic": 1, "manualByTopic": 3, "unknown": 4}
_INFINITE = 2**63 - 1
"""Nanoseconds that mean "no limit" (RMW_DURATION_INFINITE)."""


@dataclass(frozen=True, slots=True)
class Quality:
    """A quality of service profile in the words of ROS2QoSProfile; times in nanoseconds, 0 means no limit."""

    history: str = "keepLast"
    depth: int = 10
    reliability: str = "reliable"
    durability: str = "volatile"
    deadline_ns: int = 0
    lifespan_ns: int = 0
    liveliness: str = "systemDefault"
    lease_ns: int = 0

    def as_yaml(self) -> str:
        """The list of one profile that rosbag2 stores as `offered_qos_profiles`."""
        return (
            f"- history: {_HISTORY.get(self.history, 3)}\n"
            f"  depth: {self.depth}\n"
            f"  reliability: {_RELIABILITY.get(self.reliability, 3)}\n"
            f"  durability: {_DURABILITY.get(self.durability, 3)}\n"
            f"  deadline:\n{_time(self.deadline_ns)}"
            f"  lifespan:\n{_time(self.lifespan_ns)}"
            f"  liveliness: {_LIVELINESS.get(self.liveliness, 4)}\n"
            f"  liveliness_lease_duration:\n{_time(self.lease_ns)}"
            "  avoid_ros_namespace_conventions: false\n"
        )


DEFAULT = Quality()


def _time(nanoseconds: int) -> str:
    seconds, rest = divmod(nanoseconds or _INFINITE, 10**9)
    return f"    sec: {seconds}\n    nsec: {rest}\n"
