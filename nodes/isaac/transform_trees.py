"""The transforms to publish for a set of prims: links of articulations have their parent links as parents."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from graph.base.records import dataclass
from graph.sim.scene.mechanisms import mechanisms_of
from graph.sim.scene.prim_paths import NAME_OVERRIDE

WORLD = "world"
SITE = "IsaacSiteAPI"


@dataclass(frozen=True, slots=True)
class FrameTransform:
    """The pose of frame `child` in frame `parent`: translation x, y, z [m] and rotation quaternion x, y, z, w."""

    parent: str
    child: str
    translation: tuple[float, float, float]
    rotation: tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Edge:
    """A transform to publish: prim paths (parent "" is the world), frame names, and which of the two are cameras.

    The frame of a camera is optical as in ROS: x right, y down, z ahead (a USD camera has y up and looks along -z).
    """

    parent: str
    child: str
    parent_frame: str
    child_frame: str
    from_camera: bool = False
    to_camera: bool = False


def edges_of(stage: Any, parent: str, targets: Iterable[str], *, keep_parent: bool = False) -> list[Edge]:
    """The transforms of `targets` below `parent` ("" is the world).

    A target that is the root of an articulation (`Mechanisms.standing_for`) means all its links: the parent of the root
    link is `parent`, that of every other link is the link that its joint connects it to; prims with IsaacSiteAPI below
    a link are frames in it. The parent of any other target is `parent`. The parent as its own target is left out,
    unless `keep_parent` asks for its identity.
    """
    mechanisms = mechanisms_of(stage)
    pairs: dict[str, str] = {}
    for target in targets:
        links = mechanisms.standing_for(target) or {}
        for child, parent_link in (links or {target: ""}).items():
            if child != parent or (keep_parent and child == target):
                pairs.setdefault(child, parent_link or parent)
        for site, link in _sites_of(stage, links):
            pairs.setdefault(site, link)
    names = _frame_names(stage, [parent, *pairs.values(), *pairs])
    cameras = {path for path in names if path and _is_camera(stage.GetPrimAtPath(path))}
    return [
        Edge(above, child, names[above], names[child], above in cameras, child in cameras)
        for child, above in pairs.items()
    ]


def _sites_of(stage: Any, links: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """The sites below links, each with its link: places that robot schemas mark, such as the mount of a sensor."""
    from graph.sim.usd import Usd

    for link in links:
        prims = iter(Usd.PrimRange(stage.GetPrimAtPath(link)))
        for prim in prims:
            path = str(prim.GetPath())
            if path != link and path in links:
                prims.PruneChildren()
            elif SITE in map(str, prim.GetPrimTypeInfo().GetAppliedAPISchemas()):
                yield path, link


def _is_camera(prim: Any) -> bool:
    """Whether it looks along -Z; a lidar that is stored as a camera measures along +X, as other lidars do."""
    from graph.sim.usd import UsdGeom

    applied = map(str, prim.GetPrimTypeInfo().GetAppliedAPISchemas())
    return bool(prim.IsA(UsdGeom.Camera)) and "IsaacRtxLidarSensorAPI" not in applied


def _frame_names(stage: Any, paths: Sequence[str]) -> dict[str, str]:
    """Path -> frame name: isaac:nameOverride, else the prim's name, else (if taken) its path with _ for /."""
    names: dict[str, str] = {}
    taken: set[str] = set()
    for path in dict.fromkeys(paths):
        prim = stage.GetPrimAtPath(path) if path else None
        name = str(prim.GetAttribute(NAME_OVERRIDE).Get() or prim.GetName()) if prim else WORLD
        if name in taken:
            name = path.strip("/").replace("/", "_")
        taken.add(name)
        names[path] = name
    return names


class TransformTree:
    """Reads the poses of a list of edges, all at once."""

    def __init__(self, edges: Sequence[Edge]) -> None:
        self.edges = tuple(edges)
        self._paths = tuple({path: None for edge in edges for path in (edge.parent, edge.child) if path})
        rows = {path: row for row, path in enumerate((*self._paths, ""))}
        self._parents = [rows[edge.parent] for edge in edges]
        self._children = [rows[edge.child] for edge in edges]
        paths = {edge.parent: edge.from_camera for edge in edges} | {edge.child: edge.to_camera for edge in edges}
        self._cameras = [rows[path] for path, is_camera in paths.items() if is_camera]

    def read(self, fabric: Any, meters_per_unit: float) -> list[FrameTransform]:
        """The present poses of the edges, translations in metres; the scale of both ends is removed."""
        import numpy as np

        from graph.sim.transforms import quaternions, rotations_and_scales, to_xyzw

        matrices = np.concatenate([fabric.world_matrices(self._paths), np.eye(4)[None]])
        rotations, _ = rotations_and_scales(matrices)
        if self._cameras:
            rotations[self._cameras] *= (1.0, -1.0, -1.0)  # half a turn about x, from USD to optical axes
        to_parent = rotations[self._parents].transpose(0, 2, 1)
        apart = (matrices[self._children, :3, 3] - matrices[self._parents, :3, 3]) * meters_per_unit
        offsets = (to_parent @ apart[:, :, None])[:, :, 0].tolist()
        turns = to_xyzw(quaternions(to_parent @ rotations[self._children])).tolist()
        return [
            FrameTransform(edge.parent_frame, edge.child_frame, (x, y, z), (qx, qy, qz, qw))
            for edge, (x, y, z), (qx, qy, qz, qw) in zip(self.edges, offsets, turns, strict=True)
        ]
