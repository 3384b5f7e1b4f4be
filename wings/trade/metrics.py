"""Every metric of a trade by its stable name: unit, meaning, and which way it is better.

Errors are differences from the reference; the two of `contact` are those of a run alone. Costs are per simulated
second, medians over the timed runs.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from graph.base.suggest import did_you_mean
from graph.session.meter import PARTS


@dataclass(frozen=True, slots=True)
class Metric:
    """unit: "" for shares from 0 to 1. needs: what a scene must have to give it. more: whether more of it is better.

    alone: whether it is that of a run alone and no difference from the reference.
    """

    unit: str
    doc: str
    needs: str
    more: bool = False
    alone: bool = False

    def error(self, value: float) -> float:
        """The value as an error, which is better the smaller it is."""
        return 1.0 - value if self.more else value


_BODIES, _CONTACTS = "a body that moves", "a body that moves and touches something"
_DEVICE = "`device` among what is varied, and a body that moves"
_FAST = "a body that moves faster than 0.1 m/s"
_LIDAR, _RADAR, _CAMERA, _ANY = (
    f"{what} that something in the graphs reads" for what in ("a lidar", "a radar", "a camera", "a sensor")
)

ERRORS: dict[str, Metric] = {
    "body.position_max": Metric("m", "largest distance of a body from its place in the reference", _BODIES),
    "body.position_rms": Metric(
        "m", "distance of bodies from their places, root mean square over bodies and time", _BODIES
    ),
    "body.position_final": Metric("m", "largest distance of a body from its place at the end", _BODIES),
    "body.orientation_max": Metric("rad", "largest angle between a body and itself in the reference", _BODIES),
    "body.orientation_rms": Metric(
        "rad", "angle between bodies and themselves, root mean square over bodies and time", _BODIES
    ),
    "body.orientation_final": Metric("rad", "largest angle between a body and itself at the end", _BODIES),
    "body.energy_drift": Metric("", "difference of the whole energy, in the largest kinetic energy", _FAST),
    "body.momentum_drift": Metric("", "difference of the whole momentum, in the largest sum of momenta", _FAST),
    "body.spin_drift": Metric("", "difference of the whole angular momentum, in the largest sum of them", _FAST),
    "contact.penetration_max": Metric("m", "deepest contact of the run itself", _BODIES, alone=True),
    "contact.creep_max": Metric(
        "m/s", "speed of bodies that rest in the reference, second half", _CONTACTS, alone=True
    ),
    "float32.position_max": Metric(
        "m",
        "the run's physics in float32 on its device against MuJoCo's: largest distance of a body",
        _DEVICE,
        alone=True,
    ),
    "float32.position_final": Metric("m", "the same at the end", _DEVICE, alone=True),
    "float32.orientation_max": Metric("rad", "the same: largest angle of a body", _DEVICE, alone=True),
    "float32.joint_max": Metric("rad", "the same: largest of a joint (slides: m)", f"{_DEVICE} on a joint", alone=True),
    "lidar.range_p50": Metric("m", "difference of the range of a return of the same firing and prim: median", _LIDAR),
    "lidar.range_p99": Metric("m", "difference of the range of a return, 99th percentile", _LIDAR),
    "lidar.range_max": Metric("m", "difference of the range of a return, largest", _LIDAR),
    "lidar.lost": Metric("", "returns of the reference that the run does not have, or has from another prim", _LIDAR),
    "lidar.extra": Metric(
        "", "returns that only the run has, or has from another prim, in those of the reference", _LIDAR
    ),
    "lidar.intensity_p99": Metric("", "difference of the intensity of a return, 99th percentile", _LIDAR),
    "lidar.velocity_p99": Metric(
        "m/s", "difference of the velocity along the beam, 99th percentile", f"{_LIDAR} with its velocities"
    ),
    "radar.recall": Metric("", "detections of the reference that the run has within a cell", _RADAR, more=True),
    "radar.false_alarms": Metric("", "detections that only the run has, in all of its own", _RADAR),
    "radar.velocity_p99": Metric("m/s", "difference of the velocity of a detection, 99th percentile", _RADAR),
    "camera.depth_p50": Metric("m", "difference of the depth of a pixel that shows the same prim: median", _CAMERA),
    "camera.depth_p99": Metric("m", "difference of the depth of a pixel, 99th percentile", _CAMERA),
    "camera.depth_max": Metric("m", "difference of the depth of a pixel, largest", _CAMERA),
    "camera.changed": Metric("", "pixels that show another prim than in the reference", _CAMERA),
    "camera.colour_rms": Metric("", "difference of the colours of a pixel, root mean square", f"{_CAMERA} in colour"),
    "frames.missing": Metric("", "frames of the reference that the run does not have", _ANY),
    "frames.stamp_max": Metric("s", "largest difference of the stamps of the same frame", _ANY),
}

COSTS: dict[str, Metric] = {
    "cost.wall": Metric("s/s", "wall time of updates per simulated second", "a run"),
    "cost.cpu": Metric("s/s", "processor time of updates, all threads, per simulated second", "a run"),
    **{f"cost.{name}": Metric("s/s", f"wall time of {doc}", "a run") for name, doc in PARTS.items()},
    "cost.frames": Metric("1/s", "frames of all sensors per simulated second", "a run"),
    "cost.start": Metric("s", "wall time from opening the file to the first frame of each sensor", "a run"),
}

METRICS: dict[str, Metric] = {**ERRORS, **COSTS}

LEADING = (
    "lidar.range_p99",
    "body.position_max",
    "float32.position_max",
    "camera.depth_p99",
    "radar.recall",
    "contact.creep_max",
    "body.energy_drift",
    "camera.colour_rms",
    "frames.stamp_max",
)
"""Metrics that are shown first, where they differ between settings."""


def ranking(budget: Iterable[str]) -> list[str]:
    """The differences from a reference by which it is judged how well a setting converges, the first that counts first.

    Those of the budget, then the place of bodies, then the leading ones.
    """
    order = dict.fromkeys((*budget, "body.position_max", *LEADING, *ERRORS))
    return [name for name in order if name in ERRORS and not ERRORS[name].alone]


def known_metric(name: str) -> Metric:
    """The metric of that name. Raises ValueError with the nearest one."""
    if name not in METRICS:
        raise ValueError(f"there is no such metric{did_you_mean(name, METRICS) or '; graph trade --list lists them'}")
    return METRICS[name]
