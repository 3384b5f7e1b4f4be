"""Depth from structured light: `python graphs/structured_light.py`.

A projector 20 cm to the right of a camera shows Gray codes, one bit an update; from the column of the projector that
each pixel sees follows its depth, z = f b / (u - cx - f t): camera C of 500 px, baseline b, t the column's tangent.
Prints what is recovered of a crate and of the wall behind it. Needs the extra `exr`
(`graph help live-and-recordings`).
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image

from graph.sim import App
from sensors import CameraSensor, StructuredLightCamera, write_directions

BITS, COLUMNS, ROWS, FOCAL = 8, 256, 192, 256.0
BASELINE, PIXELS = 0.2, 500.0


def patterns(folder: Path) -> list[Path]:
    """A white picture, then the bits of each column's Gray code, the highest first."""
    gray = np.arange(COLUMNS) ^ (np.arange(COLUMNS) >> 1)
    rows = [np.ones(COLUMNS), *((gray >> bit) & 1 for bit in reversed(range(BITS)))]
    files = []
    for number, row in enumerate(rows):
        files.append(folder / f"{number}.png")
        Image.fromarray(np.tile(255 * row, (ROWS, 1)).astype(np.uint8)).save(files[-1])
    return files


def columns_of(pictures: list[np.ndarray]) -> np.ndarray:
    """(height, width) the projector column that each pixel sees; not a number where the projector does not shine."""
    white, *bits = (picture[..., 0].astype(float) for picture in pictures)
    binary = np.zeros(white.shape, np.int64)
    last = np.zeros(white.shape, bool)
    for bit in bits:
        last ^= bit > white / 2
        binary = 2 * binary + last
    return np.where(white > 8, binary + 0.5, np.nan)


def main() -> None:
    """Takes a picture of each pattern and works out the depth."""
    from pxr import Gf, UsdGeom

    with TemporaryDirectory() as name, App(physics_hz=60, loop_hz=60) as app:
        folder = Path(name)
        for path, size, z in (("/World/Crate", 0.5, -1.75), ("/World/Wall", 10.0, -8.0)):
            cube = UsdGeom.Cube.Define(app.stage, path)
            cube.CreateSizeAttr(size)
            UsdGeom.XformCommonAPI(cube).SetTranslate(Gf.Vec3d(0, 0, z))
        write_directions(folder / "directions.exr", (COLUMNS, ROWS), FOCAL)
        files = patterns(folder)
        camera = StructuredLightCamera(
            "/World/Camera",
            files,
            folder / "directions.exr",
            projector_position=(BASELINE, 0, 0),
            projector_timestamps=[(number, 60) for number in range(len(files))],
            projector_intensity=4e6,
            projector_width=0.1,
            projector_height=0.1,
            attributes={"focalLength": 16.0, "horizontalAperture": 20.48, "clippingRange": Gf.Vec2f(0.01, 100)},
            app=app,
        )
        sensor = CameraSensor(camera, resolution=(480, 640), annotators=["rgb", "distance_to_image_plane"], app=app)
        pictures: list[np.ndarray] = [np.zeros(0)] * len(files)
        app.play()
        for _ in files:
            app.update()
            pictures[camera.get_active_pattern_index()] = sensor.get_data("rgb")[0].copy()
        tangents = (columns_of(pictures) - COLUMNS / 2) / FOCAL
        across = np.arange(640) + 0.5
        depth = PIXELS * BASELINE / (across - 320 - PIXELS * tangents)
        true = sensor.get_data("distance_to_image_plane")[0][..., 0]
        for path, z in (("crate", 1.5), ("wall", 3.0)):
            seen = np.isfinite(depth) & (np.abs(true - z) < 1e-3)
            print(f"{path}: {np.median(depth[seen]):.2f} m of {z:.2f} m, {seen.sum():,} pixels")


if __name__ == "__main__":
    main()
