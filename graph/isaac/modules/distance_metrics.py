"""`isaacsim.core.utils.distance_metrics`: distances between poses."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.sim.usd import Gf

__all__ = [
    "rotational_distance_angle",
    "rotational_distance_identity_matrix_deviation",
    "rotational_distance_single_axis",
    "weighted_translational_distance",
]


def _matrix(given: Any) -> np.ndarray:
    """Column-vector convention; USD's matrices have the other."""
    out = np.array(given, float)
    return out.T if isinstance(given, (Gf.Matrix3d, Gf.Matrix4d)) else out


def _turn(given: Any) -> np.ndarray:
    return _matrix(given)[:3, :3]


def _place(given: Any) -> np.ndarray:
    found = _matrix(given)
    return found[:3, 3] if found.ndim == 2 else found


def weighted_translational_distance(t1: Any, t2: Any, weight_matrix: Any = None) -> float:
    """sqrt(d^T W d) of the difference of two places."""
    way = _place(t1) - _place(t2)
    return float(np.sqrt(way @ (np.eye(3) if weight_matrix is None else np.asarray(weight_matrix)) @ way))


def rotational_distance_angle(r1: Any, r2: Any) -> float:
    """Angle [rad] of the turn from one to the other."""
    turn = _turn(r1) @ _turn(r2).T
    sine = np.linalg.norm([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return float(np.arctan2(sine, np.trace(turn) - 1))


def rotational_distance_identity_matrix_deviation(r1: Any, r2: Any) -> float:
    """Frobenius norm of I - R1 R2^T."""
    return float(np.linalg.norm(np.eye(3) - _turn(r1) @ _turn(r2).T))


def rotational_distance_single_axis(r1: Any, r2: Any, axis: Any) -> float:
    """Angle [rad] between what both turns make of an axis."""
    one, other = _turn(r1) @ np.asarray(axis, float), _turn(r2) @ np.asarray(axis, float)
    return float(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other))
