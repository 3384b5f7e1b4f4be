"""How a notebook shows a frame: its picture as previews draw it, and one line about it."""

from __future__ import annotations

from html import escape
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from graph.base.html import figure
from sensors.frame import Frame, FramePose, cartesian

from .drawing import PointCloudDrawing

if TYPE_CHECKING:
    from sensors.gmo.buffer import GenericModelOutput

RESOLUTION = (480, 360)
"""Of the picture of a cloud [px]."""
SIZE_M = 0.05
"""Side of a point's square."""


def frame_html(frame: Frame) -> str:
    """The colours of a camera, else the points in the world from above, else the nearest pixels of a depth image brightest.

    A frame without any of these is shown as text.
    """
    picture = _picture(frame)
    return f"<code>{escape(repr(frame))}</code>" if picture is None else figure(_png(picture), repr(frame))


def model_output_html(output: GenericModelOutput) -> str:
    """The elements in their own frame of reference, from above."""
    points = np.stack([output.x, output.y, output.z], axis=1).astype(np.float32)
    if output.elementsCoordsType.name == "SPHERICAL":
        points = cartesian(*points.T)
    pose = FramePose(output.timestampNs, np.eye(4))
    frame = Frame(output.timestampNs, output.frameId, pose, pose, len(points), {"xyz": points})
    return figure(_png(_cloud(frame, in_world=False)), repr(output))


def _picture(frame: Frame) -> np.ndarray | None:
    """(height, width, 3) uint8, or None."""
    if frame.has("rgb"):
        return np.asarray(frame.channel("rgb"))[..., :3]
    if len(frame.xyz):
        return _cloud(frame, in_world=True)
    images = (np.asarray(one) for name, one in frame.arrays.items() if name.startswith("distance_to_"))
    depth = next((one.reshape(one.shape[:2]) for one in images if one.ndim >= 2 and one.size), None)
    return None if depth is None else _grey(depth)


def _cloud(frame: Frame, *, in_world: bool) -> np.ndarray:
    return PointCloudDrawing(size=SIZE_M, resolution=RESOLUTION, doTransform=in_world).draw(frame)


def _grey(depth: np.ndarray) -> np.ndarray:
    """A depth image [m], the nearest brightest; black where nothing was measured."""
    seen = np.isfinite(depth) & (depth > 0)
    shades = np.zeros(depth.shape, np.uint8)
    if seen.any():
        shades[seen] = np.rint(255 * depth[seen].min() / depth[seen])
    return np.repeat(shades[..., None], 3, axis=2)


def _png(picture: np.ndarray) -> bytes:
    from PIL import Image

    stream = BytesIO()
    Image.fromarray(np.ascontiguousarray(picture)).save(stream, format="PNG")
    return stream.getvalue()
