"""How a notebook shows a frame: its picture as previews draw it, and one line about it."""

from __future__ import annotations

from html import escape
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from graph.base.html import figure
from sensors.frame import Frame, FramePose, cartesian

from .preview import picture_of

if TYPE_CHECKING:
    from sensors.gmo.buffer import GenericModelOutput


def frame_html(frame: Frame) -> str:
    """A camera's colours or depths, or points in the world from above; text for a frame without any of these."""
    picture = picture_of(frame)
    return f"<code>{escape(repr(frame))}</code>" if picture is None else figure(_png(picture), repr(frame))


def model_output_html(output: GenericModelOutput) -> str:
    """The elements in their own frame of reference, from above."""
    points = np.stack([output.x, output.y, output.z], axis=1).astype(np.float32)
    if output.elementsCoordsType.name == "SPHERICAL":
        points = cartesian(*points.T)
    pose = FramePose(output.timestampNs, np.eye(4))
    frame = Frame(output.timestampNs, output.frameId, pose, pose, len(points), {"xyz": points})
    return frame_html(frame).replace(escape(repr(frame)), escape(repr(output)))


def _png(picture: np.ndarray) -> bytes:
    from PIL import Image

    stream = BytesIO()
    Image.fromarray(np.ascontiguousarray(picture)).save(stream, format="PNG")
    return stream.getvalue()
