"""Mirrors a model as prims, which sensors see, graphs name and inline prims are added to."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.sim import transforms
from graph.sim.geometry.tessellation import Triangles
from graph.sim.physics.mujoco.library import mujoco
from graph.sim.scene.mechanisms import GIVEN
from graph.sim.scene.prim_paths import NAME_OVERRIDE
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats
from graph.sim.usd import Gf, Sdf, Usd, UsdGeom, Vt

from . import looks
from .authoring import Author, integers, points, turn, vector
from .naming import ACTUATORS, LOOKS, ROOT, SENSORS, Paths, flex_name

SHOWN_GROUPS = 3
"""Rays see geoms of groups below this, as MuJoCo's viewer shows them; the others are for collisions (`guide`)."""
LIBRARY = "/MjcfMeshes"
_GEOM = mujoco.mjtGeom
_APERTURE = 20.955
"""The default aperture of USD's cameras [tenths of a unit]; the angle of view is the model's."""


def mirror(model: Any, data: Any, paths: Paths, warn: Warn) -> Any:
    """A stage (`Usd.Stage`) in metres, Z up, with a prim for each part of the model, posed as in `data`.

    The prims are in their own layer below the root layer, so that later edits stay separate.
    """
    layer = Sdf.Layer.CreateAnonymous("mjcf.usda")
    with Sdf.ChangeBlock():
        _Mirror(model, data, paths, warn, layer).write()
    root = Sdf.Layer.CreateAnonymous("world.usda")
    root.subLayerPaths.append(layer.identifier)
    stage = Usd.Stage.Open(root)
    UsdGeom.SetStageMetersPerUnit(stage, UsdGeom.LinearUnits.meters)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    stage.SetDefaultPrim(stage.GetPrimAtPath(ROOT))
    return stage


class _Mirror:
    def __init__(self, model: Any, data: Any, paths: Paths, warn: Warn, layer: Any) -> None:
        self.model, self.data, self.paths, self.warn = model, data, paths, warn
        self.author = Author(layer)
        self.meshes: set[str] = set()

    def write(self) -> None:
        self.author.prim(ROOT, "Xform")
        self._scene()
        for number in range(1, self.model.nbody):
            self._body(number)
        for name, count in ((ACTUATORS, self.paths.actuators), (SENSORS, self.paths.sensors)):
            if count:
                self.author.prim(count[0].rpartition("/")[0] or f"{ROOT}/{name}", "Scope")
        if self.paths.materials:
            self.author.prim(self.paths.materials[0].rpartition("/")[0] or f"{ROOT}/{LOOKS}", "Scope")
        for number, path in enumerate(self.paths.materials):
            self._material(number, path)
        for number in range(self.model.njnt):
            self._joint(number)
        for number, path in self.paths.welds.items():
            spec = self.author.prim(path, "PhysicsFixedJoint")
            self.author.set(spec, GIVEN, "String", "")
            place = transforms.pose_matrices(self.model.body_pos[number], self.model.body_quat[number])
            self._ends(spec, number, (place, np.eye(4)))
        for number in range(self.model.ngeom):
            self._geom(number)
        for number, path in enumerate(self.paths.sites):
            spec = self._named(path, "Xform", self.model.site(number).name)
            self.author.place(spec, self.model.site_pos[number], self.model.site_quat[number])
        for number in range(self.model.ncam):
            self._camera(number)
        looks.mirror_lights(self.model, self.data, self.paths, self.author, self.warn)
        for number in range(self.model.nflex):
            self._flex(number)
        self._actuators_and_sensors()

    def _named(self, path: str, type_name: str, name: str, schemas: tuple[str, ...] = ()) -> Any:
        """A prim for an element; if its name differs from the element's, it stores the latter."""
        spec = self.author.prim(path, type_name, schemas)
        if path.rpartition("/")[2] != name:
            self.author.set(spec, NAME_OVERRIDE, "String", name)
        return spec

    def _scene(self) -> None:
        option = self.model.opt
        spec = self.author.prim(self.paths.scene, "PhysicsScene", ("MjcSceneAPI",))
        strength = float(np.linalg.norm(option.gravity))
        direction = option.gravity / strength if strength else np.array([0.0, 0.0, -1.0])
        self.author.set(spec, "physics:gravityDirection", "Vector3f", Gf.Vec3f(*map(float, direction)))
        self.author.set(spec, "physics:gravityMagnitude", "Float", strength)
        self.author.set(spec, "mjc:option:timestep", "Double", float(option.timestep))
        for name, kind in (
            ("integrator", mujoco.mjtIntegrator),
            ("solver", mujoco.mjtSolver),
            ("cone", mujoco.mjtCone),
            ("jacobian", mujoco.mjtJacobian),
        ):
            said = kind(int(getattr(option, name))).name.partition("_")[2].lower()
            self.author.set(spec, f"mjc:option:{name}", "Token", said)
        self.author.set(spec, "mjc:option:iterations", "Int", int(option.iterations))
        for name in ("tolerance", "impratio", "density", "viscosity"):
            self.author.set(spec, f"mjc:option:{name}", "Double", float(getattr(option, name)))
        self.author.set(spec, "mjc:option:wind", "Double3", vector(option.wind))

    def _body(self, number: int) -> None:
        model, path = self.model, self.paths.bodies[number]
        if number in self.paths.points:
            return
        schemas: tuple[str, ...] = ()
        if model.body_weldid[number]:
            schemas = ("PhysicsRigidBodyAPI",)
            if model.body_parentid[number] == 0 and model.body_mocapid[number] < 0:
                schemas += ("PhysicsArticulationRootAPI",)
        elif model.body_parentid[number] == 0 and self._carries(number):
            schemas = ("PhysicsArticulationRootAPI",)
        spec = self._named(path, "Xform", model.body(number).name, schemas)
        self.author.set(spec, GIVEN, "String", model.body(number).name)
        self.author.place(spec, self.data.xpos[number], self.data.xquat[number])
        if model.body_mocapid[number] >= 0:
            self.author.set(spec, "physics:kinematicEnabled", "Bool", True)

    def _carries(self, number: int) -> bool:
        """Whether a body without joints carries bodies with joints."""
        moving = self.model.body_weldid[self.model.body_rootid == number]
        return bool((moving != 0).any())

    def _material(self, number: int, path: str) -> None:
        spec = self._named(path, "Material", self.model.material(number).name)
        rgba = self.model.mat_rgba[number].tolist()
        self.author.set(spec, "mjc:rgba", "Color4f", Gf.Vec4f(*rgba))
        if looks.texture_of(self.model, number) >= 0:
            red, green, blue = map(_linear, rgba[:3])
            looks.mirror_texture(self.model, number, path, self.author, (red, green, blue))

    def _joint(self, number: int) -> None:
        model, path = self.model, self.paths.joints[number]
        kind, body = model.jnt_type[number], int(model.jnt_bodyid[number])
        if not path:
            return
        types = {
            int(mujoco.mjtJoint.mjJNT_HINGE): "PhysicsRevoluteJoint",
            int(mujoco.mjtJoint.mjJNT_SLIDE): "PhysicsPrismaticJoint",
            int(mujoco.mjtJoint.mjJNT_BALL): "PhysicsSphericalJoint",
        }
        spec = self._named(path, types[int(kind)], model.joint(number).name)
        self.author.set(spec, GIVEN, "String", model.joint(number).name)
        self._ends(spec, body, joint_frames(model, number))
        if kind == mujoco.mjtJoint.mjJNT_BALL:
            return
        self.author.set(spec, "physics:axis", "Token", "X")
        if model.jnt_limited[number]:
            hinge = kind == mujoco.mjtJoint.mjJNT_HINGE
            for name, value in zip(("lower", "upper"), model.jnt_range[number], strict=True):
                limit = math.degrees(value) if hinge else float(value)
                self.author.set(spec, f"physics:{name}Limit", "Float", limit)

    def _ends(self, spec: Any, body: int, frames: tuple[Any, Any]) -> None:
        """The ends of a body's joint: its parent and itself, and the joint's frame in each."""
        parent = self.paths.bodies[self.model.body_parentid[body]]
        for side, target, frame in zip((0, 1), (parent, self.paths.bodies[body]), frames, strict=True):
            if target:
                self.author.relate(spec, f"physics:body{side}", target)
            quaternion = Gf.Quatf(turn(transforms.quaternion(frame[:3, :3])))
            self.author.set(spec, f"physics:localPos{side}", "Point3f", Gf.Vec3f(*map(float, frame[:3, 3])))
            self.author.set(spec, f"physics:localRot{side}", "Quatf", quaternion)

    def _geom(self, number: int) -> None:
        model, path = self.model, self.paths.geoms[number]
        kind = _GEOM(int(model.geom_type[number]))
        x, y, z = map(float, model.geom_size[number])
        scale = None
        schemas = ("MaterialBindingAPI",) if model.geom_matid[number] >= 0 else ()
        types = {
            _GEOM.mjGEOM_PLANE: "Plane",
            _GEOM.mjGEOM_SPHERE: "Sphere",
            _GEOM.mjGEOM_CAPSULE: "Capsule",
            _GEOM.mjGEOM_CYLINDER: "Cylinder",
            _GEOM.mjGEOM_BOX: "Cube",
            _GEOM.mjGEOM_ELLIPSOID: "Sphere",
        }
        spec = self._named(path, types.get(kind, "Mesh"), model.geom(number).name, schemas)
        put = self.author.set
        if kind == _GEOM.mjGEOM_PLANE:
            if x > 0 and y > 0:
                put(spec, "width", "Double", 2 * x)
                put(spec, "length", "Double", 2 * y)
            put(spec, "axis", "Token", "Z")
            if (coordinates := looks.plane_coordinates(model, number)) is not None:
                put(spec, looks.ST, "DoubleArray", coordinates)
        elif kind == _GEOM.mjGEOM_SPHERE:
            put(spec, "radius", "Double", x)
        elif kind in (_GEOM.mjGEOM_CAPSULE, _GEOM.mjGEOM_CYLINDER):
            put(spec, "radius", "Double", x)
            put(spec, "height", "Double", 2 * y)
            put(spec, "axis", "Token", "Z")
        elif kind == _GEOM.mjGEOM_BOX:
            put(spec, "size", "Double", 2.0)
            scale = x, y, z
        elif kind == _GEOM.mjGEOM_ELLIPSOID:
            put(spec, "radius", "Double", 1.0)
            scale = x, y, z
        else:
            self._mesh(spec, number)
        self.author.place(spec, model.geom_pos[number], model.geom_quat[number], scale)
        self._look(spec, number)

    def _mesh(self, spec: Any, number: int) -> None:
        """The points of a mesh or height field, shared by all its geoms."""
        model, asset = self.model, int(self.model.geom_dataid[number])
        field = model.geom_type[number] == _GEOM.mjGEOM_HFIELD
        if asset < 0:
            self.warn("mjcf-geom-unseen", self.paths.geoms[number], "it has no mesh; rays do not see it")
            return
        source = f"{LIBRARY}/{'hfield' if field else 'mesh'}{asset}"
        if source not in self.meshes:
            if not self.meshes:
                self.author.prim(LIBRARY, "", class_=True)
            self.meshes.add(source)
            found = height_field(model, asset) if field else mesh_triangles(model, asset)
            shared = self.author.prim(source, "Mesh", class_=True)
            self._triangles(shared, *found)
            if not field and (coordinates := looks.mesh_coordinates(model, asset)) is not None:
                self.author.set(shared, "primvars:st", "TexCoord2fArray", coordinates)
                shared.attributes["primvars:st"].SetInfo("interpolation", "faceVarying")
        spec.referenceList.prependedItems = [Sdf.Reference(primPath=source)]

    def _triangles(self, spec: Any, vertices: Any, triangles: Any) -> None:
        self.author.set(spec, "points", "Point3fArray", points(vertices))
        self.author.set(spec, "faceVertexCounts", "IntArray", integers(np.full(len(triangles), 3)))
        self.author.set(spec, "faceVertexIndices", "IntArray", integers(triangles))
        self.author.set(spec, "subdivisionScheme", "Token", "none")

    def _look(self, spec: Any, number: int) -> None:
        model, material = self.model, int(self.model.geom_matid[number])
        rgba = (
            model.mat_rgba[material] if material >= 0 and _plain(model.geom_rgba[number]) else model.geom_rgba[number]
        )
        group = int(model.geom_group[number])
        self._colour(spec, rgba)
        if material >= 0:
            self.author.relate(spec, "material:binding", self.paths.materials[material])
        self.author.set(spec, "mjc:group", "Int", group)
        if group >= SHOWN_GROUPS:
            self.author.set(spec, "purpose", "Token", "guide")

    def _colour(self, spec: Any, rgba: Any) -> None:
        alpha = float(rgba[3])
        red, green, blue = (_linear(float(each)) for each in rgba[:3])
        self.author.set(spec, "primvars:displayColor", "Color3fArray", Vt.Vec3fArray([Gf.Vec3f(red, green, blue)]))
        if alpha != 1:
            self.author.set(spec, "primvars:displayOpacity", "FloatArray", Vt.FloatArray([alpha]))
        if alpha == 0:
            self.author.set(spec, "visibility", "Token", "invisible")

    def _camera(self, number: int) -> None:
        model = self.model
        spec = self._named(self.paths.cameras[number], "Camera", model.camera(number).name)
        self.author.place(spec, model.cam_pos[number], model.cam_quat[number])
        width, height = (int(size) for size in model.cam_resolution[number])
        sensor, fovy = model.cam_sensorsize[number].astype(float), float(model.cam_fovy[number])
        wide, tall, ratio = _APERTURE, _APERTURE * height / max(width, 1), 1.0
        focal = tall / 2 / math.tan(math.radians(fovy) / 2)
        if int(model.cam_projection[number]) == int(mujoco.mjtProjection.mjPROJ_ORTHOGRAPHIC):
            self.author.set(spec, "projection", "Token", "orthographic")
            wide, tall = 10 * fovy * wide / tall, 10 * fovy  # fovy is the height in metres; apertures are in tenths
        elif (sensor > 0).all():
            across, focal, right, up = (10 * float(length) for length in model.cam_intrinsic[number])
            wide, tall = 10 * sensor[0] * focal / across, 10 * sensor[1]
            if (width, height) != (1, 1):  # else it has no resolution, and square pixels
                ratio = (width * tall) / (height * wide)
            # As MuJoCo draws it: the principal point is to the left of the middle, and above it.
            self.author.set(spec, "horizontalApertureOffset", "Float", right * focal / across)
            self.author.set(spec, "verticalApertureOffset", "Float", -up)
        nearest, farthest = (float(model.stat.extent * share) for share in (model.vis.map.znear, model.vis.map.zfar))
        self.author.set(spec, "clippingRange", "Float2", Gf.Vec2f(nearest, farthest))
        self.author.set(spec, "horizontalAperture", "Float", wide)
        self.author.set(spec, "verticalAperture", "Float", tall)
        self.author.set(spec, "focalLength", "Float", focal)
        self.author.set(spec, "mjc:pixelAspect", "Double", ratio)
        self.author.set(spec, "mjc:resolution", "Int2", Gf.Vec2i(width, height))

    def _flex(self, number: int) -> None:
        model = self.model
        triangles = flex_triangles(model, number)
        path = self.paths.flexes[number]
        if triangles is None:
            self.warn("mjcf-geom-unseen", path, "it is a thread without faces; rays do not see it")
            return
        first, count = model.flex_vertadr[number], model.flex_vertnum[number]
        spec = self._named(path, "Mesh", flex_name(model, number))
        self._triangles(spec, self.data.flexvert_xpos[first : first + count], triangles)
        material = int(model.flex_matid[number].flat[0])
        self._colour(spec, model.mat_rgba[material] if material >= 0 else model.flex_rgba[number])
        if model.flex_group[number] >= SHOWN_GROUPS:
            self.author.set(spec, "purpose", "Token", "guide")

    def _actuators_and_sensors(self) -> None:
        model, data = self.model, self.data
        for number, path in enumerate(self.paths.actuators):
            spec = self._named(path, "MjcActuator", model.actuator(number).name)
            first, count = int(model.actuator_ctrladr[number]), int(model.actuator_ctrlnum[number])
            control = [float(value) for value in data.ctrl[first : first + count]]
            if count == 1:
                self.author.set(spec, "mjc:ctrl", "Double", control[0])
            else:
                self.author.set(spec, "mjc:ctrl", "DoubleArray", Vt.DoubleArray(control))
            if model.actuator_ctrllimited[first]:
                low, high = map(float, model.actuator_ctrlrange[first])
                self.author.set(spec, "mjc:ctrlRange:min", "Double", low)
                self.author.set(spec, "mjc:ctrlRange:max", "Double", high)
            for name in ("force", "length", "velocity"):
                self.author.set(spec, f"mjc:{name}", "Double", 0.0)
            kind = mujoco.mjtTrn(int(model.actuator_trntype[number]))
            if kind in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT):
                target = self.paths.joints[model.actuator_trnid[number, 0]]
                if target:
                    self.author.relate(spec, "mjc:target", target)
        for number, path in enumerate(self.paths.sensors):
            spec = self._named(path, "Scope", model.sensor(number).name)
            kind_name = mujoco.mjtSensor(int(model.sensor_type[number])).name.partition("_")[2].lower()
            self.author.set(spec, "mjc:sensor", "Token", kind_name)
            zeros = Vt.DoubleArray([0.0] * int(model.sensor_dim[number]))
            self.author.set(spec, "mjc:value", "DoubleArray", zeros)


def joint_frames(model: Any, number: int) -> tuple[Any, Any]:
    """(4, 4) of a joint in its body's parent and in its body [m], X along its axis, at the model's reference pose."""
    body = int(model.jnt_bodyid[number])
    here = np.eye(4)
    here[:3, :3] = _x_along(model.jnt_axis[number])
    here[:3, 3] = model.jnt_pos[number]
    return transforms.pose_matrices(model.body_pos[body], model.body_quat[body]) @ here, here


def _x_along(axis: Any) -> Any:
    x = np.asarray(axis, dtype=np.float64)
    side = np.eye(3)[int(np.argmin(np.abs(x)))]
    z = np.cross(x, side)
    z /= np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _linear(shown: float) -> float:
    """Linear light of a colour as it is shown (sRGB), which is what MuJoCo's are; displayColor is linear."""
    return shown / 12.92 if shown <= 0.04045 else ((shown + 0.055) / 1.055) ** 2.4


def _plain(rgba: Any) -> bool:
    """Whether a geom has the default colour, so that its material's colour shows."""
    return bool(np.allclose(rgba, (0.5, 0.5, 0.5, 1)))


def mesh_triangles(model: Any, number: int) -> tuple[Floats, Triangles]:
    """Vertices (n, 3) [m] and triangles (m, 3) of a mesh of the model, in the frame of its geoms."""
    first, count = model.mesh_vertadr[number], model.mesh_vertnum[number]
    face, faces = model.mesh_faceadr[number], model.mesh_facenum[number]
    triangles: Triangles = model.mesh_face[face : face + faces].astype(np.uint32)
    return model.mesh_vert[first : first + count].astype(np.float64), triangles


def height_field(model: Any, number: int) -> tuple[Floats, Triangles]:
    """The closed surface of a height field: its top as MuJoCo collides with it, its four sides and its underside [m].

    Each cell of the top is cut from its corner of least x and y to the opposite one, as MuJoCo cuts it.
    """
    rows, columns = int(model.hfield_nrow[number]), int(model.hfield_ncol[number])
    half_x, half_y, height, depth = map(float, model.hfield_size[number])
    start = model.hfield_adr[number]
    heights = model.hfield_data[start : start + rows * columns].astype(np.float64) * height
    y, x = np.meshgrid(np.linspace(-half_y, half_y, rows), np.linspace(-half_x, half_x, columns), indexing="ij")
    top = np.stack([x.ravel(), y.ravel(), heights], axis=1)
    grid = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (part.ravel() for part in (grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]))
    upper = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])

    # Once around the edge, counter-clockwise seen from above, so that the sides face out.
    edge = np.concatenate([grid[0, :-1], grid[:-1, -1], grid[-1, :0:-1], grid[:0:-1, 0]])
    below = top[edge].copy()
    below[:, 2] = -depth
    low = len(top) + np.arange(len(edge))
    following, low_following = np.roll(edge, -1), np.roll(low, -1)
    sides = np.concatenate(
        [np.stack([edge, low, low_following], axis=1), np.stack([edge, low_following, following], axis=1)]
    )
    corners = low[[0, columns - 1, columns + rows - 2, 2 * columns + rows - 3]]
    under = np.array([[corners[0], corners[2], corners[1]], [corners[0], corners[3], corners[2]]])
    return np.concatenate([top, below]), np.concatenate([upper, sides, under]).astype(np.uint32)


def flex_triangles(model: Any, number: int) -> Triangles | None:
    """The triangles (m, 3) of a cloth's faces or of a solid's skin, by vertex of the flex.

    None for a one-dimensional flex.
    """
    if model.flex_dim[number] == 2:
        first, count = model.flex_elemdataadr[number], model.flex_elemnum[number]
        found: Triangles = model.flex_elem[first : first + 3 * count].reshape(-1, 3).astype(np.uint32)
        return found
    if model.flex_dim[number] == 3:
        first, count = model.flex_shelldataadr[number], model.flex_shellnum[number]
        skin: Triangles = model.flex_shell[first : first + 3 * count].reshape(-1, 3).astype(np.uint32)
        return skin
    return None
