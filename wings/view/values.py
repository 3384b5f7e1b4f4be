"""Numbers of messages over time, by quantity: one plot has one unit, such as the angular velocities of an imu."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from math import isfinite, nan
from typing import Any

MOST_LINES = 12
"""Lines of a quantity."""
MOST_QUANTITIES = 10
MOST_POINTS = 2_000
LONGEST = 16
"""Elements of a list up to which each is a line of its own."""
SKIPPED = ("header:", "covariance", "child_frame_id")
AXES = ("x", "y", "z", "w")
SAMPLED = ("Odometry", "Imu", "JointState", "Pose", "Wrench", "Accel", "NavSatFix", "MagneticField", "Transform")
"""Beginnings of types that sample something continuous; the values of all others hold until the next message."""
COMMANDS = ("command", "cmd", "target", "setpoint")
"""Parts of a topic's name whose values hold, whatever their type."""
UNITS = {
    "position": "m",
    "translation": "m",
    "linear": "m/s",
    "angular": "rad/s",
    "linear_acceleration": "m/s²",
    "angular_velocity": "rad/s",
    "force": "N",
    "torque": "N m",
    "steering_angle": "rad",
    "steering_angle_velocity": "rad/s",
    "speed": "m/s",
    "acceleration": "m/s²",
    "jerk": "m/s³",
    "range": "m",
    "min_range": "m",
    "max_range": "m",
    "field_of_view": "rad",
    "latitude": "°",
    "longitude": "°",
    "altitude": "m",
    "magnetic_field": "T",
    "fluid_pressure": "Pa",
    "temperature": "°C",
}
"""Last part of a quantity's name -> unit in ROS messages (REP 103 and the comments of the types)."""
OF_TYPE = {
    "JointState": {"position": "rad or m", "velocity": "rad/s or m/s", "effort": "N m or N"},
    "Accel": {"linear": "m/s²", "angular": "rad/s²"},
}
"""Units that differ by the type, by the beginning of its name."""


@dataclass(slots=True)
class Series:
    """The numbers of one topic: times [s] and, by quantity and name, a value at each time."""

    topic: str
    type_name: str = ""
    times: array[float] = field(default_factory=lambda: array("d"))
    columns: dict[str, dict[str, array[float]]] = field(default_factory=dict)

    def add(self, stamp_ns: int, type_name: str, message: Any) -> None:
        """Takes the numbers of a message; those of lists by their first elements."""
        self.type_name = type_name
        for quantity, name, value in _numbers(type_name, message):
            lines = self.columns.setdefault(quantity, {})
            if name not in lines:
                lines[name] = array("d", [nan]) * len(self.times)
            lines[name].append(value)
        self.times.append(stamp_ns / 1e9)
        for lines in self.columns.values():
            for column in lines.values():
                if len(column) < len(self.times):
                    column.append(nan)

    def data(self) -> dict[str, Any]:
        """What the page's script draws, by quantity: lines whose value is always 0 are left out."""
        short = self.type_name.rpartition("/")[2]
        named = any(one in self.topic.lower() for one in COMMANDS)
        found = []
        for quantity, columns in self.columns.items():
            unit = self._unit(short, quantity)
            if tuple(columns) == AXES:
                quantity, unit, columns = f"{quantity}: roll, pitch, yaw", "°", _angles(columns)
            lines = [
                {"name": name, "y": [float(f"{one:.7g}") if isfinite(one) else None for one in column]}
                for name, column in columns.items()
                if any(one and isfinite(one) for one in column)
            ]
            if lines:
                more = len(lines) - MOST_LINES
                found.append({"name": quantity, "unit": unit, "lines": lines[:MOST_LINES], "more": max(0, more)})
        return {
            "topic": self.topic,
            "holds": named or not short.startswith(SAMPLED),
            "t": [round(one, 9) for one in self.times],
            "quantities": found[:MOST_QUANTITIES],
        }

    @staticmethod
    def _unit(short: str, quantity: str) -> str:
        last = quantity.rpartition(".")[2]
        own = next((units for start, units in OF_TYPE.items() if short.startswith(start)), {})
        return own.get(last, UNITS.get(last, ""))


def _angles(columns: dict[str, array[float]]) -> dict[str, Any]:
    """Quaternions x, y, z, w as roll, pitch and yaw [deg]."""
    import numpy as np

    x, y, z, w = (np.frombuffer(columns[axis]) for axis in AXES)
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1, 1))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return {"roll": np.degrees(roll), "pitch": np.degrees(pitch), "yaw": np.degrees(yaw)}


def _numbers(type_name: str, message: Any) -> Iterator[tuple[str, str, float]]:
    """(quantity, name, value) of each number: those of a vector or a list are one quantity."""
    from graph.sim.messages.ros_fields import leaves, unpack

    names = [leaf.name for leaf in leaves(type_name)]
    values = unpack(type_name, message)
    labels = _labels(names, values)
    for path, value in zip(names, values, strict=True):
        if path.startswith(SKIPPED) or path.endswith(SKIPPED) or isinstance(value, str):
            continue
        whole = path.replace(":", ".")
        items = value.tolist() if hasattr(value, "tolist") else value
        if isinstance(items, (bool, int, float)):
            above, _, last = whole.rpartition(".")
            yield (above, last, float(items)) if last in AXES and above else (whole, last, float(items))
        elif isinstance(items, list) and len(items) <= LONGEST and all(isinstance(one, (int, float)) for one in items):
            said = labels if len(labels) == len(items) else [str(place) for place in range(len(items))]
            for label, one in zip(said, items, strict=True):
                yield whole, label, float(one)


def _labels(names: list[str], values: list[Any]) -> list[str]:
    """The names of a message's own list `name`, as joint states have them."""
    given = values[names.index("name")] if "name" in names else None
    return [str(one) for one in given] if isinstance(given, (list, tuple)) else []
