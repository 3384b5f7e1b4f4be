"""`sensor_msgs_py.point_cloud2`: the points of clouds that a script has heard; only with `graph exec --rclpy`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.lib.recfunctions import repack_fields, structured_to_unstructured

from graph.recording.contents.clouds import CLOUD, points_of

__all__ = ["read_points", "read_points_list", "read_points_numpy"]


def read_points(
    cloud: Any,
    field_names: Iterable[str] | None = None,
    skip_nans: bool = False,
    uvs: Any = None,
    reshape_organized_cloud: bool = False,
) -> np.ndarray:
    """The points, (n,) with a column for each field. Raises ValueError for a field that the cloud does not have."""
    found = points_of(cloud, CLOUD)
    known = found.dtype.names or ()
    names = list(known if field_names is None else field_names)
    if unknown := [name for name in names if name not in known]:
        raise ValueError(f"the cloud has no field {unknown[0]}; it has {', '.join(known)}")
    chosen: np.ndarray = repack_fields(found[names])
    if skip_nans:
        chosen = chosen[~np.any([np.isnan(chosen[name]) for name in names], axis=0)]
    elif uvs is not None:
        chosen = chosen[[column + row * cloud.width for column, row in uvs]]
    if reshape_organized_cloud and cloud.height > 1:
        chosen = chosen.reshape(cloud.width, cloud.height)
    return chosen


def read_points_numpy(
    cloud: Any,
    field_names: Iterable[str] | None = None,
    skip_nans: bool = False,
    uvs: Any = None,
    reshape_organized_cloud: bool = False,
) -> np.ndarray:
    """The points, (n, fields). Raises ValueError for fields of several types."""
    found = read_points(cloud, field_names, skip_nans, uvs, reshape_organized_cloud)
    names = found.dtype.names or ()
    if len({found.dtype[name] for name in names}) > 1:
        raise ValueError(f"the fields {', '.join(names)} are of several types; choose some of one type")
    out: np.ndarray = structured_to_unstructured(found)
    return out


def read_points_list(
    cloud: Any, field_names: Iterable[str] | None = None, skip_nans: bool = False, uvs: Any = None
) -> list[tuple[Any, ...]]:
    """The points, each as a tuple of its fields."""
    return [tuple(one) for one in read_points(cloud, field_names, skip_nans, uvs)]
