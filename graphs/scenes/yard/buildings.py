"""The warehouse, the tank and its pipes: everything that stands once."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from .mesh import Mesh

LEFT, RIGHT, FRONT, BACK = -12.0, 12.0, 12.0, 19.0
"""Outer faces of the warehouse [m]; its front looks to -y."""

HEIGHT, WALL = 5.5, 0.25


@dataclass(frozen=True)
class Opening:
    """A hole in a wall: from `start` to `end` along it, from `sill` to `head` above the floor [m]."""

    start: float
    end: float
    sill: float
    head: float


DOORS = [Opening(centre - 1.6, centre + 1.6, 0.0, 3.4) for centre in (-7.5, -1.5, 4.5)]
SIDE_DOOR = Opening(9.4, 10.4, 0.0, 2.1)
WINDOWS = [Opening(centre - 0.7, centre + 0.7, 3.9, 4.9) for centre in (-10.5, -4.5, 1.5, 7.8, 10.6)]
GABLE_WINDOWS = [Opening(centre - 0.6, centre + 0.6, 1.4, 2.8) for centre in (13.6, 15.5, 17.4)]


def build_warehouse(stage: Usd.Stage, root: str, looks: dict[str, str]) -> None:
    """Write walls with their openings, frames, roller doors, the corrugated roof, gutters and columns below `root`."""
    walls = Mesh()
    for box in wall_boxes(LEFT, RIGHT, [*DOORS, SIDE_DOOR, *WINDOWS]):
        _across(walls, box, FRONT + WALL / 2)
    for box in wall_boxes(LEFT, RIGHT, []):
        _across(walls, box, BACK - WALL / 2)
    for x in (LEFT + WALL / 2, RIGHT - WALL / 2):
        for box in wall_boxes(FRONT + WALL, BACK - WALL, GABLE_WINDOWS):
            walls.add_box(
                (x, (box.start + box.end) / 2, (box.sill + box.head) / 2),
                (WALL, box.end - box.start, box.head - box.sill),
            )
    walls.define(stage, f"{root}/Walls", looks["brick"])

    frames = Mesh()
    for window in WINDOWS:
        _window_bars(frames, window)
    _window_bars(frames, SIDE_DOOR)
    frames.define(stage, f"{root}/Frames", looks["plastic"])

    for name, door, raised in zip(("A", "B", "C"), DOORS, (0.0, 2.6, 1.2), strict=True):
        Mesh().add_grid(_roller(door, raised)).define(stage, f"{root}/RollerDoor{name}", looks["steel"])

    Mesh().add_grid(_roof()).define(stage, f"{root}/Roof", looks["steel"])
    pipes = Mesh()
    for y in (FRONT - 0.62, BACK + 0.62):
        pipes.add_sweep(_gutter(), np.linspace((LEFT - 0.3, y, HEIGHT - 0.12), (RIGHT + 0.3, y, HEIGHT - 0.12), 25))
        for x in (LEFT + 0.4, RIGHT - 0.4):
            wall = y + (0.5 if y < FRONT else -0.5)
            pipes.add_tube([(x, y, HEIGHT - 0.15), (x, y, HEIGHT - 0.4), (x, wall, HEIGHT - 0.9), (x, wall, 0.1)], 0.05)
    pipes.define(stage, f"{root}/Gutters", looks["steel"])

    columns = Mesh()
    for x in np.linspace(-9, 9, 4):
        columns.add_box((x, 15.5, HEIGHT / 2), (0.1, 0.3, HEIGHT)).add_box((x, 15.35, HEIGHT / 2), (0.3, 0.02, HEIGHT))
        columns.add_box((x, 15.65, HEIGHT / 2), (0.3, 0.02, HEIGHT))
    columns.define(stage, f"{root}/Columns", looks["steel"])
    Mesh().add_box((0, (FRONT + BACK) / 2, 0.01), (RIGHT - LEFT - 0.5, BACK - FRONT - 0.5, 0.02)).define(
        stage, f"{root}/Floor", looks["concrete"]
    )


def build_tank(stage: Usd.Stage, root: str, looks: dict[str, str]) -> None:
    """Write a domed tank on legs, its ladder, and two pipes on trestles over to the warehouse below `root`."""
    centre = np.array([-23.0, 12.0, 0.0])
    angles = np.radians(np.linspace(0, 90, 10))
    rim = [(2.4 * np.cos(a), 6.0 + 0.9 * np.sin(a)) for a in angles]
    hull = [(0.05, 0.9), (2.0, 0.9), *((2.4, z) for z in np.linspace(1.2, 6.0, 9)), *rim[1:-1], (0.05, 6.9)]
    tank = Mesh().add_tube([centre + (0, 0, z) for _, z in _rising(hull)], [r for r, _ in _rising(hull)], sides=48)
    for angle in np.radians((45, 135, 225, 315)):
        foot = centre + 1.9 * np.array([np.cos(angle), np.sin(angle), 0])
        tank.add_tube([foot, foot + (0, 0, 1.2)], 0.12, sides=10)
    ladder = centre + (0, -2.55, 0)
    for x in (-0.22, 0.22):
        tank.add_tube([ladder + (x, 0, 0.2), ladder + (x, 0, 6.6)], 0.02, sides=6)
    for z in np.arange(0.4, 6.5, 0.3):
        tank.add_tube([ladder + (-0.22, 0, z), ladder + (0.22, 0, z)], 0.014, sides=6)
    tank.define(stage, f"{root}/Tank", looks["painted_steel"])

    pipes = Mesh()
    for offset, radius in ((0.0, 0.16), (0.5, 0.1)):
        y, top = 12 + offset, 4.7 + offset / 2
        path = _rounded([(-20.8, y, 1.6), (-17.5, y, 1.6), (-17.5, y, top), (-11.9, y, top)])
        pipes.add_tube(path, radius, sides=20)
        for flange in path[:: len(path) // 4]:
            pipes.add_box(flange, (3.2 * radius, 3.2 * radius, 3.2 * radius))
    for x in (-16.2, -14.2):
        for y in (11.7, 12.8):
            pipes.add_tube([(x, y, 0), (x, y, 4.5)], 0.05, sides=8)
        pipes.add_box((x, 12.25, 4.5), (0.12, 1.3, 0.08))
    pipes.define(stage, f"{root}/Pipes", looks["steel"])


def wall_boxes(start: float, end: float, openings: list[Opening]) -> list[Opening]:
    """The solid rectangles of a wall from `start` to `end` after cutting out its openings (which may not overlap)."""
    cuts = sorted({start, end, *(edge for opening in openings for edge in (opening.start, opening.end))})
    solid = []
    for left, right in pairwise(cuts):
        bottom = 0.0
        for hole in sorted((o for o in openings if o.start <= left and right <= o.end), key=lambda o: o.sill):
            if hole.sill > bottom:
                solid.append(Opening(left, right, bottom, hole.sill))
            bottom = hole.head
        if bottom < HEIGHT:
            solid.append(Opening(left, right, bottom, HEIGHT))
    return solid


def _across(mesh: Mesh, box: Opening, y: float) -> None:
    mesh.add_box(
        ((box.start + box.end) / 2, y, (box.sill + box.head) / 2), (box.end - box.start, WALL, box.head - box.sill)
    )


def _window_bars(mesh: Mesh, hole: Opening) -> None:
    """A frame around the hole and a cross in it."""
    width, height = hole.end - hole.start, hole.head - hole.sill
    x, z = (hole.start + hole.end) / 2, (hole.sill + hole.head) / 2
    for position in (hole.start + 0.03, x, hole.end - 0.03):
        mesh.add_box((position, FRONT + 0.1, z), (0.06, 0.08, height))
    for position in (hole.sill + 0.03, z, hole.head - 0.03):
        mesh.add_box((x, FRONT + 0.1, position), (width, 0.06, 0.06))


def _roller(door: Opening, raised: float) -> NDArray[np.float64]:
    """A roller door of half-round slats, its lower edge `raised` above the floor."""
    z = np.arange(raised, door.head + 1e-9, 0.02)
    depth = 0.018 * np.abs(np.sin(np.pi * z / 0.08))
    edge = np.stack([np.zeros_like(z), FRONT + 0.12 - depth, z], axis=-1)
    return np.stack([edge + (door.start, 0, 0), edge + (door.end, 0, 0)], axis=1)


def _roof() -> NDArray[np.float64]:
    """Corrugated sheets over a shallow gable."""
    x = np.arange(LEFT - 0.4, RIGHT + 0.41, 0.05)
    wave = 0.02 * np.sin(2 * np.pi * x / 0.2)
    middle = (FRONT + BACK) / 2
    rows = []
    for y in (FRONT - 0.5, (FRONT + middle) / 2, middle, (BACK + middle) / 2, BACK + 0.5):
        ridge = HEIGHT + 1.4 * (1 - abs(y - middle) / (middle - FRONT + 0.5))
        rows.append(np.stack([x, np.full_like(x, y), ridge + wave], axis=-1))
    return np.stack(rows, axis=1)


def _gutter() -> NDArray[np.float64]:
    angles = np.radians(np.linspace(180, 360, 9))
    return np.stack([0.08 * np.cos(angles), 0.08 * np.sin(angles)], axis=-1)


def _rising(profile: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The profile with equal heights spread by a hair, so that the tube's axis never stands still."""
    return [(radius, height + 1e-4 * index) for index, (radius, height) in enumerate(profile)]


def _rounded(corners: list[tuple[float, float, float]], radius: float = 0.35) -> list[NDArray[np.float64]]:
    """A path through the points with every inner corner rounded off."""
    points = np.asarray(corners, dtype=float)
    path = [points[0]]
    for before, corner, after in zip(points, points[1:], points[2:], strict=False):
        inward = corner + radius * (before - corner) / np.linalg.norm(before - corner)
        outward = corner + radius * (after - corner) / np.linalg.norm(after - corner)
        path += [(1 - t) ** 2 * inward + 2 * t * (1 - t) * corner + t**2 * outward for t in np.linspace(0, 1, 8)]
    return [*path, points[-1]]
