"""What a camera can measure, named as Replicator's annotators are."""

from __future__ import annotations

import numpy as np

from sensors.channels import Channel

INSTANCE = "instance_id_segmentation"
LABELLED = "instance_segmentation"
SEMANTIC = "semantic_segmentation"
FIRST = 2
"""The number of the first entity of each: 0 is nothing, 1 what has no label."""


def _image(name: str, dtype: str, doc: str, width: int = 1, unit: str = "") -> Channel:
    return Channel(name, np.dtype(dtype), width, unit=unit, doc=doc, image=True)


CHANNELS = (
    _image("distance_to_camera", "<f4", "distance of what a pixel shows; infinite where it shows nothing", unit="m"),
    _image("distance_to_image_plane", "<f4", "the same along the view axis", unit="m"),
    _image("normals", "<f4", "unit surface normal, world axes, facing the camera; 0 where nothing is", 3),
    _image(INSTANCE, "<u4", "number of the prim: 0 nothing, then from 2 on"),
    _image(LABELLED, "<u4", "number of the labelled prim: 0 nothing, 1 no label"),
    _image(SEMANTIC, "<u4", "number of the labels: 0 nothing, 1 no label"),
)
