"""Shapes, lamps and a camera, drawn by MuJoCo's renderer: colours, depth, and which shape each pixel shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass
from graph.sim.physics.mujoco.library import mujoco
from graph.sim.transforms import Floats, pose_matrices

MOST_LAMPS = 7
"""OpenGL has eight; one brings what comes from everywhere."""
SHADOW_PIXELS = 4096
"""Side of the image in which shadows are found; it covers the shapes."""
FARTHEST_M = 2e4
"""Colours end there: MuJoCo finds shadows with the depth of the whole image."""
SHOWN, DARK, ABSENT = 0, 1, 2
"""Groups of shapes: in all images; in depth only; in none."""


@dataclass(frozen=True, slots=True)
class Shape:
    """Triangles of one colour or texture, seen from both sides.

    vertices: (n, 3) float64 [m], in the shape's frame. triangles: (m, 3). normals: (m, 3, 3) unit, at the corners.
    color: (3,) linear, 0 to 1. glow: how much of its colour it gives without light. texture: (height, width, 3) uint8,
    linear, the first row on top; it repeats. places: (m, 3, 2), the texture's coordinates at the corners, (0, 0) below
    on the left.
    """

    vertices: Floats
    triangles: np.ndarray
    normals: Floats
    color: np.ndarray
    glow: float = 0.0
    texture: np.ndarray | None = None
    places: np.ndarray | None = None


@dataclass(frozen=True, slots=True)
class Lamp:
    """A light. color: (3,), what it adds to white that faces it (at 1 m, of one with a place), 0 to 1.

    direction: (3,) unit, in which it shines. place: (3,) [m]; None: it is far. fades: with the square of the distance.
    cutoff: half the angle of its cone [deg]; beyond 90 it shines all round. focus: the power of the cosine with which
    it gets weaker aside.
    """

    color: np.ndarray
    direction: np.ndarray
    place: np.ndarray | None = None
    fades: bool = True
    cutoff: float = 180.0
    focus: float = 0.0
    shadows: bool = True


@dataclass(frozen=True, slots=True)
class Eye:
    """A camera: pose (4, 4) [m], as of USD (it looks along -z, y is up), and its image.

    size: width, height [px]. sides: left, right, bottom, top of what it sees, as tangents, or as lengths [m] of a
    `parallel` one. near, far: [m].
    """

    pose: Floats
    size: tuple[int, int]
    sides: tuple[float, float, float, float]
    near: float
    far: float
    parallel: bool = False


class DrawnScene:
    """Shapes that may be drawn in images of `size` (width, height).

    samples: of each pixel's colour. reach: [m], things throw shadows within this distance of the origin. Raises
    UserError for shapes that MuJoCo refuses.
    """

    def __init__(self, shapes: Sequence[Shape], size: tuple[int, int], samples: int, reach: float) -> None:
        spec = mujoco.MjSpec()
        for number, shape in enumerate(shapes):
            _add(spec, f"s{number}", shape)
        for _ in range(MOST_LAMPS):
            spec.worldbody.add_light(type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)
        try:
            self._model = model = spec.compile()
        except ValueError as error:
            raise UserError(f"camera.backend=gl: {' '.join(str(error).split())}; use rays") from error
        _write_textures(model, shapes)
        model.vis.global_.offwidth, model.vis.global_.offheight = size
        model.vis.quality.offsamples = samples if samples > 1 else 0
        model.vis.quality.shadowsize = SHADOW_PIXELS
        model.vis.map.shadowclip = reach
        self._reach = reach
        model.vis.headlight.active = 1
        for part in (model.vis.headlight.diffuse, model.vis.headlight.specular, model.light_ambient):
            part[:] = 0
        model.light_specular[:] = 0
        model.stat.extent = 1.0
        self._data = mujoco.MjData(model)
        self._local = pose_matrices(model.geom_pos, model.geom_quat)
        self._renderer = mujoco.Renderer(model, size[1], size[0], max_geom=max(1, len(shapes)))
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = [1, 1, 0, 0, 0, 0]
        flags = self._renderer.scene.flags
        flags[:] = 0
        for flag in ("SHADOW", "CULL_FACE"):
            flags[getattr(mujoco.mjtRndFlag, f"mjRND_{flag}")] = 1

    def close(self) -> None:
        """Frees what the driver holds."""
        self._renderer.close()

    def place(self, poses: Floats, groups: np.ndarray) -> None:
        """Where the shapes are: (n, 4, 4) [m], near the origin; groups: (n,), of `SHOWN`, `DARK`, `ABSENT`."""
        found = poses @ self._local
        self._data.geom_xpos[:] = found[:, :3, 3]
        self._data.geom_xmat[:] = found[:, :3, :3].reshape(-1, 9)
        self._model.geom_group[:] = groups

    def depth(self, eye: Eye) -> tuple[np.ndarray, np.ndarray]:
        """Two images: depth, float32 [m], infinite where nothing is; and the number of the shape, int32, or -1."""
        self._look(eye, dark=True)
        self._renderer.enable_segmentation_rendering()
        shapes = self._renderer.render()[..., 0]
        self._renderer.enable_depth_rendering()
        with np.errstate(divide="ignore"):  # where nothing is
            depth = self._renderer.render()
        self._renderer.disable_depth_rendering()
        depth[shapes < 0] = np.inf
        return depth, shapes

    def picture(self, eye: Eye, lamps: Sequence[Lamp], ambient: np.ndarray) -> np.ndarray:
        """(height, width, 3) uint8, linear light; black where nothing is nearer than `FARTHEST_M`.

        ambient: (3,), from everywhere.
        """
        model, data = self._model, self._data
        model.vis.headlight.ambient[:] = ambient
        model.light_active[:] = 0
        for number, lamp in enumerate(lamps):
            far = lamp.place is None
            kinds = mujoco.mjtLightType
            kind = kinds.mjLIGHT_DIRECTIONAL if far else kinds.mjLIGHT_SPOT
            model.light_type[number] = kind if far or lamp.cutoff <= 90 else kinds.mjLIGHT_POINT
            model.light_active[number], model.light_castshadow[number] = 1, lamp.shadows
            model.light_diffuse[number] = lamp.color
            model.light_attenuation[number] = (0, 0, 1) if lamp.fades and not far else (1, 0, 0)
            model.light_cutoff[number], model.light_exponent[number] = min(lamp.cutoff, 90.0), lamp.focus
            data.light_xpos[number] = -self._reach * lamp.direction if far else lamp.place
            data.light_xdir[number] = lamp.direction
        end = max(4 * self._reach, min(eye.far, FARTHEST_M))  # lamps that are far stand at the reach
        self._look(replace(eye, far=end), dark=False)
        return np.asarray(self._renderer.render())

    def _look(self, eye: Eye, *, dark: bool) -> None:
        model, scene = self._model, self._renderer.scene
        model.vis.map.znear, model.vis.map.zfar = eye.near, eye.far
        self._option.geomgroup[DARK] = dark
        self._renderer.update_scene(self._data, scene_option=self._option)
        left, right, bottom, top = (side * (1.0 if eye.parallel else eye.near) for side in eye.sides)
        for camera in scene.camera:
            camera.pos[:], camera.forward[:], camera.up[:] = eye.pose[:3, 3], -eye.pose[:3, 2], eye.pose[:3, 1]
            camera.frustum_center, camera.frustum_width = (left + right) / 2, (right - left) / 2
            camera.frustum_bottom, camera.frustum_top = bottom, top
            camera.frustum_near, camera.frustum_far = eye.near, eye.far
            camera.orthographic = eye.parallel


def _add(spec: Any, name: str, shape: Shape) -> None:
    """Adds the triangles of a shape twice, once for each side: MuJoCo's light does not reach the back of a face."""
    count = len(shape.triangles)
    mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    mesh.uservert = np.asarray(shape.vertices, np.float32).ravel()
    mesh.userface = np.concatenate([shape.triangles, shape.triangles[:, ::-1]]).astype(np.int32).ravel()
    mesh.usernormal = np.concatenate([shape.normals, -shape.normals[:, ::-1]]).astype(np.float32).ravel()
    corners = np.arange(6 * count, dtype=np.int32)
    mesh.userfacenormal = corners
    material = spec.add_material(name=name, specular=0, shininess=0, reflectance=0, emission=shape.glow)
    material.rgba = [*shape.color, 1.0]
    if shape.texture is not None and shape.places is not None:
        mesh.usertexcoord = np.concatenate([shape.places, shape.places[:, ::-1]]).astype(np.float32).ravel()
        mesh.userfacetexcoord = corners
        height, width = shape.texture.shape[:2]
        flat, plain = mujoco.mjtTexture.mjTEXTURE_2D, mujoco.mjtBuiltin.mjBUILTIN_FLAT
        spec.add_texture(name=name, type=flat, builtin=plain, width=width, height=height, nchannel=3)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
    kind = mujoco.mjtGeom.mjGEOM_MESH
    spec.worldbody.add_geom(type=kind, meshname=name, material=name, contype=0, conaffinity=0)


def _write_textures(model: Any, shapes: Sequence[Shape]) -> None:
    """Pixels, from below upwards, as the texture's coordinates count."""
    textures = [shape.texture for shape in shapes if shape.texture is not None]
    data = model.tex_data
    for start, texture in zip(model.tex_adr, textures, strict=True):
        data[start : start + texture.size] = texture[::-1].ravel()
