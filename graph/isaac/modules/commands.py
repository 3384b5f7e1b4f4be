"""`omni.kit.commands`: the commands that scripts execute by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from graph.base.suggest import did_you_mean
from graph.isaac.names import home_of
from graph.isaac.outcomes import UnsupportedError, tell_inert
from graph.isaac.session import app, warn
from graph.sim.usd import Gf, Sdf, UsdGeom
from sensors.errors import SensorValueError

from .prim_base import attribute
from .sensor_schema import IsaacSensorSchema, RangeSensorSchema
from .stage import move_prim, refer
from .surface_grippers import create_surface_gripper
from .undo import Done, note
from .xforms import put

__all__ = ["Command", "create", "execute", "execute_argv", "get_command_class", "register", "unregister"]
_OWN: dict[str, Any] = {}


class Command:
    def do(self) -> Any:
        return None

    def undo(self) -> None:
        return None

    def redo(self) -> None:
        self.do()


def register(command_class: Any) -> None:
    _OWN[command_class.__name__] = command_class


def unregister(command_class: Any) -> None:
    _OWN.pop(command_class.__name__, None)


def get_command_class(name: str) -> Any:
    return _OWN.get(name) or _OWN.get(f"{name}Command")


def create(name: str, **kwargs: Any) -> Any:
    found = get_command_class(name)
    return None if found is None else found(**kwargs)


def execute(name: str, **kwargs: Any) -> tuple[bool, Any]:
    """Whether it worked, and the result of the command. As in Kit, an error is logged and not raised."""
    try:
        return _executed(name, kwargs)
    except UnsupportedError:
        raise
    except Exception as error:
        warn("command-failed", name, f"{type(error).__name__}: {error}")
        return False, None


def _executed(name: str, kwargs: dict[str, Any]) -> tuple[bool, Any]:
    own = get_command_class(name)
    if own is not None:
        command = own(**kwargs)
        result = command.do()
        note(Done(name, command.undo, getattr(command, "redo", command.do)))
        return True, result
    short = name.removesuffix("Command")
    found = _COMMANDS.get(short)
    if found is None and short[:4] in ("URDF", "MJCF"):
        kind = short[:4]
        raise UnsupportedError(
            f"{name}: no USD is written from a file in {kind} here; open it as the scene of a graph file, "
            f"scene: {{{kind.lower()}: FILE}}: graph help world"
        )
    if found is None:
        warn("command-unknown", name, f"there is no such command here{did_you_mean(short, _COMMANDS)}; it does nothing")
        return False, None
    stage = app().stage
    before = {text for value in kwargs.values() if (text := _path_text(value)) and stage.GetPrimAtPath(text)}
    result = found(**kwargs)
    made = _path_text(result)
    fresh = bool(made) and made not in before
    note(Done(name, (lambda: stage.RemovePrim(made)) if fresh else None, lambda: found(**kwargs)))
    return True, result


def _path_text(value: Any) -> str:
    """The path of a prim that a value is or names; "" for other values."""
    text = str(value.GetPath() if hasattr(value, "GetPath") and not isinstance(value, type) and value else value)
    return text if text.startswith("/") and Sdf.Path.IsValidPathString(text) and Sdf.Path(text).IsPrimPath() else ""


def execute_argv(name: str, argv: list[Any]) -> tuple[bool, Any]:
    """Arguments as on a command line: `name=value`, the value as a Python literal or a text."""
    from ast import literal_eval

    named: dict[str, Any] = {}
    for one in argv:
        key, sign, text = str(one).partition("=")
        if not sign:
            raise ValueError(f"{name}: write the argument {text or key} as name=value")
        try:
            named[key] = literal_eval(text)
        except (ValueError, SyntaxError):
            named[key] = text
    return execute(name, **named)


def _prim(path: Any) -> Any:
    return app().stage.GetPrimAtPath(str(path))


def _quaternion(value: Any) -> Any:
    return None if value is None else (value.GetReal(), *value.GetImaginary()) if hasattr(value, "GetReal") else value


def _sensor_path(path: str, parent: Any) -> str:
    text = str(path)
    return f"{str(parent).rstrip('/')}/{text.lstrip('/')}" if parent else text if text.startswith("/") else f"/{text}"


def _free(path: str) -> str:
    from .usd import get_stage_next_free_path

    return get_stage_next_free_path(app().stage, path, False)


_AUX_LEVELS = {"omni:sensor:Core:auxOutputType", "omni:sensor:WpmDmat:auxOutputType"}


def _rtx(kind: str, default: str, module: str = "sensors_rtx") -> Callable[..., Any]:
    def made(
        path: str = default,
        parent: Any = None,
        config: str | None = None,
        translation: Any = None,
        orientation: Any = None,
        variant: str | None = None,
        usd_path: str | None = None,
        visibility: bool = False,
        force_camera_prim: bool = False,
        attributes: Any = None,
        **rest: Any,
    ) -> Any:
        place = None if translation is None else np.asarray(translation, float)
        attributes = {**(attributes or {}), **{key: value for key, value in rest.items() if ":" in key}}
        options: dict[str, Any] = {"translations": place, "orientations": _quaternion(orientation)}
        for name in _AUX_LEVELS & attributes.keys():  # what the attribute of former versions has become
            options["aux_output_level"] = str(attributes.pop(name))
        if attributes:
            options["attributes"] = attributes
        full = _free(_sensor_path(path, parent))
        type_ = getattr(home_of(module), kind)
        if config is not None and usd_path is not None:
            warn("command-argument-ignored", full, f"config {config} makes it; usd_path is left out")
            usd_path = None
        if config is not None or usd_path is not None:
            try:
                return type_.create(full, config=config, usd_path=usd_path, variant=variant, **options).prim
            except SensorValueError as error:  # as the command of the product, which makes a sensor all the same
                warn("sensor-config-unknown", full, f"{error}; it has the values of its schema")
        return type_(full, **options).prim

    return made


def _physics_sensor(kind: str, default: str) -> Callable[..., Any]:
    def made(
        path: str = default, parent: Any = None, translation: Any = None, orientation: Any = None, **rest: Any
    ) -> Any:
        from . import sensor_prims

        full = _free(_sensor_path(path, parent))
        period = rest.pop("sensor_period", None)
        known = {key: rest[key] for key in rest if key.endswith(("_filter_size", "threshold", "radius"))}
        for name in (key for key, value in rest.items() if key not in known and value is not None):
            tell_inert(f"omni.kit.commands: IsaacSensorCreate{kind}Sensor({name}=...)")
        one = getattr(sensor_prims, kind)(full, **known)
        put(
            one.prims[0],
            translation=(0, 0, 0) if translation is None else list(translation),
            orientation=_quaternion(orientation),
        )
        if period is not None:
            attribute(one.prims[0], "sensorPeriod", "float", float(period))
        return getattr(IsaacSensorSchema, one.kind)(one.prims[0])

    return made


def _range_sensor(
    path: str = "",
    parent: Any = None,
    schema_type: Any = RangeSensorSchema.Lidar,
    translation: Any = (0, 0, 0),
    orientation: Any = (1, 0, 0, 0),
    visibility: bool = False,
    command: str = "RangeSensorCreatePrim",
    **named: Any,
) -> Any:
    """The schema of a new prim: `min_range` is its attribute `minRange`, and so on."""
    from graph.sim.scene.prim_attributes import set_property

    made = schema_type.Define(app().stage, _free(_sensor_path(path, parent)))
    for name, value in named.items():
        first, *others = name.split("_")
        vector = list(value) if isinstance(value, (Gf.Vec3d, Gf.Vec3f)) else value
        try:
            set_property(made.GetPrim(), first + "".join(map(str.capitalize, others)), vector)
        except ValueError:
            tell_inert(f"omni.kit.commands: {command}({name}=...)")
    put(made.GetPrim(), translation=list(translation), orientation=_quaternion(orientation))
    return made


def _range_lidar(path: str = "/Lidar", parent: Any = None, **named: Any) -> Any:
    return _range_sensor(path, parent, **{"high_lod": False, **named}, command="RangeSensorCreateLidar")


def _light_beam(
    path: str = "/LightBeam_Sensor", parent: Any = None, num_rays: int = 1, curtain_length: float = 0.0, **named: Any
) -> Any:
    command = "IsaacSensorCreateLightBeamSensor"
    if num_rays > 1 and not curtain_length:
        warn("command-refused", command, f"num_rays={num_rays} needs a curtain_length above 0; no sensor is made")
        return None
    kind = IsaacSensorSchema.IsaacLightBeamSensor
    rays: dict[str, Any] = {"num_rays": num_rays, "curtain_length": curtain_length}
    return _range_sensor(path, parent, kind, command=command, **rays, **named)


def _delete(paths: Any, destructive: bool = False, **_: Any) -> None:
    for path in paths if isinstance(paths, (list, tuple)) else [paths]:
        app().stage.RemovePrim(str(path))


def _create_prim(
    prim_type: str = "Xform", prim_path: Any = None, attributes: Any = None, select_new_prim: bool = True, **_: Any
) -> Any:
    prim = app().stage.DefinePrim(str(prim_path or _free(f"/{prim_type}")), prim_type)
    for name, value in (attributes or {}).items():
        _change(f"{prim.GetPath()}.{name}", value)
    return prim


def _mesh(prim_type: str = "Cube", prim_path: Any = None, **_: Any) -> Any:
    from .meshes import Mesh

    path = str(prim_path or _free(f"/{prim_type}"))
    Mesh(path, primitives=prim_type)
    return path


def _reference(
    path_to: Any = None, asset_path: str = "", prim_path: Any = None, usd_context: Any = None, **_: Any
) -> Any:
    prim = app().stage.GetPrimAtPath(str(path_to)) or app().stage.DefinePrim(str(path_to), "Xform")
    refer(prim, asset_path)
    return prim


def _change(prop_path: Any, value: Any, prev: Any = None, type_to_create_if_not_exist: Any = None, **rest: Any) -> None:
    owner, _, name = str(prop_path).rpartition(".")
    prim = _prim(owner)
    found = prim.GetAttribute(name)
    if not found and type_to_create_if_not_exist is not None:
        found = prim.CreateAttribute(name, type_to_create_if_not_exist)
    if found:
        found.Set(value)
    elif prim and (relationship := prim.GetRelationship(name)):
        relationship.SetTargets(value)
    else:
        warn("command-unknown", "ChangeProperty", f"there is no property {prop_path}; give type_to_create_if_not_exist")


def _transform(path: Any, new_transform_matrix: Any = None, **_: Any) -> None:
    from graph.sim.transforms import from_usd, quaternion, rigid_part

    matrix = from_usd(new_transform_matrix)
    rigid = rigid_part(matrix)
    scale = np.linalg.norm(matrix[:3, :3], axis=0)
    put(_prim(path), translation=rigid[:3, 3], orientation=quaternion(rigid[:3, :3]), scale=scale)


def _transform_srt(
    path: Any, new_translation: Any = None, new_rotation_euler: Any = None, new_scale: Any = None, **_: Any
) -> None:
    from .transforms import euler_angles_to_quat

    turn = None if new_rotation_euler is None else euler_angles_to_quat(list(new_rotation_euler), degrees=True)
    where = None if new_translation is None else list(new_translation)
    put(_prim(path), translation=where, orientation=turn, scale=None if new_scale is None else list(new_scale))


def _component(usd_prim: Any = None, component: str = "", **_: Any) -> None:
    from graph.sim.scene.prim_attributes import apply_schema

    apply_schema(usd_prim, component)


def _rigid_body(path: Any, approximationShape: str = "convexHull", kinematic: bool = False, **_: Any) -> None:
    from graph.sim.usd import UsdPhysics

    prim = _prim(path)
    UsdPhysics.RigidBodyAPI.Apply(prim).CreateKinematicEnabledAttr().Set(bool(kinematic))
    UsdPhysics.CollisionAPI.Apply(prim)
    if prim.IsA(UsdGeom.Mesh) and approximationShape:
        UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr().Set(approximationShape)


def _bind(prim_path: Any, material_path: Any, **_: Any) -> None:
    from graph.sim.usd import UsdShade

    for path in prim_path if isinstance(prim_path, (list, tuple)) else [prim_path]:
        UsdShade.MaterialBindingAPI.Apply(_prim(path)).Bind(UsdShade.Material(_prim(material_path)))


def _physics_material(kind: str) -> Callable[..., Any]:
    """A physics material at a path; the values that a kind does not have are left out."""
    arguments = {"staticFriction": "static_frictions", "dynamicFriction": "dynamic_frictions", "density": "densities"}
    arguments |= {"restitution": "restitutions"} if kind == "RigidBodyMaterial" else {}
    arguments |= (
        {} if kind == "RigidBodyMaterial" else {"youngsModulus": "youngs_moduli", "poissonsRatio": "poissons_ratios"}
    )

    def made(stage: Any = None, path: Any = "/physicsMaterial", **values: Any) -> bool:
        from . import physics_materials

        given = {arguments[name]: value for name, value in values.items() if name in arguments and value is not None}
        getattr(physics_materials, kind)(str(path), **given)
        return True

    return made


def _mdl_material(mdl_name: str, mtl_name: str = "", mtl_created_list: Any = None, **_: Any) -> None:
    """A material below /Looks whose shader is one of an MDL file, which is not read."""
    from . import visual_materials

    kinds = {"OmniPBR.mdl": "OmniPbrMaterial", "OmniGlass.mdl": "OmniGlassMaterial"}
    path = _free(f"/Looks/{mtl_name or mdl_name.removesuffix('.mdl')}")
    if mdl_name not in kinds:
        warn("material-unknown", mdl_name, f"there are {' and '.join(kinds)}; {path} has no shader")
    getattr(visual_materials, kinds.get(mdl_name, "VisualMaterial"))(path)
    if mtl_created_list is not None:
        mtl_created_list.append(path)


def _preview_material(mtl_path: Any, **_: Any) -> None:
    from . import visual_materials

    visual_materials.PreviewSurfaceMaterial(str(mtl_path))


def _spawn(usd_path: str, prim_path: Any, translation: Any = None, rotation: Any = None, **_: Any) -> Any:
    prim = app().stage.DefinePrim(str(prim_path), "Xform")
    refer(prim, usd_path)
    _teleport(prim_path, translation, rotation)
    return prim


def _teleport(prim_path: Any, translation: Any = None, rotation: Any = None, **_: Any) -> None:
    put(
        _prim(prim_path),
        translation=(0, 0, 0) if translation is None else tuple(translation),
        orientation=(1, 0, 0, 0) if rotation is None else _quaternion(rotation),
    )


def _scale(prim_path: Any, scale: Any = (1, 1, 1), **_: Any) -> None:
    put(_prim(prim_path), scale=tuple(scale))


def _api_schema(prim: Any, api: Any, api_prefix: str = "", multiple_api_token: str = "") -> None:
    api.Apply(prim, multiple_api_token) if multiple_api_token else api.Apply(prim)


def _plane(
    stage: Any = None,
    planePath: str = "/groundPlane",
    axis: str = "Z",
    size: float = 100.0,
    position: Any = None,
    color: Any = None,
    **_: Any,
) -> str:
    from .ground_planes import GroundPlane

    GroundPlane(planePath, sizes=2 * float(size), positions=None if position is None else list(position))
    return planePath


def _copy(path_from: Any, path_to: Any = None, **_: Any) -> str:
    from .usd import duplicate_prim

    to = str(path_to or _free(str(path_from)))
    duplicate_prim(app().stage, path_from, to)
    return to


def _select(new_selected_paths: Any = (), old_selected_paths: Any = (), **_: Any) -> None:
    from .usd import get_context

    get_context().selection.set_selected_prim_paths(list(new_selected_paths))


def _conveyor(prim_name: str = "ConveyorBeltGraph", conveyor_prim: Any = None) -> Any:
    from .conveyors import create_conveyor_belt

    stage = app().stage
    return create_conveyor_belt(stage, conveyor_prim or stage.GetDefaultPrim(), prim_name)


_COMMANDS: dict[str, Callable[..., Any]] = {
    "CreateConveyorBelt": _conveyor,
    "IsaacSensorCreateRtxLidar": _rtx("Lidar", "/RtxLidar"),
    "IsaacSensorCreateRtxRadar": _rtx("Radar", "/RtxRadar"),
    "IsaacSensorCreateRtxUltrasonic": _rtx("Acoustic", "/RtxUltrasonic", "acoustic_rtx"),
    "IsaacSensorCreateRtxAcoustic": _rtx("Acoustic", "/RtxAcoustic", "acoustic_rtx"),
    "IsaacSensorCreateImuSensor": _physics_sensor("IMU", "/Imu_Sensor"),
    "IsaacSensorCreateContactSensor": _physics_sensor("Contact", "/Contact_Sensor"),
    "IsaacSensorCreateLightBeamSensor": _light_beam,
    "RangeSensorCreatePrim": _range_sensor,
    "RangeSensorCreateLidar": _range_lidar,
    "CreateSurfaceGripper": lambda prim_path="", **_: create_surface_gripper(app().stage, str(prim_path)),
    "DeletePrims": _delete,
    "CreatePrim": _create_prim,
    "CreatePrimWithDefaultXform": _create_prim,
    "CreateMeshPrimWithDefaultXform": _mesh,
    "CreateMeshPrim": _mesh,
    "CreateReference": _reference,
    "CreatePayload": _reference,
    "MovePrim": lambda path_from, path_to, **_: move_prim(str(path_from), str(path_to)),
    "CopyPrim": _copy,
    "ChangeProperty": _change,
    "TransformPrim": _transform,
    "TransformPrimSRT": _transform_srt,
    "AddPhysicsComponent": _component,
    "SetRigidBody": _rigid_body,
    "BindMaterial": _bind,
    "ApplyAPISchema": _api_schema,
    "AddGroundPlane": _plane,
    "AddPhysicsScene": lambda path="/physicsScene", **_: app().stage.DefinePrim(str(path), "PhysicsScene"),
    "AddRigidBodyMaterial": _physics_material("RigidBodyMaterial"),
    "AddDeformableMaterial": _physics_material("VolumeDeformableMaterial"),
    "AddSurfaceDeformableMaterial": _physics_material("SurfaceDeformableMaterial"),
    "CreateAndBindMdlMaterialFromLibrary": _mdl_material,
    "CreatePreviewSurfaceMaterialPrim": _preview_material,
    "IsaacSimSpawnPrim": _spawn,
    "IsaacSimTeleportPrim": _teleport,
    "IsaacSimScalePrim": _scale,
    "IsaacSimDestroyPrim": lambda prim_path, **_: _delete([prim_path]),
    "SelectPrims": _select,
}
