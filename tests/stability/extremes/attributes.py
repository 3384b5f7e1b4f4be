"""Values that are not finite in every float attribute of prims, and in configurations: refused, told, or documented."""

from __future__ import annotations

import dataclasses
import math
import re
import tempfile
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from graph.base.errors import UserError
from graph.cli.extreme_cases import GROUND, SENSOR, Case, Prims, body, cube, refusal
from graph.files import loads
from graph.session.open import open_session, option_problems
from graph.sim import App
from graph.sim.fidelity import KNOBS, Fidelity
from graph.sim.scene.physics_settings import ARRAYS, AXES, INSTANCES, RELATIONSHIPS, SIMULATED, TOKENS, VECTORS
from graph.sim.usd import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade
from sensors.lidar.config import EMITTER_FLOATS, EmitterState, LidarConfig
from sensors.lidar.prim import write_config
from sensors.products import render_product
from sensors.sensor_types import sensor_types
from tests.stability.extremes.worlds import mesh

from .clocks import turning
from .inputs import AREA, VALUES, fault, none_of, strict

_DEFAULT: tuple[str, ...] = ("angle", "color", "colorTemperature", "diffuse", "exposure", "intensity", "radius")
_DEFAULT += ("height", "length", "width")
_SHADING: tuple[str, ...] = ("diffuseColor", "emissiveColor", "metallic", "opacity", "opacityThreshold")
_SHADING += ("scale", "bias", "fallback", "st", "in", "translation", "rotation")
_NOT_READ = ("extent", "velocities", "angularVelocities", "accelerations", "clippingPlanes", "shutter:open")

CARRIED: Mapping[str, str] = {
    "primvars:displayColor": "no colour",
    "primvars:displayOpacity": "opaque",
    "normals": "those of the triangles",
    **dict.fromkeys(("cornerSharpnesses", "creaseSharpnesses"), "read for subdivision only"),
    **dict.fromkeys(("physics:breakForce", "physics:breakTorque"), "never breaks"),
    **dict.fromkeys((*_NOT_READ, "shutter:close", "guideRadius", "inputs:specular"), "not read"),
    **dict.fromkeys((f"inputs:{name}" for name in _DEFAULT), "the default of UsdLux"),
    **dict.fromkeys((f"inputs:{name}" for name in _SHADING), "the default of the shader"),
    **dict.fromkeys(("outputs:rgb", "outputs:result"), "not read"),
}
"""Attributes in which a value that is not finite is taken without a word, and what it counts as."""

UNLIMITED = {
    *(f"physics:{name}" for name in ("lowerLimit", "upperLimit", "minDistance", "maxDistance")),
    *(f"physics:coneAngle{number}Limit" for number in (0, 1)),
    *(f"drive:{kind}:physics:maxForce" for kind in ("angular", "linear")),
    *(f"physxJointAxis:{kind}:maxJointVelocity" for kind in ("angular", "linear")),
    *("physxJoint:maxJointVelocity", "newton:velocityLimit"),
}
"""Limits that Inf switches off."""

PIXELS = "pixels.png"
WALL: Prims = {"/Wall": cube(2.0, (5, 0, 0), orient=[1, 0, 0, 0], scale=[1, 1, 1])}
PLACED: dict[str, Any] = {"translate": [0, 0, 0], "rotate": [0, 0, 0], "scale": [1, 1, 1]}
CAMERA = {"type": "Camera", **PLACED, "rotate": [90, 0, -90]}


def _joints() -> dict[str, Any]:
    """A row of bodies, each tied to the next by another kind of joint."""
    kinds = {"Revolute": "angular", "Prismatic": "linear", "Spherical": "", "Distance": "", "Fixed": ""}
    prims: dict[str, Any] = {"/B0": body(0.5, (0, 0, 2), mass=1.0)}
    for number, (kind, drive) in enumerate(kinds.items()):
        prims[f"/B{number + 1}"] = body(0.5, (number + 1, 0, 2), mass=1.0, collision=False)
        ends: dict[str, Any] = {"physics:body0": f"/B{number}", "physics:body1": f"/B{number + 1}"}
        ends |= {"physics:localPos0": [0.5, 0, 0], "physics:localPos1": [-0.5, 0, 0]}
        schemas = [f"PhysicsDriveAPI:{drive}"] if drive else []
        prims[f"/{kind}"] = {"type": f"Physics{kind}Joint", "schemas": schemas, "attributes": ends}
    return prims


STUFF = {"schemas": "PhysicsMaterialAPI", "type": "Material"}
MOVING: dict[str, Any] = {
    "velocity": [0, 0, 0],
    "angular_velocity": [0, 0, 0],
    "orient": [1, 0, 0, 0],
    "scale": [1, 1, 1],
}
SHADERS: dict[str, tuple[str, dict[str, tuple[float, ...]]]] = {
    "Surface": (
        "UsdPreviewSurface",
        {"emissiveColor": (0.1,) * 3, **dict.fromkeys(("metallic", "opacity", "opacityThreshold"), (0.5,))},
    ),
    "Image": ("UsdUVTexture", {"scale": (1.0,) * 4, "bias": (0.0,) * 4, "fallback": (0.5,) * 4}),
    "Placed": ("UsdTransform2d", {"scale": (1.0,) * 2, "translation": (0.0,) * 2, "rotation": (0.0,)}),
    "Read": ("UsdPrimvarReader_float2", {"fallback": (0.0,) * 2}),
}
"""Shaders of a material: the type of each, and its inputs."""

TETRAHEDRON = mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
SOLIDS = ("Cube", "Sphere", "Cylinder", "Capsule", "Cone")
RADAR = {"omni:sensor:WpmDmat:scan:s001:maxAzAngDeg": 5.0, "omni:sensor:WpmDmat:scan:s001:maxElAngDeg": 3.0}

CLOTH = mesh([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], [[0, 1, 2], [0, 2, 3]])
LINE = {"points": [[0, 0, 0], [1, 0, 0], [2, 0, 1]], "curveVertexCounts": [3]}
COPIES = {"prototypes": "/Copies/Cube", "protoIndices": [0, 0, 0]}
COPIES |= {"orientations": [[1, 0, 0, 0]] * 3, "scales": [[1, 1, 1]] * 3}

READERS = {
    "Lidar": ("IsaacReadLidarPointCloud", "lidarPrim"),
    "IsaacLightBeamSensor": ("IsaacReadLightBeam", "lightbeamPrim"),
    "IsaacRaycastSensor": ("IsaacReadRaycastSensor", "raycastSensorPrim"),
    "IsaacImuSensor": ("IsaacReadIMU", "imuPrim"),
    "IsaacContactSensor": ("IsaacReadContactSensor", "csPrim"),
}
"""The nodes that poll sensors without a render product, by the type of the prim, each with its input."""

RAYS = {"numRays": 2, "rayOrigins": [[0, 0, 0], [0, 0, 1]], "rayDirections": [[1, 0, 0], [1, 0, 1]]}
RAYS |= {"rayTimeOffsets": [0.0, 0.01]}

WORLDS: Mapping[str, Prims] = {
    "bodies": {
        **GROUND,
        "/Scene": {"type": "PhysicsScene"},
        "/Stuff": STUFF,
        "/Box": body(0.5, (0, 0, 1), mass=1.0, **MOVING),
        "/Other": body(0.5, (2, 0, 1), attributes={"material:binding:physics": "/Stuff"}),
    },
    "joints": _joints(),
    "a joint of six axes": {
        "/Box": body(0.5, (0, 0, 2), mass=1.0),
        "/Six": {"type": "PhysicsJoint", "attributes": {"physics:body1": "/Box"}},
    },
    "sensors that nodes poll": {
        **WALL,
        **GROUND,
        "/Box": body(0.5, (0, 0, 0.25), mass=1.0),
        **{f"/Box/{kind}": {"type": kind} for kind in ("IsaacImuSensor", "IsaacContactSensor")},
        **{f"/{kind}": {"type": kind, **PLACED} for kind in ("Lidar", "IsaacLightBeamSensor")},
        "/IsaacRaycastSensor": {"type": "IsaacRaycastSensor", "attributes": RAYS, **PLACED},
    },
    "cloth": {"/Cloth": CLOTH},
    "shapes": {
        **{f"/{kind}": {"type": kind, "translate": [3 * n, 0, 0]} for n, kind in enumerate(SOLIDS)},
        "/Mesh": {**TETRAHEDRON, "translate": [-3, 0, 0]},
        "/Plane": {"type": "Plane", "width": 4, "length": 4, "translate": [0, 0, -3]},
        SENSOR: {"type": "OmniLidar", "translate": [0, -5, 0]},
    },
    "lidar": {**WALL, SENSOR: {"type": "OmniLidar", **PLACED}},
    "radar": {**WALL, SENSOR: {"type": "OmniRadar", "attributes": RADAR, **PLACED}},
    "acoustic": {**WALL, SENSOR: {"type": "OmniAcoustic", **PLACED}},
    "camera": {
        **WALL,
        SENSOR: CAMERA,
        **{f"/{kind}": {"type": f"{kind}Light"} for kind in ("Distant", "Dome", "Sphere", "Rect", "Disk", "Cylinder")},
    },
    "camera, materials": {
        "/Wall": mesh([[5, -9, -9], [5, 9, -9], [5, 9, 9], [5, -9, 9]], [[0, 1, 2, 3]]),
        SENSOR: CAMERA,
        "/Sun": {"type": "DistantLight", "rotate": [0, -90, 0], "attributes": {"inputs:intensity": 1000.0}},
        "/Looks": {"type": "Material"},
        **{f"/Looks/{name}": {"type": "Shader"} for name in SHADERS},
    },
    **{
        f"camera, {lens}": {SENSOR: {**CAMERA, "schemas": f"OmniLensDistortion{lens}API"}, **WALL}
        for lens in ("OpenCvPinhole", "OpenCvFisheye", "Ftheta", "KannalaBrandtK3", "RadTanThinPrism")
    },
    "curves, points, copies": {
        "/Curves": {"type": "BasisCurves", "attributes": {"type": "linear", "widths": [0.1], **LINE}},
        "/Points": {"type": "Points", "attributes": {"points": LINE["points"], "widths": [0.1] * 3}},
        "/Copies": {"type": "PointInstancer", "attributes": {**COPIES, "positions": LINE["points"]}},
        "/Copies/Cube": {"type": "Cube", "size": 0.1},
        SENSOR: {"type": "OmniLidar", "translate": [0, -5, 0]},
    },
}


ROLES = {"/Scene": "scene", "/Stuff": "material", "/Box": "body", "/Revolute": "revolute", "/Prismatic": "prismatic"}
ROLES |= {"/Cloth": "soft"}
"""By path, the role of prims in physics whose settings (`SIMULATED`) no schema declares."""

OTHERS = re.compile(r"[eE]nable|disable|locked|flag:|Local|physxMimic|BodyMaterial|selfColl|:fluid")
"""Settings that are numbers to USD and true or false to physics; those of other prims than the ones here."""


def attributes(world: str) -> float:
    """Each float attribute of a world's prims, once with NaN and once with Inf, in a file that is opened and played."""
    with App() as app:
        app.add_prims(WORLDS[world])
        complete(app.stage)
        layer = Sdf.Layer.CreateAnonymous()
        layer.TransferContent(app.stage.GetRootLayer())
    stage, faults, tried = Usd.Stage.Open(layer), [], set[str]()  # one that no App mends
    with strict(), tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.usda"
        Image.new("RGB", (2, 2), "gray").save(Path(folder) / PIXELS)
        text = graph_file(stage, file.name)
        for prim in list(stage.Traverse()):
            for attribute in (*prim.GetAttributes(), *undeclared(prim)):
                name = attribute.GetName()
                one = name if ":" in name else f"{prim.GetTypeName()}.{name}"
                one = f"{prim.GetPath()}.{name}" if prim.GetTypeName() == "Shader" else one
                if one in tried or filled(attribute, math.nan) is None:
                    continue
                tried.add(one)
                authored, before = attribute.HasAuthoredValue(), attribute.Get()
                for value in VALUES:
                    attribute.Set(filled(attribute, value, before))
                    layer.Export(str(file))
                    if found := fault(partial(play, file, text, str(prim.GetPath()), silent(name, value))):
                        faults.append(f"{prim.GetPath()}.{name} = {value}: {found}")
                attribute.Set(before) if authored else attribute.Clear()
    return none_of(faults)


def complete(stage: Any) -> None:
    """Authors what a graph file cannot say: a lidar's own configuration, a joint that follows another."""
    if (prim := stage.GetPrimAtPath(SENSOR)) and prim.GetTypeName() == "OmniLidar":
        write_config(prim, turning("10"))
    if material := stage.GetPrimAtPath("/Looks"):
        dress(material)
    if joint := stage.GetPrimAtPath("/Six"):
        for axis in AXES:
            UsdPhysics.LimitAPI.Apply(joint, axis)
            UsdPhysics.DriveAPI.Apply(joint, axis)
    if cloth := stage.GetPrimAtPath("/Cloth"):
        cloth.AddAppliedSchema("PhysxDeformableSurfaceAPI")
    if joint := stage.GetPrimAtPath("/Revolute"):
        joint.AddAppliedSchema("NewtonMimicAPI")
        joint.CreateRelationship("newton:mimicJoint").SetTargets(["/Prismatic"])


def dress(material: Any) -> None:
    """Gives the wall a surface whose shaders have every input that is read; its colour is an image, placed by st."""
    types, wall = Sdf.ValueTypeNames, material.GetStage().GetPrimAtPath("/Wall")
    st = UsdGeom.PrimvarsAPI(wall).CreatePrimvar("st", types.TexCoord2fArray, "vertex")
    st.Set([(0, 0), (1, 0), (1, 1), (0, 1)])
    for name, (kind, inputs) in SHADERS.items():
        shader = UsdShade.Shader(material.GetChild(name))
        shader.SetShaderId(kind)
        for each, value in inputs.items():
            floats = {1: types.Float, 2: types.Float2, 3: types.Color3f, 4: types.Float4}
            shader.CreateInput(each, floats[len(value)]).Set(value[0] if len(value) == 1 else value)
    surface, image, placed, read = (UsdShade.Shader(material.GetChild(name)) for name in SHADERS)
    read.CreateInput("varname", types.String).Set("st")
    image.CreateInput("file", types.Asset).Set(PIXELS)
    ends = ((surface, "diffuseColor", image, "rgb"), (image, "st", placed, "result"), (placed, "in", read, "result"))
    for end, name, start, output in ends:
        kind = types.Color3f if output == "rgb" else types.Float2
        end.CreateInput(name, kind).ConnectToSource(start.CreateOutput(output, kind))
    shade = UsdShade.Material(material)
    shade.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", types.Token))
    UsdShade.MaterialBindingAPI.Apply(wall).Bind(shade)


def undeclared(prim: Any) -> Iterator[Any]:
    """The settings of physics that work on a prim of this role, as attributes without a value."""
    role = ROLES.get(str(prim.GetPath()))
    for name, roles in SIMULATED.items():
        if role not in roles or name in RELATIONSHIPS | TOKENS | ARRAYS or OTHERS.search(name):
            continue
        if role == "material" and "soft" in roles:  # tried on the cloth itself
            continue
        instance = name.replace("*", INSTANCES.get(role, ("",))[0])
        if not prim.HasProperty(instance):
            types = Sdf.ValueTypeNames
            yield prim.CreateAttribute(instance, types.Vector3f if name in VECTORS else types.Float, False)


def silent(name: str, value: float) -> bool:
    """Whether an attribute may take the value without a word."""
    return name in CARRIED or (math.isinf(value) and name in UNLIMITED)


def play(file: Path, text: str, path: str, silently: bool) -> None:
    """Plays a graph file whose scene has a prim with a value that is not finite.

    Raises ArithmeticError if nothing is said of it.
    """
    with open_session(loads(text, folder=file.parent)).app as app:
        if prim := app.stage.GetPrimAtPath(SENSOR):
            product = render_product(app, SENSOR, (8, 8))
            kind = sensor_types()[str(prim.GetTypeName())]
            product.sensor.require("stability", kind.measures, ignore_aux=True)
        app.play()
        app.update(7)
        if app.physics is not None and not np.isfinite(app.physics.positions).all():
            raise ArithmeticError("bodies have places that are not finite")
        if not silently and not any(path in warning.where for warning in app.warnings):
            raise ArithmeticError("taken without a word")


def graph_file(stage: Any, scene: str) -> str:
    """The text of a graph file of a scene, with a node for each sensor that nodes poll."""
    nodes, wires = ["tick: OnPlaybackTick"], []
    for number, prim in enumerate(stage.Traverse()):
        if reader := READERS.get(str(prim.GetTypeName())):
            nodes.append(f"n{number}: {{type: {reader[0]}, inputs: {{{reader[1]}: {prim.GetPath()}}}}}")
            wires.append(f"tick.tick -> n{number}.execIn")
    graph = f"{{nodes: {{{', '.join(nodes)}}}, connections: [{', '.join(wires)}]}}"
    return f"tickgraph: 1\nscene: {{usd: {scene}}}\nclock: {{loop_hz: 60}}\ngraphs: {{/Readers: {graph}}}\n"


def filled(attribute: Any, value: float, present: Any = None) -> Any:
    """A value of the attribute's type with `value` in all its numbers; None unless it holds floats."""
    kind = attribute.GetTypeName()
    one = kind.scalarType.defaultValue
    if isinstance(one, float):
        filled = value
    elif isinstance(one, Gf.Quatf | Gf.Quatd | Gf.Quath):
        filled = type(one)(value, one.GetImaginary())
    elif isinstance(one, Gf.Matrix4d):
        filled = Gf.Matrix4d(value)
    elif type(one).__name__.startswith("Vec") and type(one).__name__.endswith(("f", "d", "h")):
        filled = type(one)(*[value] * len(one))
    else:
        return None
    return type(kind.defaultValue)([filled] * max(1, len(present or ()))) if kind.isArray else filled


def settings(value: float) -> float:
    """Each field of a lidar's configuration and emitters, each fidelity knob, the clock: those that are taken."""
    config = turning("10")
    makers: dict[str, Callable[[], Any]] = {}
    for field in dataclasses.fields(LidarConfig):
        before = getattr(config, field.name)
        if isinstance(before, float) or (isinstance(before, tuple) and field.name not in NO_FLOATS):
            held = (value,) * max(3, len(before)) if isinstance(before, tuple) else value
            makers[field.name] = partial(dataclasses.replace, config, **{field.name: held})
    for name in EMITTER_FLOATS:
        emitter = EmitterState(**{"azimuth_deg": np.zeros(1), "elevation_deg": np.zeros(1), name: np.array([value])})
        makers[f"emitter {name}"] = partial(dataclasses.replace, config, emitter_states=(emitter,))
    makers |= {name: partial(Fidelity.from_mapping, {name: value}) for name in KNOBS}
    makers |= {name: partial(_clock, name, value) for name in ("physics_hz", "loop_hz")}
    return none_of([name for name, make in makers.items() if not refusal(make)])


NO_FLOATS = ("emitter_states", "num_rays_per_line")


def _clock(name: str, value: float) -> None:
    """A graph file whose clock has the value. Raises UserError with its problems."""
    text = f"tickgraph: 1\nclock: {{{name}: {'.nan' if math.isnan(value) else '.inf'}}}\n"
    if problems := option_problems(loads(text)):
        raise UserError(problems)


CASES = (
    Case(AREA, "NaN and Inf in every float attribute of a scene's prims", 0.0, "flaws",
         "a line, a warning, or documented (tests/stability/extremes/attributes.py)", attributes, tuple(WORLDS)),
    Case(AREA, "NaN and Inf in lidar configurations, knobs, clocks", 0.0, "flaws", "refused", settings, VALUES),
)  # fmt: skip
