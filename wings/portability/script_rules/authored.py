"""What a script authors on the stage, as far as its syntax tree tells: sensor prims, attributes, render products."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from typing import Any

from graph.base.records import dataclass, field
from graph.isaac.syntax import Script
from graph.sim.scene.prim_paths import is_path

from .reading import argument

SENSORS = "isaacsim.sensors.experimental.rtx."
LIDAR, RADAR, CAMERA = "OmniLidar", "OmniRadar", "Camera"
CLASSES = {
    "Lidar": LIDAR,
    "LidarSensor": LIDAR,
    "Radar": RADAR,
    "RadarSensor": RADAR,
    "RtxCamera": CAMERA,
    "CameraSensor": CAMERA,
}
"""Classes that make or wrap a prim, by their last name; those of `RENDERING` render it too."""
RENDERING = ("LidarSensor", "RadarSensor", "CameraSensor", "LidarRtx")
COMMANDS = {"IsaacSensorCreateRtxLidar": LIDAR, "IsaacSensorCreateRtxRadar": RADAR}
SCHEMAS = {
    LIDAR: ["OmniSensorAPI", "OmniSensorGenericLidarCoreAPI"],
    RADAR: ["OmniSensorAPI", "OmniSensorGenericRadarWpmDmatAPI"],
    CAMERA: ["OmniSensorAPI"],
}
"""What the classes apply to the prims that they make."""
TICK_RATE = "omni:sensor:tickRate"
ACCUMULATES = "omni:sensor:Core:accumulateOutputs"
MADE_RATE = 10.0
"""Hz of a lidar that a class makes without a rate: the default of its schema in 6.0."""
LOOKS_UP = ("GetPrimAtPath", "get_prim_at_path")
SETTERS = ("set_prim_attribute_value", "set_prim_property")
BODIES = ("RigidPrim", "SingleRigidPrim", "Articulation", "SingleArticulation", "DynamicCuboid", "DynamicSphere")
"""Classes whose prims are, or have, rigid bodies."""
WRAPPERS = ("XformPrim", "XFormPrim", "SingleXFormPrim", "GeomPrim", "SingleGeometryPrim", *BODIES)
ASKING = ("initialize", "attach", "attach_annotator", "attach_writer")
"""Methods of annotators, writers and sensors that ask for outputs."""
ONLY_IN_A_RUN = "/unknown_"
"""What paths begin with that stand for those that only a run knows."""
UNKNOWN = object()
"""The value of an attribute that only a run knows."""


@dataclass(slots=True)
class AuthoredPrim:
    """A sensor prim. values: of its attributes, and places: where they are written; options: keys of an inline prim."""

    path: str
    type: str
    place: ast.AST
    values: dict[str, Any] = field(default_factory=dict)
    options: dict[str, Any] = field(default_factory=dict)
    places: dict[str, ast.AST] = field(default_factory=dict)
    uncertain: bool = False
    """Whether attributes may be set that only a run knows."""
    asked: list[tuple[ast.AST, tuple[str, ...]]] = field(default_factory=list)
    """Where a render product of it is made, or outputs of it are asked for, with their names."""

    def write(self, name: str, value: Any, place: ast.AST) -> None:
        """Sets an attribute."""
        self.values[name], self.places[name] = value, place


class Authoring:
    """The sensor prims of a script by path, in the order in which it makes them.

    elsewhere: names of attributes that the script writes on prims which it does not make, or not by a name known here.
    """

    def __init__(self, script: Script) -> None:
        self.script = script
        self.prims: dict[str, AuthoredPrim] = {}
        self.elsewhere: set[str] = set()
        self._made: dict[int, str] = {}
        self._paths: dict[str, str] = {}
        self._attributes: dict[str, ast.Call] = {}
        self._outputs: dict[str, tuple[str, ...]] = {}
        for body in script.bodies():
            for node in body:
                self._read(node)

    def _read(self, node: ast.AST) -> None:
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            self._name(node.targets[0], node.value)
        elif isinstance(node, ast.Call):
            self.path_of(node)
            self._write(node)

    def _name(self, target: ast.expr, value: ast.expr) -> None:
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple) and len(target.elts) == len(value.elts):
            for one, its in zip(target.elts, value.elts, strict=True):
                self._name(one, its)
        elif isinstance(target, ast.Tuple) and len(target.elts) == 2:  # (success, prim) of a command
            target = target.elts[1]
        if not isinstance(target, ast.Name):
            return
        self._attributes.pop(target.id, None)
        if isinstance(value, ast.Call) and _method(value) in ("GetAttribute", "CreateAttribute", "GetAttributeAtPath"):
            self._attributes[target.id] = value
        elif path := self.path_of(value):
            self._paths[target.id] = path
        else:
            self._paths.pop(target.id, None)

    # -- prims ---------------------------------------------------------------------------------------------------------

    def path_of(self, node: ast.AST) -> str:
        """The path of the prim that an expression stands for, or that it renders; "" if it stands for none."""
        while isinstance(node, ast.Await | ast.Subscript | ast.Attribute):
            node = node.value
        if isinstance(node, ast.Name):
            return self._paths.get(node.id, "")
        if not isinstance(node, ast.Call):
            return ""
        if id(node) not in self._made:
            self._made[id(node)] = ""  # of one that names itself, or nests too deeply
            with suppress(RecursionError):
                self._made[id(node)] = self._called(node)
        return self._made[id(node)]

    def target_of(self, node: ast.AST | None) -> str:
        """The path of a prim that is given as a prim, a path or a list of one."""
        if isinstance(node, ast.List | ast.Tuple) and len(node.elts) == 1:
            node = node.elts[0]
        if node is None:
            return ""
        return self.path_of(node) or self._path(node)

    def _path(self, node: ast.AST | None) -> str:
        """The path that an expression writes out; of one that only a run knows, a path that stands for it."""
        found = self.script.value_of(node)
        if isinstance(found, list) and len(found) == 1:
            found = found[0]
        if isinstance(found, str):
            return f"/{found.strip('/')}"
        return f"{ONLY_IN_A_RUN}{re.sub('[^0-9A-Za-z]', '_', _text(node))}" if node else ""

    def _called(self, call: ast.Call) -> str:
        name, method = self.script.name_of(call.func), _method(call)
        if method in LOOKS_UP:
            return self._path(argument(call, 0, "path"))
        if method == "GetPrim" and isinstance(call.func, ast.Attribute):
            return self.path_of(call.func.value)
        if method in ("DefinePrim", "define_prim", "create_prim"):
            kind = _first(call, 1, "type_name", "prim_type", "typeName")
            prim = self._make(call, _first(call, 0, "path", "prim_path"), kind)
            for key, value in self._dict(argument(call, 99, "attributes")):
                self._set(prim, key, value, call)
            return prim
        if name.endswith("Camera.Define"):
            return self._make(call, argument(call, 1, "path"), CAMERA)
        if name == "omni.kit.commands.execute":
            return self._command(call)
        if name.startswith(SENSORS) and (made := CLASSES.get(name.removeprefix(SENSORS).removesuffix(".create"))):
            return self._class(call, argument(call, 0, "path"), made)
        if method == "LidarRtx":
            return self._class(call, argument(call, 0, "prim_path"), LIDAR, config="config_file_name")
        if method in WRAPPERS:
            return self._path(_first(call, 0, "prim_path", "prim_paths_expr", "paths", "path"))
        if method in ("render_product", "create_render_product") or name.endswith("create.render_product"):
            path = self.target_of(argument(call, 0, "camera"))
            self._render(path, call)
            return path
        return self.path_of(call.args[0]) if name.startswith("pxr.") and len(call.args) == 1 else ""

    def _make(self, call: ast.Call, where: ast.AST | None, kind: ast.AST | str | None) -> str:
        text = kind if isinstance(kind, str) else self.script.value_of(kind)
        path = self._path(where)
        if text in SCHEMAS and is_path(path):
            self.prims[path] = AuthoredPrim(path, text, call)
        return path

    def _command(self, call: ast.Call) -> str:
        name = str(self.script.value_of(argument(call, 0, "name"))).removesuffix("Command")
        if name == "ChangeProperty":
            path, _, attribute = self._path(argument(call, 99, "prop_path")).partition(".")
            self._set(path, attribute, argument(call, 99, "value"), call)
        if (kind := COMMANDS.get(name)) is None:
            return ""
        above = self.script.value_of(argument(call, 99, "parent"))
        where = argument(call, 99, "path")
        path = self._class(call, where, kind, parent=above.rstrip("/") if isinstance(above, str) else "")
        for one in call.keywords:
            if one.arg is None:  # **{"omni:sensor:...": value}
                for key, value in self._dict(one.value):
                    self._set(path, key, value, call)
        return path

    def _class(
        self, call: ast.Call, where: ast.AST | None, kind: str, *, config: str = "config", parent: str = ""
    ) -> str:
        """The prim of an authoring class: made with the schemas of its type, or wrapped."""
        path = parent + (self.target_of(where) or f"/{kind}")
        if not is_path(path):
            return ""
        new = path not in self.prims
        prim = self.prims.setdefault(path, AuthoredPrim(path, kind, call))
        if new:
            prim.options["schemas"] = [*SCHEMAS[kind]]
            if kind == LIDAR:
                prim.values |= {TICK_RATE: MADE_RATE, ACCUMULATES: True}
            self._configure(prim, call, config)
        for keyword, name in (("tick_rate", TICK_RATE), ("accumulate_outputs", ACCUMULATES)):
            if (value := argument(call, 99, keyword)) is not None and not _is_none(value):
                self._set(path, name, value, call)
        if (level := argument(call, 99, "aux_output_level")) is not None:
            prim.options["aux_output_level"] = self.script.value_of(level) or "NONE"
            prim.uncertain |= self.script.value_of(level) is None
        for key, value in self._dict(argument(call, 99, "attributes")):
            self._set(path, key, value, call)
        if _method(call) in RENDERING:
            self._render(path, call)
        return path

    def _configure(self, prim: AuthoredPrim, call: ast.Call, keyword: str) -> None:
        """Notes the configuration; of an asset its name, as the sensor classes take it."""
        named, asset = argument(call, 99, keyword), argument(call, 99, "usd_path")
        texts = [str(one.value) for one in ast.walk(asset) if isinstance(one, ast.Constant)] if asset else []
        config = self.script.value_of(named) or next((one for one in texts if "/Sensors/" in one), None)
        if isinstance(config, str):
            prim.options["config"] = config.rpartition("/")[2].partition(".")[0]
            variant = self.script.value_of(argument(call, 99, "variant"))
            if isinstance(variant, str | dict):
                prim.options["variant"] = variant
            prim.values.pop(TICK_RATE, None)
        elif named is not None or asset is not None:
            prim.uncertain = True

    def _dict(self, node: ast.AST | None) -> Iterator[tuple[str, ast.expr]]:
        if isinstance(node, ast.Name):
            node = self.script.values.get(node.id)
        if isinstance(node, ast.Dict):
            for key, value in zip(node.keys, node.values, strict=True):
                if isinstance(name := self.script.value_of(key), str):
                    yield name, value

    # -- attributes ----------------------------------------------------------------------------------------------------

    def _write(self, call: ast.Call) -> None:
        method = _method(call)
        owner = call.func.value if isinstance(call.func, ast.Attribute) else None
        if method == "Set" and owner is not None and call.args:
            attribute = self._attributes.get(owner.id) if isinstance(owner, ast.Name) else owner
            if isinstance(attribute, ast.Call):
                self._set(*self._attribute(attribute), call.args[0], call)
        elif method in SETTERS:
            name = _first(call, 1, "name", "attribute_name", "property_name")
            value = _first(call, 2, "value", "property_value")
            self._set(self.target_of(call.args[0]) if call.args else "", self.script.value_of(name), value, call)
        elif method in ASKING:
            self._ask(call, method, owner)
        elif method in ("ApplyAPI", "AddAppliedSchema") and owner is not None and call.args:
            schema, prim = self.script.value_of(call.args[0]), self.prims.get(self.path_of(owner))
            if prim is not None and isinstance(schema, str):
                prim.options.setdefault("schemas", []).append(schema)

    def _ask(self, call: ast.Call, method: str, owner: ast.expr | None) -> None:
        """Notes the outputs that an annotator or writer asks for, and of which prim."""
        switches = (one.arg or "" for one in call.keywords if self.script.value_of(one.value) is True)
        names = tuple(name for name in switches if name.startswith("output"))
        metadata = self.script.value_of(argument(call, 99, "selectedMetadata"))
        names += tuple(map(str, metadata)) if isinstance(metadata, list | tuple) else ()
        held = owner.id if isinstance(owner, ast.Name) else ""
        if method == "initialize" and held:
            self._outputs[held] = names
        elif method == "attach" and call.args:
            names += self._outputs.get(held, ())
            self._ask_of(self.target_of(call.args[0]), names, call)
        elif owner is not None:
            self._ask_of(self.path_of(owner), names, call)

    def _ask_of(self, path: str, names: tuple[str, ...], place: ast.AST) -> None:
        if names and path in self.prims:
            self.prims[path].asked.append((place, names))

    def _attribute(self, call: ast.Call) -> tuple[str, Any]:
        """The prim path and the name (None: only a run knows it) of the attribute that a call gives."""
        name = self.script.value_of(call.args[0]) if call.args else None
        if _method(call) == "GetAttributeAtPath":
            path, _, attribute = str(name).partition(".")
            return path, attribute
        owner = call.func.value if isinstance(call.func, ast.Attribute) else None
        return self.path_of(owner) if owner is not None else "", name

    def _set(self, path: str, name: Any, value: ast.AST | None, place: ast.AST) -> None:
        found = self.script.value_of(value)
        if path in self.prims and not isinstance(name, str):
            self.prims[path].uncertain = True
        elif path in self.prims:
            self.prims[path].write(name, UNKNOWN if found is None else found, place)
        elif isinstance(name, str):
            self.elsewhere.add(name)

    def _render(self, path: str, place: ast.AST) -> None:
        if path in self.prims:
            self.prims[path].asked.append((place, ()))


@lru_cache(maxsize=1)
def authored_by(script: Script) -> Authoring:
    """The sensor prims of a script, read once for all rules."""
    return Authoring(script)


def named(text: str) -> str:
    """A finding's text with "a prim" for paths that only a run knows."""
    return re.sub(rf"{ONLY_IN_A_RUN}\w+", "a prim", text)


def _text(node: ast.AST) -> str:
    """The beginning of an expression; of one that nests too deeply, its line."""
    try:
        return ast.unparse(node)[:60]
    except RecursionError:
        return f"line_{getattr(node, 'lineno', 0)}"


def _first(call: ast.Call, position: int, *names: str) -> ast.expr | None:
    """An argument of a call that has one of several names, by the versions of its function."""
    given = (argument(call, position, name) for name in names)
    return next((one for one in given if one is not None), None)


def _is_none(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _method(call: ast.Call) -> str:
    """The last name of what is called."""
    return call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
