"""Point clouds for the page: places in steps of a 65,535th of the scene, values to colour them by in 255 steps."""

from __future__ import annotations

import base64
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.recording.contents.poses import FARTHEST
from graph.recording.contents.scans import Scan
from graph.sim.transforms import Floats
from sensors.writers.palette import indices


def chosen(count: int, most: int) -> tuple[int, ...]:
    """At most `most` numbers from 0 to count - 1, evenly spread, with the first and the last."""
    if count <= most:
        return tuple(range(count))
    if most < 2:
        return (count - 1,) if most == 1 else ()
    return tuple(round(place * (count - 1) / (most - 1)) for place in range(most))


def some(count: int, most: int) -> NDArray[np.int64]:
    """At most `most` numbers from 0 to count - 1 in order, drawn at random: every second could be half of the rings."""
    if count <= most:
        return np.arange(count)
    found: NDArray[np.int64] = np.sort(np.random.default_rng(count).choice(count, most, replace=False))
    return found


LABELS = ("ring", "channel", "class_id", "label", "object_id", "semantic")
"""Beginnings of fields that count or name something, so that their colours span all values."""
PARTS = ("x", "y", "z", "time", "t", "timestamp")
"""Fields that say where and when, not what."""
UNITS = {"radial_velocity_ms": "m/s", "vx": "m/s", "vy": "m/s", "vz": "m/s", "rcs": "dBsm", "snr": "dB"}
"""Of fields, where there is one."""
FLAT_DEG = 2.0
"""Elevations that a scan spans at most if all its points are in one plane of the sensor."""


@dataclass(slots=True)
class CloudFrame:
    """One cloud: places (n, 3) in the panel's frame and local (n, 3) in the sensor's [m], values (n,) by name.

    total: the points of the message. pose: (4, 4) of the sensor in the panel's frame.
    """

    stamp_ns: int
    places: Floats
    local: Floats
    values: dict[str, NDArray[Any]]
    total: int
    pose: Floats


@dataclass(slots=True)
class CloudPanel:
    """The clouds of a topic that the page shows; frame: the name of the coordinates that they are in."""

    topic: str
    sensor: str = ""
    """The frame of the sensor."""
    frame: str = ""
    frames: list[CloudFrame] = field(default_factory=list)

    def add(self, scan: Scan, root: str, most: int) -> None:
        """Takes a scan, at most about `most` of its points; in the root frame where the recording says its pose."""
        thin = some(len(scan.points), most)
        world = scan.in_world()
        local = _local(scan)
        self.sensor, self.frame = scan.frame_id, root if world is not None else scan.frame_id
        places = (local if world is None else world)[thin]
        values: dict[str, NDArray[Any]] = {"range [m]": np.linalg.norm(local, axis=1)[thin], "height [m]": places[:, 2]}
        for name in scan.points.dtype.names or ():
            if not name.startswith(("x_", "y_", "z_", "timestamp")) and name not in PARTS:
                values[name] = scan.points[name][thin].astype(np.float64)
        good = (np.abs(places) < FARTHEST).all(axis=1)
        self.frames.append(
            CloudFrame(
                scan.stamp_ns,
                places[good],
                local[thin][good],
                {k: v[good] for k, v in values.items()},
                len(scan.points),
                np.eye(4) if scan.pose is None else scan.pose,
            )
        )

    def bounds(self) -> tuple[Floats, Floats] | None:
        """The lowest and the highest coordinates (3,) of all shown points; None without a point."""
        full = [one.places for one in self.frames if len(one.places)]
        if not full:
            return None
        return np.min([one.min(axis=0) for one in full], axis=0), np.max([one.max(axis=0) for one in full], axis=0)

    def span(self) -> tuple[Floats, Floats] | None:
        """The bounds of points and sensor; None without a point."""
        found = self.bounds()
        if found is None:
            return None
        at = np.array([one.pose[:3, 3] for one in self.frames])
        flat = np.array([1.0, 1.0, 0.0])  # colours are of the points' heights
        low, high = (np.where(flat > 0, side, ends) for side, ends in zip((at.min(0), at.max(0)), found, strict=True))
        return np.minimum(found[0], low), np.maximum(found[1], high)

    def inner(self) -> Floats:
        """(2, 3) the coordinates between which all but the farthest fiftieths of the points are, at each end."""
        found: Floats = np.percentile(np.concatenate([one.places for one in self.frames]), (2, 98), axis=0)
        return found

    def is_flat(self) -> bool:
        """Whether all points of each frame are in one plane through the sensor, its x and y."""
        spans = [
            float(np.ptp(np.percentile(_elevations(one.local), (0.5, 99.5)))) for one in self.frames if len(one.local)
        ]
        return bool(spans and max(spans) < FLAT_DEG)

    def data(self) -> dict[str, Any]:
        """What the page's script draws; places and colours as base64."""
        flat = self.is_flat()
        full = [one for one in self.frames if len(one.places)]
        low, high = self.bounds() or (np.zeros(3), np.ones(3))
        steps = np.maximum((high - low) / 65535, 1e-6)
        names = [name for name in (full[0].values if full else ()) if all(name in one.values for one in full)]
        ranges = {name: _bounds(name, [one.values[name] for one in full]) for name in names}
        return {
            "topic": self.topic,
            "frame": self.frame,
            "sensor": self.sensor,
            "flat": flat,
            "low": low.tolist(),
            "steps": steps.tolist(),
            "fields": [{"name": titled(name), "low": ranges[name][0], "high": ranges[name][1]} for name in names],
            "frames": [
                {
                    "t": one.stamp_ns / 1e9,
                    "total": one.total,
                    "places": _text(np.round((one.places - low) / steps).astype("<u2")),
                    "colours": [_text(indices(one.values[name], *ranges[name])) for name in names]
                    if len(one.places)
                    else [_text(np.zeros(0, np.uint8)) for _ in names],
                    **({"local": _text(one.local[:, :2].astype("<f4"))} if flat else {}),
                }
                for one in sorted(self.frames, key=lambda one: one.stamp_ns)
            ],
        }


def titled(name: str) -> str:
    """A field's name with its unit, where it has one."""
    return f"{name} [{UNITS[name]}]" if name in UNITS else name


def _elevations(local: Floats) -> Floats:
    """Of points in the sensor's frame [deg]."""
    found: Floats = np.degrees(np.arctan2(local[:, 2], np.hypot(local[:, 0], local[:, 1])))
    return found


def _local(scan: Scan) -> Floats:
    return np.stack([scan.points["x"], scan.points["y"], scan.points["z"]], axis=1).astype(np.float64)


def _bounds(name: str, values: list[NDArray[Any]]) -> tuple[float, float]:
    """The values between which colours differ: all of them for labels, else without the most extreme hundredth."""
    flat = np.concatenate(values)
    flat = flat[np.isfinite(flat)]
    if not len(flat):
        return 0.0, 1.0
    ends = (0, 100) if name.lower().startswith(LABELS) else (1, 99)
    low, high = (float(one) for one in np.percentile(flat, ends))
    return (low, high) if high > low else (low - 0.5, low + 0.5)


def _text(array: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode()
