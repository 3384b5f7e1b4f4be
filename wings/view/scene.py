"""What is drawn together: the clouds of one sensor in one panel, and everything that transforms place in one scene."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .collecting import Collected


def cloud_groups(found: Collected, prims: Mapping[str, str]) -> list[dict[str, Any]]:
    """The clouds by sensor: those of its prim (by topic), and those in its frame of which no prim is known."""
    keys = {name: prims.get(name, "") for name in found.clouds}
    of_frame: dict[str, set[str]] = {}
    for name, panel in found.clouds.items():
        if keys[name]:
            of_frame.setdefault(panel.sensor, set()).add(keys[name])
    groups: dict[str, dict[str, Any]] = {}
    for number, (name, panel) in enumerate(found.clouds.items()):
        owners = of_frame.get(panel.sensor, set())
        key = keys[name] or (next(iter(owners)) if len(owners) == 1 else f"frame {panel.sensor}")
        group = groups.setdefault(key, {"name": panel.sensor or name, "clouds": [], "topics": [], "flat": True})
        group["clouds"].append(number)
        group["topics"].append(name)
        group["flat"] &= panel.is_flat()
    return list(groups.values())


def scene(found: Collected, numbers: Sequence[int]) -> dict[str, Any] | None:
    """What the scene spans: the clouds (numbers), frames and boxes in the frame of most of them.

    None without any, and if frames that stand still are all.
    low, high: without the farthest fiftieths of the points. base: the frame that moves and carries most others.
    reach: how far those are from it [m].
    """
    panels = list(found.clouds.values())
    roots = Counter([panels[number].frame for number in numbers if panels[number].bounds() is not None])
    roots.update({pose["root"] for pose in found.poses})
    roots.update(box["root"] for shown in found.boxes.values() for box in shown[:1])
    moving = any(pose["moves"] for pose in found.poses)
    if not (roots and (moving or found.boxes or found.clouds)):
        return None
    root = roots.most_common(1)[0][0]
    shown = [number for number in numbers if panels[number].frame == root and panels[number].bounds() is not None]
    poses = [pose for pose in found.poses if pose["root"] == root]
    corners = [
        np.reshape(box["corners"], (-1, 3)) for topic in found.boxes.values() for box in topic if box["root"] == root
    ]
    spans = [panels[number].inner() for number in shown]
    spans += [np.asarray(pose["places"]) for pose in poses] + corners
    spans = [one for one in spans if len(one)]  # a message may hold no box
    if not spans:
        return None
    low = np.min([one.min(axis=0) for one in spans], axis=0)
    high = np.max([one.max(axis=0) for one in spans], axis=0)
    margin = np.maximum(0.03 * (high - low).max(), 0.5)
    base, reach = _base(poses, root)
    return {
        "root": root,
        "clouds": shown,
        "low": (low - margin * np.array([1.0, 1.0, 0.3])).round(3).tolist(),
        "high": (high + margin).round(3).tolist(),
        "base": base,
        "reach": reach,
    }


def _base(poses: Sequence[Mapping[str, Any]], root: str) -> tuple[str, float]:
    parents = {pose["name"]: pose["parent"] for pose in poses}
    carried: dict[str, list[Mapping[str, Any]]] = {}
    for pose in poses:
        top = pose["name"]
        while (above := parents.get(top, root)) != root:
            top = above
        carried.setdefault(top, []).append(pose)
    moving = {pose["name"] for pose in poses if pose["moves"]}
    base = max((name for name in carried if name in moving), key=lambda name: len(carried[name]), default="")
    if not base:
        return "", 0.0
    firsts = np.array([pose["places"][0] for pose in carried[base]])
    return base, float(np.linalg.norm(firsts - firsts[0], axis=1).max())
