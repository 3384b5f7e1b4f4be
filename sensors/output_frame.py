"""The output frame of a sensor, if it is not the sensor's own frame or the world."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def custom_frame(frame_of_reference: str, trafo: Sequence[float]) -> np.ndarray | None:
    """(4, 4) from the sensor frame to the CUSTOM one, or None for other frames.

    trafo: customFrameOfReferenceTrafo, x, y, z [m], roll, pitch, yaw [deg]: the sensor's pose in the custom frame,
    rotated about x, then y, then z of that frame; without it the custom frame is the sensor's. (The direction that the
    original uses is not public.)
    """
    if frame_of_reference != "CUSTOM":
        return None
    return pose_of(trafo[:3], trafo[3:]) if len(trafo) else np.eye(4)


def pose_of(position: Sequence[float], rotation: Sequence[float]) -> np.ndarray:
    """(4, 4) of a position [m] and roll, pitch, yaw [deg], turned about x, then y, then z of the outer frame."""
    roll, pitch, yaw = rotation
    out = np.eye(4)
    out[:3, :3] = _about(2, yaw) @ _about(1, pitch) @ _about(0, roll)
    out[:3, 3] = position
    return out


def _about(axis: int, degrees: float) -> np.ndarray:
    cosine, sine = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = np.eye(3)
    out[i, i] = out[j, j] = cosine
    out[j, i], out[i, j] = sine, -sine
    return out
