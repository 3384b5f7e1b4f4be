"""Writers of one scan into one file: PCD, PLY, LAS, NPZ, CSV.

PCD 0.7 (https://pointclouds.org/documentation/tutorials/pcd_file_format.html) and binary PLY are a text header before
the rows of the structured array: no library writes all columns with their own types. A file depends on the scan alone.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.base.exact import NANOSECONDS
from graph.base.extras import install_command
from graph.base.outputs import replacing, replacing_text, write
from graph.recording.contents.clouds import Points
from graph.recording.contents.scans import Scan
from graph.sim.transforms import quaternion

_PLY_TYPES = {
    "i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort",
    "i4": "int", "u4": "uint", "f4": "float", "f8": "double",
}  # fmt: skip
_LAS_PLAIN = {"x", "y", "z"}
_LAS_STEPS = [10.0**exponent for exponent in range(-5, 309)]
"""Sizes of a step of LAS coordinates [m]: the finest is used with which the scan fits into 32 bits."""


def pose_numbers(pose: Any) -> list[float]:
    """x, y, z [m], qx, qy, qz, qw of a (4, 4) pose."""
    w, x, y, z = (float(one) for one in quaternion(pose[:3, :3]))
    return [*(float(one) for one in pose[:3, 3]), x, y, z, w]


def write_pcd(path: Path, scan: Scan, points: Points) -> None:
    """Binary PCD 0.7; VIEWPOINT is the pose of the sensor's frame (identity without one)."""
    columns = _columns(points)
    place = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0] if scan.pose is None else pose_numbers(scan.pose)
    x, y, z, qx, qy, qz, qw = place
    header = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
        f"FIELDS {' '.join(_word(name) for name, _ in columns)}\n"
        f"SIZE {' '.join(form[1:] for _, form in columns)}\n"
        f"TYPE {' '.join(form[0].upper() for _, form in columns)}\n"
        f"COUNT {' '.join('1' for _ in columns)}\n"
        f"WIDTH {len(points)}\nHEIGHT 1\nVIEWPOINT {' '.join(map(repr, (x, y, z, qw, qx, qy, qz)))}\n"
        f"POINTS {len(points)}\nDATA binary\n"
    )
    write(path, header.encode("ascii", "replace") + points.tobytes())


def write_ply(path: Path, scan: Scan, points: Points) -> None:
    """Binary little-endian PLY; stamp, frame and pose are comments."""
    lines = ["ply", "format binary_little_endian 1.0", f"comment stamp_ns {scan.stamp_ns}"]
    lines.append(f"comment frame_id {_word(scan.frame_id)}")
    if scan.pose is not None:
        lines.append(f"comment pose x y z qx qy qz qw {' '.join(map(repr, pose_numbers(scan.pose)))}")
    lines.append(f"element vertex {len(points)}")
    lines += (f"property {_PLY_TYPES[form]} {_word(name)}" for name, form in _columns(points))
    write(path, "\n".join([*lines, "end_header", ""]).encode("ascii", "replace") + points.tobytes())


def write_las(path: Path, scan: Scan, points: Points) -> None:
    """LAS 1.4, point format 6: gps_time is the time of each point [s of simulation]; classification the class_id where
    all are below 256; every column besides x, y, z is an extra dimension of its own type.

    Raises UserError without laspy.
    """
    laspy = load_laspy()
    from datetime import date

    places = np.stack([points["x"], points["y"], points["z"]]).astype(np.float64)
    (good,) = np.nonzero(np.isfinite(places).all(axis=0))
    points, places = points[good], places[:, good]
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.creation_date = date(1970, 1, 1)  # no wall-clock time: the file depends on the scan alone
    header.generating_software = "tickgraph"
    header.global_encoding.wkt = True  # as LAS 1.4 wants for point formats 6 to 10
    low = np.floor(places.min(axis=1)) if len(points) else np.zeros(3)
    extent = float((places - low[:, None]).max()) if len(points) else 0.0
    step = next(one for one in _LAS_STEPS if extent < one * (2**31 - 1))
    header.offsets, header.scales = low, np.full(3, step)
    extra = [(name, form) for name, form in _columns(points) if name not in _LAS_PLAIN]
    taken = {name.lower() for name in header.point_format.dimension_names}
    named = {name: f"{name}_" if name.lower() in taken else name for name, _ in extra}
    header.add_extra_dims(
        [laspy.ExtraBytesParams(name=named[name][:32], type=np.dtype(f"<{form}")) for name, form in extra]
    )
    las = laspy.LasData(header)
    las.x, las.y, las.z = places
    las.return_number[:] = 1
    las.number_of_returns[:] = 1
    times = np.full(len(good), scan.stamp_ns) if scan.times_ns is None else scan.times_ns[good]
    las.gps_time = times / NANOSECONDS
    for name, _ in extra:
        las[named[name][:32]] = points[name]
    if "class_id" in named and (not len(points) or points["class_id"].max() < 256):
        las.classification = points["class_id"].astype(np.uint8)
    if "intensity" in named and len(points):  # 0 to 1 as 0 to 65535
        las["intensity"] = np.round(np.clip(points["intensity"], 0, 1) * 65535).astype(np.uint16)
    with replacing(path) as stream:
        las.write(stream)


def load_laspy() -> Any:
    """The library of LAS files. Raises UserError where it is not installed."""
    try:
        import laspy
    except ImportError:
        raise UserError(f"--format las needs laspy. Run: {install_command('las')}") from None
    return laspy


def write_npz(path: Path, scan: Scan, points: Points) -> None:
    """Every column; stamp_ns, frame_id, pose (4, 4); for each point time_ns (n,), pose_at (n, 7: x, y, z, qx, qy, qz,
    qw) and world (n, 3): as far as they are known.
    """
    from graph.sim.transforms import quaternions, to_xyzw

    arrays: dict[str, Any] = {name: points[name] for name, _ in _columns(points)}
    arrays["stamp_ns"], arrays["frame_id"] = np.int64(scan.stamp_ns), np.str_(scan.frame_id)
    if scan.pose is not None:
        arrays["pose"], arrays["world"] = scan.pose, scan.in_world()
    if scan.times_ns is not None:
        arrays["time_ns"] = scan.times_ns
    if scan.point_poses is not None:
        turns = to_xyzw(quaternions(scan.point_poses[:, :3, :3]))
        arrays["pose_at"] = np.concatenate([scan.point_poses[:, :3, 3], turns], axis=1)
    with replacing(path) as stream:
        np.savez_compressed(stream, **arrays)


def write_csv(path: Path, scan: Scan, points: Points) -> None:
    """A row for each point: every column, then time_ns and world_x, world_y, world_z as far as they are known."""
    columns = [points[name] for name, _ in _columns(points)]
    names = [name for name, _ in _columns(points)]
    if scan.times_ns is not None:
        columns.append(scan.times_ns)
        names.append("time_ns")
    if (world := scan.in_world()) is not None:
        columns += [*world.T]
        names += ["world_x", "world_y", "world_z"]
    with replacing_text(path) as file:
        writer = csv.writer(file)
        writer.writerow(names)
        writer.writerows(zip(*(column.tolist() for column in columns), strict=True))


WRITERS = {"pcd": write_pcd, "ply": write_ply, "las": write_las, "npz": write_npz, "csv": write_csv}
"""Format -> writer(path, scan, points); `points` are those of the scan, or they moved to the world."""


def _columns(points: Points) -> list[tuple[str, str]]:
    """(name, format such as f4) of each column."""
    return [(name, points.dtype[name].str.lstrip("<>|=")) for name in points.dtype.names or ()]


def _word(text: str) -> str:
    return "_".join(text.split()) or "_"
