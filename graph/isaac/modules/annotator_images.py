"""`draw_annotator_data_to_image`: what an annotator gives, as a picture in blue, green, red."""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["draw_annotator_data_to_image"]
DEPTHS = ("distance_to_image_plane", "distance_to_camera", "depth_sensor_distance", "depth_sensor_imager")
SEGMENTS = ("semantic_segmentation", "instance_segmentation", "instance_id_segmentation")
CLOUDS = ("pointcloud", "depth_sensor_point_cloud_position")
SIDE, MARGIN = 1500, 0.05
"""Pixels along a view of points in space, and the share of it that stays free at each edge."""
STEP = 10
"""Pixels from one drawn motion vector to the next."""
EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b) in (1, 2, 4)]
"""Corners of a box that an edge joins; bit k of a corner's number says which end of axis k it is at."""


def draw_annotator_data_to_image(*, annotator: str, data: Any, info: dict[str, Any], frame: Any = None) -> np.ndarray:
    """(height, width[, 3 or 4]) uint8; frame: the picture to draw on, red, green, blue; black if None.

    Near is bright in depths; points and boxes in space are seen along (-1, -1, -1). Raises ValueError for an annotator
    that gives no picture.
    """
    data = np.asarray(data.numpy() if hasattr(data, "numpy") else data)
    below = None if frame is None else np.asarray(frame.numpy() if hasattr(frame, "numpy") else frame)[..., 2::-1]
    if annotator == "rgb":
        return np.ascontiguousarray(data[..., ::-1])
    if annotator in ("rgba", "depth_sensor_point_cloud_color"):
        return np.ascontiguousarray(data[..., (2, 1, 0, 3)])
    if annotator in DEPTHS:
        return _depth(data.squeeze())
    if annotator == "normals":
        return np.asarray(((data[..., 2::-1] + 1.0) * 127.5).clip(0, 255), np.uint8)
    if annotator in SEGMENTS:
        numbers = data.squeeze()
        return np.where((numbers != 0)[..., None], _colors(numbers), _canvas(below, numbers.shape)).astype(np.uint8)
    if annotator == "motion_vectors":
        return _arrows(data, _canvas(below, data.shape[:2]))
    if annotator in ("bounding_box_2d_tight", "bounding_box_2d_loose"):
        return _rectangles(data, _canvas(below, tuple(info.get("resolution", (0, 0)))))
    if annotator == "bounding_box_3d":
        corners = np.reshape([_corners(one) for one in data], (-1, 8, 3))
        return _in_space(corners, [one["semanticId"] for one in data], EDGES)
    if annotator in CLOUDS:
        points = data.reshape(-1, 3).astype(float)
        return _in_space(points[np.isfinite(points).all(axis=1)][:, None], [0], [(0, 0)])
    raise ValueError(f"annotator {annotator!r} gives no picture")


def _depth(depths: np.ndarray) -> np.ndarray:
    finite = np.isfinite(depths)
    out = np.zeros(depths.shape, np.uint8)
    if finite.any():
        near, far = float(depths[finite].min()), float(depths[finite].max())
        out[finite] = 255 * (1 - (depths[finite] - near) / max(far - near, 1e-12))
    return out


def _canvas(below: np.ndarray | None, shape: tuple[int, ...]) -> np.ndarray:
    return np.zeros((*shape, 3), np.uint8) if below is None else np.ascontiguousarray(below, np.uint8)


def _colors(numbers: Any) -> np.ndarray:
    """Bright colours of numbers, far apart for neighbours."""
    turn = np.asarray(numbers, float)[..., None] * 0.6180339887 + np.array([2 / 3, 1 / 3, 0.0])
    return np.asarray(127.5 * (1 + np.cos(2 * np.pi * turn)), np.uint8)


def _drawn(canvas: np.ndarray) -> tuple[Any, Any]:
    from PIL import Image, ImageDraw

    picture = Image.fromarray(canvas)
    return picture, ImageDraw.Draw(picture)


def _arrows(vectors: np.ndarray, canvas: np.ndarray) -> np.ndarray:
    picture, draw = _drawn(canvas)
    for y in range(STEP // 2, vectors.shape[0], STEP):
        for x in range(STEP // 2, vectors.shape[1], STEP):
            dx, dy = vectors[y, x, :2]
            if np.isfinite(dx) and np.isfinite(dy):
                draw.line([(x, y), (x + float(dx), y + float(dy))], fill=(0, 255, 0))
    return np.asarray(picture)


def _rectangles(boxes: np.ndarray, canvas: np.ndarray) -> np.ndarray:
    picture, draw = _drawn(canvas)
    for box in boxes:
        ends = [int(box[name]) for name in ("x_min", "y_min", "x_max", "y_max")]
        draw.rectangle(ends, outline=tuple(map(int, _colors(int(box[0])))), width=2)
    return np.asarray(picture)


def _corners(box: Any) -> np.ndarray:
    """(8, 3) of a box in the space of its transform's target, whose rows are the axes and the origin."""
    ends = np.array([[box[f"{axis}_{end}"] for axis in "xyz"] for end in ("min", "max")])
    corners = np.array([[ends[number >> axis & 1, axis] for axis in range(3)] for number in range(8)])
    matrix = np.asarray(box["transform"], float).reshape(4, 4)
    found: np.ndarray = corners @ matrix[:3, :3] + matrix[3, :3]
    return found


def _in_space(groups: np.ndarray, numbers: list[Any], edges: list[tuple[int, int]]) -> np.ndarray:
    """Groups of points (n, k, 3) and the edges in each, seen from above, on white."""
    picture, draw = _drawn(np.full((SIDE, SIDE, 3), 255, np.uint8))
    if not len(groups):
        return np.asarray(picture)
    right, up = np.array([-1, 1, 0]) / 2**0.5, np.array([-1, -1, 2]) / 6**0.5
    seen = np.stack([groups @ right, -(groups @ up)], axis=-1)
    low, high = seen.min(axis=(0, 1)), seen.max(axis=(0, 1))
    scale = SIDE * (1 - 2 * MARGIN) / max(float((high - low).max()), 1e-9)
    places = (seen - (low + high) / 2) * scale + SIDE / 2
    for row, group in enumerate(places):
        color = tuple(map(int, _colors(int(numbers[row % len(numbers)]))))
        for first, second in edges:
            draw.line([tuple(group[first]), tuple(group[second])], fill=color, width=3)
    return np.asarray(picture)
