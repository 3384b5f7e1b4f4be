"""The output frame of points, normals and velocities."""

from __future__ import annotations

import numpy as np

from graph.base.records import dataclass
from graph.sim.transforms import inverse_rigid

from .aim import Aim, turned_back


@dataclass(frozen=True, slots=True)
class Output:
    """Transforms measurements from the sensor frame of each firing to the output frame.

    world: along world axes, about the world's origin. common: (4, 4) pose of the sensor at the one time to which all
    points are transformed (COMPENSATED); None leaves each in the sensor frame of its own firing. custom: (4, 4) from
    the sensor frame to the output frame, or None.
    """

    world: bool = False
    common: np.ndarray | None = None
    custom: np.ndarray | None = None

    @property
    def is_sensor_frame(self) -> bool:
        """Whether points stay on the beams with which they were measured."""
        return not self.world and self.common is None and self.custom is None

    def points(self, points: np.ndarray, aim: Aim, rays: np.ndarray) -> np.ndarray:
        """(k, 3) float32 [m] of points (k, 3) float32 in the sensor frame; their rays: (k,)."""
        if self.is_sensor_frame:
            return points
        if self.world:
            return aim.to_world(points, rays).astype(np.float32)
        if self.common is None:
            assert self.custom is not None
            return _moved(points, self.custom).astype(np.float32)
        return _moved(aim.to_world(points, rays), self._from_world(self.common)).astype(np.float32)

    def vectors(self, world: np.ndarray, aim: Aim, rays: np.ndarray) -> np.ndarray:
        """Vectors (k, 3) along world axes, turned to the axes of the output frame."""
        if self.world:
            return world
        if self.common is not None:
            return turned_back(world, self._from_world(self.common)[:3, :3].T.astype(world.dtype))
        local = aim.turned_back(world, rays)
        return local if self.custom is None else turned_back(local, self.custom[:3, :3].T.astype(world.dtype))

    def _from_world(self, common: np.ndarray) -> np.ndarray:
        inverse = inverse_rigid(common)
        return inverse if self.custom is None else self.custom @ inverse


def _moved(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """(k, 3) float64 of points through a rigid matrix, column by column, so that it does not depend on their number."""
    x, y, z = points.astype(np.float64).T
    return np.stack([matrix[i, 0] * x + matrix[i, 1] * y + matrix[i, 2] * z + matrix[i, 3] for i in range(3)], 1)
