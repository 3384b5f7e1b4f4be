"""Errors of what sensors saw: readings of a run against those of the reference, matched by identity.

Each function takes the pairs (run, reference) of frames of all sensors of its kind, only those before the horizon.
Ranges are compared where both lidars turn at the same rate with the same rays; ranges and depths where both runs see
the same prim: beside an edge a ray that is off by a hair is off by metres, which is counted (lost and extra returns,
changed pixels) and not measured.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensors.camera.channels import INSTANCE

from .readings import CAMERA, LIDAR, RADAR, Reading, Readings

Values = dict[str, float | None]
Array = NDArray[Any]


def values_of(run: Mapping[str, Readings], reference: Mapping[str, Readings], horizon: float) -> Values:
    """Every metric of sensors that the reference has readings for."""
    found: Values = {}
    pairs = [(run.get(path, Readings(one.path, one.kind)), one) for path, one in sorted(reference.items())]
    for kind, measure in ((LIDAR, _lidars), (RADAR, _radars), (CAMERA, _cameras)):
        chosen = [(a, b) for a, b in pairs if b.kind == kind and b.before(horizon)]
        if chosen:
            found |= measure(chosen, horizon)
    seen = [(a.before(horizon), b.before(horizon)) for a, b in pairs if b.before(horizon)]
    if seen:
        found |= _frames(seen)
    return found


def _lidars(pairs: Sequence[tuple[Readings, Readings]], horizon: float) -> Values:
    ranges: list[Array] = []
    scalars: list[Array] = []
    radials: list[Array] = []
    total = lost = extra = 0
    for run, reference in pairs:
        if run.frames and run.pattern != reference.pattern:
            continue
        one, two = _joined(run.before(horizon)), _joined(reference.before(horizon))
        _, mine, theirs = np.intersect1d(one["firing"], two["firing"], return_indices=True)
        same = one["prim"][mine] == two["prim"][theirs]
        mine, theirs = mine[same], theirs[same]
        total += len(two["firing"])
        lost += len(two["firing"]) - len(theirs)
        extra += len(one["firing"]) - len(mine)
        ranges.append(_apart(one, two, "distance", mine, theirs))
        scalars.append(_apart(one, two, "scalar", mine, theirs))
        radials.append(_apart(one, two, "radial", mine, theirs))
    found = {f"lidar.range_{name}": value for name, value in _percentiles(ranges).items()}
    found |= {"lidar.lost": lost / total, "lidar.extra": extra / total} if total else {}
    found["lidar.intensity_p99"] = _percentiles(scalars)["p99"]
    found["lidar.velocity_p99"] = _percentiles(radials)["p99"]
    return found


def _joined(frames: Sequence[Reading]) -> dict[str, Array]:
    empty: dict[str, Array] = {"firing": np.zeros(0, np.int64), "distance": np.zeros(0), "scalar": np.zeros(0)}
    empty["prim"] = empty["firing"]
    names = set.intersection(*(set(frame.arrays) for frame in frames)) if frames else set(empty)
    return {name: np.concatenate([frame.arrays[name] for frame in frames]) if frames else empty[name] for name in names}


def _apart(
    one: Mapping[str, Array], two: Mapping[str, Array], name: str, mine: NDArray[np.intp], theirs: NDArray[np.intp]
) -> Array:
    """The differences of a channel between matched readings; empty if one of the runs has no such channel."""
    if name not in one or name not in two:
        return np.zeros(0)
    apart: Array = np.abs(one[name][mine].astype(np.float64) - two[name][theirs])
    return apart


def _cameras(pairs: Sequence[tuple[Readings, Readings]], horizon: float) -> Values:
    depths: list[Array] = []
    colours: list[Array] = []
    changed = total = 0
    for run, reference in pairs:
        for one, two in _matched(run.before(horizon), reference.before(horizon)):
            mine, theirs = one.arrays["distance_to_image_plane"], two.arrays["distance_to_image_plane"]
            if mine.shape != theirs.shape:
                continue
            same = one.arrays[INSTANCE] == two.arrays[INSTANCE]
            both = same & np.isfinite(mine) & np.isfinite(theirs)
            depths.append(np.abs(mine[both].astype(np.float64) - theirs[both]))
            changed += int((~same).sum())
            total += mine.size
            if "rgb" in one.arrays and "rgb" in two.arrays:
                levels = one.arrays["rgb"][..., :3].astype(np.float64) - two.arrays["rgb"][..., :3]
                colours.append((levels / 255) ** 2)
    found: Values = {f"camera.depth_{name}": value for name, value in _percentiles(depths).items()}
    found["camera.changed"] = changed / total if total else None
    found["camera.colour_rms"] = (
        float(np.sqrt(np.concatenate([c.ravel() for c in colours]).mean())) if colours else None
    )
    return found


def _radars(pairs: Sequence[tuple[Readings, Readings]], horizon: float) -> Values:
    detected = found = wanted = 0
    speeds: list[Array] = []
    for run, reference in pairs:
        for one, two in _matched(run.before(horizon), reference.before(horizon)):
            mine, theirs = same_targets(one.arrays, two.arrays, reference.gates)
            detected += len(one.arrays["distance"])
            wanted += len(two.arrays["distance"])
            found += len(mine)
            speeds.append(np.abs(one.arrays["rv_ms"][mine].astype(np.float64) - two.arrays["rv_ms"][theirs]))
    return {
        "radar.recall": found / wanted if wanted else None,
        "radar.false_alarms": (detected - found) / detected if detected else (0.0 if wanted else None),
        "radar.velocity_p99": _percentiles(speeds)["p99"],
    }


def same_targets(
    one: Mapping[str, Array], two: Mapping[str, Array], gates: tuple[float, float, float]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows of detections of the same target: at most a cell apart along each axis, the nearest first, each once."""
    table = [
        np.abs(one[name].astype(np.float64)[:, None] - two[name][None]) / (gate * 1.01)
        for name, gate in zip(("distance", "rv_ms", "azimuth"), (*gates[:2], float(np.rad2deg(gates[2]))), strict=True)
    ]
    cells = np.maximum.reduce(table)
    order = np.argsort(cells, axis=None, kind="stable")
    mine: list[int] = []
    theirs: list[int] = []
    for place in order[: int((cells <= 1.0).sum())]:
        row, column = divmod(int(place), cells.shape[1])
        if row not in mine and column not in theirs:
            mine.append(row)
            theirs.append(column)
    return np.array(mine, np.intp), np.array(theirs, np.intp)


def _frames(pairs: Sequence[tuple[Sequence[Reading], Sequence[Reading]]]) -> Values:
    missing, total, late = 0, 0, 0
    for run, reference in pairs:
        matched = _matched(run, reference)
        total += len(reference)
        missing += len(reference) - len(matched)
        late = max([late, *(abs(one.stamp_ns - two.stamp_ns) for one, two in matched)])
    return {"frames.missing": missing / total, "frames.stamp_max": late / 1e9}


def _matched(run: Sequence[Reading], reference: Sequence[Reading]) -> list[tuple[Reading, Reading]]:
    mine = {frame.key: frame for frame in run}
    return [(mine[frame.key], frame) for frame in reference if frame.key in mine]


def _percentiles(differences: Sequence[Array]) -> Values:
    """The median, the 99th percentile and the largest; None without values."""
    whole = np.concatenate([one.ravel() for one in differences]) if differences else np.zeros(0)
    if not len(whole):
        return {"p50": None, "p99": None, "max": None}
    half, high = np.percentile(whole, [50, 99])
    return {"p50": float(half), "p99": float(high), "max": float(whole.max())}
