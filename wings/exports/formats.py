"""The formats of `graph export`: what each holds, and what writes it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from graph.recording.exporting import Exporter, Format


def _scans(type_name: str) -> bool:
    from graph.recording.contents.clouds import TYPES

    return type_name in TYPES


def _cloud(type_name: str) -> bool:
    from graph.recording.contents.clouds import CLOUD

    return type_name == CLOUD


def _image(type_name: str) -> bool:
    from graph.recording.contents.images import IMAGE

    return type_name == IMAGE


def _any(*tests: Callable[[str], bool]) -> Callable[[str], bool]:
    return lambda type_name: any(test(type_name) for test in tests)


def _files(form: str) -> Exporter:
    from .files import Files

    return Files(form)


def _kitti() -> Exporter:
    from .kitti import Kitti

    return Kitti()


def _nuscenes() -> Exporter:
    from .nuscenes import DataSet

    return DataSet()


PCD, PLY = (Format("a file for each scan, with its pose", _scans, partial(_files, form)) for form in ("pcd", "ply"))
LAS = Format("a file for each scan, with its pose (needs laspy)", _scans, partial(_files, "las"))
KITTI = Format("a data set of one lidar", _cloud, _kitti, "{:02d}".format)
NUSCENES = Format(KITTI.help, _any(_cloud, _image), _nuscenes, lambda number: f"scene-{number + 1:04d}")
NPZ = Format("arrays of scans and images", _any(_scans, _image), partial(_files, "npz"))
CSV = Format("tables of any topic", lambda type_name: not _image(type_name), partial(_files, "csv"))
PNG = Format("pictures", _image, partial(_files, "png"))
