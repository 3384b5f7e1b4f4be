"""A polygon mesh under construction: boxes, tubes and swept profiles gathered into one point list."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

BOX_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
BOX_FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


class Mesh:
    """Points [m] and polygons; every `add_` method appends a closed or open surface and returns the mesh."""

    def __init__(self) -> None:
        self._points: list[NDArray[np.float64]] = []
        self._count = 0
        self._faces: list[tuple[int, ...]] = []

    def add(self, points: ArrayLike, faces: Sequence[Sequence[int]]) -> Mesh:
        """Append points (N, 3) and faces that index them."""
        array = np.asarray(points, dtype=float).reshape(-1, 3)
        self._points.append(array)
        self._faces.extend(tuple(self._count + index for index in face) for face in faces)
        self._count += len(array)
        return self

    def add_box(self, centre: ArrayLike, size: ArrayLike, yaw_deg: float = 0.0) -> Mesh:
        """A box of full edge lengths `size`, turned about z."""
        corners = BOX_CORNERS * np.asarray(size, dtype=float)
        return self.add(corners @ rotation_z(yaw_deg).T + np.asarray(centre, dtype=float), BOX_FACES)

    def add_tube(self, path: ArrayLike, radius: float | Sequence[float], sides: int = 12, capped: bool = True) -> Mesh:
        """A round tube along `path` (K, 3); `radius` may differ from point to point (a cone, a branch)."""
        centres = np.asarray(path, dtype=float)
        radii = np.broadcast_to(np.asarray(radius, dtype=float), len(centres))
        angles = 2 * np.pi * np.arange(sides) / sides
        rings = [
            centre + r * (np.outer(np.cos(angles), side) + np.outer(np.sin(angles), up))
            for centre, r, (side, up) in zip(centres, radii, _frames(centres), strict=True)
        ]
        faces = grid_faces(len(centres), sides, closed=True)
        if capped:
            last = (len(centres) - 1) * sides
            faces += [tuple(reversed(range(sides))), tuple(range(last, last + sides))]
        return self.add(np.concatenate(rings), faces)

    def add_grid(self, points: ArrayLike) -> Mesh:
        """An open surface over points (rows, columns, 3), facing along column step x row step."""
        array = np.asarray(points, dtype=float)
        return self.add(array, [tuple(reversed(face)) for face in grid_faces(*array.shape[:2], closed=False)])

    def add_sweep(self, profile: ArrayLike, path: ArrayLike) -> Mesh:
        """Sweep an upright profile (P, 2: across to the left, up) along a level path (K, 3), open at both ends."""
        centres = np.asarray(path, dtype=float)
        shape = np.asarray(profile, dtype=float)
        ahead = np.gradient(centres, axis=0)
        ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
        left = np.stack([-ahead[:, 1], ahead[:, 0], np.zeros(len(ahead))], axis=1)
        points = centres[:, None, :] + shape[None, :, :1] * left[:, None, :]
        points[:, :, 2] += shape[None, :, 1]
        return self.add_grid(points)

    def define(self, stage: Usd.Stage, path: str, material: str = "") -> UsdGeom.Mesh:
        """Write the mesh to the stage at `path`, bound to the material prim `material` if one is named."""
        mesh = UsdGeom.Mesh.Define(stage, path)
        points = np.concatenate(self._points).astype(np.float32)
        mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
        mesh.CreateExtentAttr([Gf.Vec3f(*map(float, bound)) for bound in (points.min(axis=0), points.max(axis=0))])
        mesh.CreateFaceVertexCountsAttr([len(face) for face in self._faces])
        mesh.CreateFaceVertexIndicesAttr([index for face in self._faces for index in face])
        mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        if material:
            bind(mesh.GetPrim(), material)
        return mesh


def rotation_z(angle_deg: float) -> NDArray[np.float64]:
    """The (3, 3) rotation about z."""
    angle = np.radians(angle_deg)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])


def grid_faces(rows: int, columns: int, closed: bool) -> list[tuple[int, ...]]:
    """Quads over a grid of points numbered row by row; `closed` joins the last column to the first."""
    steps = columns if closed else columns - 1
    return [
        (
            row * columns + column,
            row * columns + (column + 1) % columns,
            (row + 1) * columns + (column + 1) % columns,
            (row + 1) * columns + column,
        )
        for row in range(rows - 1)
        for column in range(steps)
    ]


def material(stage: Usd.Stage, path: str, base: str, color: tuple[float, float, float], coating: str = "none") -> str:
    """A material with a display colour and the non-visual name that lidars see; returns its path."""
    shade = UsdShade.Material.Define(stage, path)
    surface = UsdShade.Shader.Define(stage, f"{path}/Surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*color))
    shade.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    for name, value in (("base", base), ("coating", coating), ("attributes", "none")):
        attribute = shade.GetPrim().CreateAttribute(f"omni:simready:nonvisual:{name}", Sdf.ValueTypeNames.String)
        attribute.Set(value)
    return path


def bind(prim: Usd.Prim, material_path: str) -> None:
    """Bind the material at `material_path` to `prim` and what is below it."""
    shade = UsdShade.Material(prim.GetStage().GetPrimAtPath(material_path))
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(shade)


def place(prim: Usd.Prim, translate: ArrayLike = (0, 0, 0), yaw_deg: float = 0.0, scale: float = 1.0) -> None:
    """Give the prim its local pose; parts that are neutral are not written."""
    xform = UsdGeom.Xformable(prim)
    position = np.asarray(translate, dtype=float)
    if position.any():
        xform.AddTranslateOp().Set(Gf.Vec3d(*map(float, position)))
    if yaw_deg:
        xform.AddRotateZOp().Set(float(yaw_deg))
    if scale != 1.0:
        xform.AddScaleOp().Set(Gf.Vec3f(float(scale)))


def _frames(centres: NDArray[np.float64]) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Two unit vectors across the path at each point, carried along without twist."""
    ahead = np.gradient(centres, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    side = np.cross(ahead[0], (0.0, 0.0, 1.0) if abs(ahead[0][2]) < 0.9 else (1.0, 0.0, 0.0))
    frames = []
    for direction in ahead:
        side = side - direction * (side @ direction)
        side = side / np.linalg.norm(side)
        frames.append((side, np.cross(direction, side)))
    return frames
