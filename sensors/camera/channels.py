"""What a camera can measure, named as Replicator's annotators are."""

from __future__ import annotations

from typing import Any

import numpy as np

from sensors.channels import Channel

INSTANCE = "instance_id_segmentation"
LABELLED = "instance_segmentation"
SEMANTIC = "semantic_segmentation"
RGB, HDR = "rgb", "HdrColor"
LIT = frozenset({RGB, HDR})
CROSS = "cross_correspondence"
FIRST = 2
"""Number of the first entity of a kind; 0: no hit, 1: no label."""

TIGHT, LOOSE, BOX = "bounding_box_2d_tight", "bounding_box_2d_loose", "bounding_box_3d"
AROUND = "bounding_box_3d_360"
FLAT_BOX: list[tuple[Any, ...]] = [
    *((f"{axis}_{end}", "<i4") for end in ("min", "max") for axis in "xy"),
    ("occlusionRatio", "<f4"),
]
SOLID_BOX: list[tuple[Any, ...]] = [
    *((f"{axis}_{end}", "<f4") for end in ("min", "max") for axis in "xyz"),
    ("transform", "<f4", (4, 4)),
    ("occlusionRatio", "<f4"),
]
BOX_2D, BOX_3D = np.dtype([("instance", "<u4"), *FLAT_BOX]), np.dtype([("instance", "<u4"), *SOLID_BOX])


def _image(name: str, dtype: str, doc: str, width: int = 1, unit: str = "") -> Channel:
    return Channel(name, np.dtype(dtype), width, unit=unit, doc=doc, image=True)


CHANNELS = (
    _image("distance_to_camera", "<f4", "distance of what a pixel shows; infinite where it shows nothing", unit="m"),
    _image("distance_to_image_plane", "<f4", "the same along the view axis", unit="m"),
    _image("normals", "<f4", "unit surface normal, world axes, facing the camera; 0 where nothing is", 3),
    _image("points", "<f4", "place in the world of what a pixel shows; not a number where it shows nothing", 3, "m"),
    _image("motion_vectors", "<f4", "place in the image one frame before, less the present one", 2, "px"),
    _image(CROSS, "<f4", "offset to the place in a second camera's image [its sizes]; hidden or outside; tested", 4),
    _image(INSTANCE, "<u4", "number of the prim: 0 nothing, then from 2 on"),
    _image(LABELLED, "<u4", "number of the labelled prim: 0 nothing, 1 no label"),
    _image(SEMANTIC, "<u4", "number of the labels: 0 nothing, 1 no label"),
    _image(RGB, "u1", "red, green, blue of sRGB", 3),
    _image(HDR, "<f2", "linear light: red, green, blue", 3, "nit"),
    Channel(TIGHT, BOX_2D, unit="px", doc="labelled prims: first and last column and row that show them"),
    Channel(LOOSE, BOX_2D, unit="px", doc="the same as if each were alone"),
    Channel(BOX, BOX_3D, unit="stage units", doc="labelled prims in the image: extent in their axes, and their pose"),
    Channel(AROUND, BOX_3D, unit="stage units", doc="the same of all labelled prims, in the image or not"),
)
