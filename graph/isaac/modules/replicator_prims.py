"""`create` and `modify` of `omni.replicator.core`: prims with given or drawn values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, ClassVar

import numpy as np

from graph.isaac.outcomes import Refusing, UnsupportedError
from graph.isaac.session import app
from graph.sim.usd import Usd, UsdGeom, UsdShade

from . import prim_utils
from .meshes import author_mesh
from .replicator_draws import CORE, drawn, each_frame, is_random
from .stage import generate_next_free_path, refer
from .transforms import euler_angles_to_quat, look_at_quaternion
from .visual_materials import OmniPbrMaterial
from .xforms import put, world_parts

RANDOM = "it is not here; draw a value with numpy and set it before each step"
MISSING = "it is not here; author the prims with pxr or isaacsim.core.experimental.objects"
LIGHTS = ("Distant", "Dome", "Sphere", "Rect", "Disk", "Cylinder")
KINDS: dict[str, tuple[str, dict[str, float]]] = {
    "cube": ("Cube", {"size": 1.0}),
    "sphere": ("Sphere", {"radius": 0.5}),
    "cylinder": ("Cylinder", {"radius": 0.5, "height": 1.0}),
    "cone": ("Cone", {"radius": 0.5, "height": 1.0}),
    "plane": ("Plane", {}),
    "disk": ("Disk", {}),
    "torus": ("Torus", {}),
    "xform": ("Xform", {}),
    "scope": ("Scope", {}),
    "camera": ("Camera", {}),
    "omni_lidar": ("OmniLidar", {}),
    "omni_radar": ("OmniRadar", {}),
    **{f"{kind.lower()}_light": (f"{kind}Light", {}) for kind in LIGHTS},
}
"""Each call's type of prim, and the sizes [m] of a shape of scale 1."""
SENSORS = ("OmniLidar", "OmniRadar")
"""Types whose arguments are attributes by their full names."""
MESHES = ("Plane", "Disk", "Torus")
"""Types that become meshes, because USD has no such prims."""
ATTRIBUTES = {
    **{name: f"inputs:{name}" for name in ("intensity", "exposure", "color", "radius", "angle", "length")},
    "temperature": "inputs:colorTemperature",
    "texture": "inputs:texture:file",
    "focal_length": "focalLength",
    "focus_distance": "focusDistance",
    "f_stop": "fStop",
    "horizontal_aperture": "horizontalAperture",
    "horizontal_aperture_offset": "horizontalApertureOffset",
    "vertical_aperture_offset": "verticalApertureOffset",
    "clipping_range": "clippingRange",
}
"""Arguments of lights and cameras, and the attributes that they set."""
SURFACES = {
    "diffuse": "diffuse_color_constant",
    "roughness": "reflection_roughness_constant",
    "metallic": "metallic_constant",
    "specular": "specular_level",
    "emissive_color": "emissive_color",
    "emissive_intensity": "emissive_intensity",
    "emissive_texture": "emissive_color_texture",
    "diffuse_texture": "diffuse_texture",
    "roughness_texture": "reflectionroughness_texture",
    "metallic_texture": "metallic_texture",
    "project_uvw": "project_uvw",
}
"""Arguments of OmniPBR materials, and the inputs that they set."""
DEFAULTS: dict[str, dict[str, Any]] = {"camera": {"clipping_range": (1.0, 1e6)}, "light": {"intensity": 1000.0}}


class Items:
    """Prims that a call of `create` made: `with items:` is where `modify` acts."""

    chosen: ClassVar[list[Items]] = []

    def __init__(self, prims: list[Any], targets: list[Any]) -> None:
        self.prims, self.targets = prims, targets

    def __enter__(self) -> Items:
        Items.chosen.append(self)
        return self

    def __exit__(self, *_: object) -> None:
        Items.chosen.pop()

    def GetPath(self) -> Any:
        return self.targets[0].GetPath()

    @property
    def node(self) -> Items:
        """Itself: randomizers of scripts return the node of what they change."""
        return self

    def get_output_prims(self) -> dict[str, list[Any]]:
        return {"prims": list(self.prims)}


def make(call: str, path: str, options: dict[str, Any]) -> Any:
    """A prim at a path, with attributes of `options`. Raises UnsupportedError for others of them."""
    kind, sizes = KINDS[call]
    if kind in SENSORS:
        authored = getattr(import_module("graph.isaac.modules.sensors_rtx"), kind.removeprefix("Omni"))
        return authored(path, attributes={name: drawn(value) for name, value in options.items()} or None).prim
    stage, unit = app().stage, app().meters_per_unit
    options = {**DEFAULTS.get(call.rpartition("_")[2], {}), **options}
    known = {name: value for name, value in options.items() if name in ATTRIBUTES}
    if left := sorted(options.keys() - known):
        raise UnsupportedError(f"{CORE}: {call}({left[0]}=...): {MISSING}")
    prim = stage.DefinePrim(path, "Mesh" if kind in MESHES else kind)
    if kind in MESHES:
        author_mesh(UsdGeom.Mesh(prim), kind, 1.0 / unit)
    for name, size in sizes.items():
        prim.GetAttribute(name).Set(size / unit)
    for name, value in known.items():
        set_attribute(prim, ATTRIBUTES[name], drawn(value))
    if "temperature" in known:
        prim.GetAttribute("inputs:enableColorTemperature").Set(True)
    return prim


def set_attribute(prim: Any, name: str, value: Any) -> None:
    """Sets an attribute by its name, with or without "inputs:"."""
    found = prim.GetAttribute(name) or prim.GetAttribute(f"inputs:{name}")
    if not found:
        raise ValueError(f"{prim.GetPath()} has no attribute {name}")
    found.Set(tuple(map(float, value)) if isinstance(value, (tuple, list, np.ndarray)) else value)


def pose(
    prim: Any,
    position: Any = None,
    rotation: Any = None,
    scale: Any = None,
    look_at: Any = None,
    look_at_up_axis: Any = None,
) -> None:
    """Puts a prim at a place, turned about x, y and z [deg], or looking at a point or a prim."""
    turn = None if rotation is None else euler_angles_to_quat(np.asarray(rotation, float), degrees=True)
    if look_at is not None:
        path = str(prim.GetPath())
        eye = world_parts(path)[0] if position is None else np.asarray(position, float)
        aims = prims_of(look_at) if not isinstance(look_at, (tuple, list, np.ndarray)) else []
        target = world_parts(str(aims[0].GetPath()))[0] if aims else np.asarray(look_at, float)
        up = look_at_up_axis or ((0, 1, 0) if UsdGeom.GetStageUpAxis(app().stage) == "Y" else (0, 0, 1))
        turn = look_at_quaternion(list(eye), list(target), list(up)).numpy()
    size = None if scale is None else np.broadcast_to(np.asarray(scale, float), 3)
    put(prim, translation=position, orientation=turn, scale=size)


def label(prim: Any, semantics: Any, mode: str = "add") -> None:
    """Adds labels, {"class": "cube"} or [("class", "cube")]; mode "replace" or "clear" removes the former ones."""
    pairs = semantics.items() if isinstance(semantics, Mapping) else semantics or ()
    if mode not in ("add", "replace", "clear"):
        raise ValueError(f'semantics: mode {mode!r} is not "add", "replace" or "clear"')
    if mode != "add":
        for taxonomy, held in prim_utils.get_labels(prim).items():
            prim_utils.remove_labels(prim, labels=held, taxonomy=taxonomy)
    for taxonomy, labels in pairs if mode != "clear" else ():
        prim_utils.add_labels(prim, labels=labels, taxonomy=taxonomy)


def prims_of(given: Any) -> list[Any]:
    """The prims of a prim, a path, an item of `create`, or a list of these."""
    if isinstance(given, (list, tuple)):
        return [prim for one in given for prim in prims_of(one)]
    if isinstance(given, Items):
        return list(given.prims)
    return [given if isinstance(given, Usd.Prim) else app().stage.GetPrimAtPath(str(given))]


def show(prims: Any, shown: Any) -> None:
    """Makes prims visible or invisible."""
    for prim in prims_of(prims):
        one = UsdGeom.Imageable(prim)
        (one.MakeVisible if shown else one.MakeInvisible)()


POSE = ("position", "rotation", "scale", "look_at", "look_at_up_axis")


def posed(prim: Any, options: dict[str, Any]) -> dict[str, Any]:
    """Sets the pose of a new prim; gives the options that are left."""
    given = {name: drawn(options.pop(name)) for name in POSE if name in options}
    if given:
        pose(prim, **given)
    return options


class Create(Refusing):
    """`create.cube(position=..., semantics=[("class", "cube")])`: /Replicator/Cube_Xform/Cube."""

    def __getattr__(self, name: str) -> Any:
        return self._maker(name) if name in (*KINDS, "light", "from_usd") else super().__getattr__(name)

    def material_omnipbr(self, count: int = 1, **options: Any) -> Items:
        """Materials of OmniPBR, with the colour, roughness and metallic that are given or drawn."""
        given = {name: value for name, value in options.items() if value is not None}
        if left := sorted(given.keys() - SURFACES.keys() - {"semantics"}):
            raise UnsupportedError(f"{CORE}: create.material_omnipbr({left[0]}=...): {MISSING}")
        paths = [generate_next_free_path("/Replicator/Looks/OmniPBR", prepend_default_prim=False)]
        paths += [f"{paths[0]}_{number}" for number in range(1, count)]
        made = OmniPbrMaterial(paths)

        def set_inputs() -> None:
            for name in given.keys() & SURFACES.keys():
                for number in range(count):
                    made.set_input_values(SURFACES[name], drawn(given[name]), indices=[number])

        set_inputs()
        if is_random(given.values()):
            each_frame(set_inputs, now=False)
        return Items(made.prims, made.prims)

    def _maker(self, call: str) -> Callable[..., Items]:
        def new(*, count: int = 1, name: str | None = None, parent: Any = None, **options: Any) -> Items:
            given = {key: value for key, value in options.items() if value is not None}
            kind = f"{str(given.pop('light_type', 'distant')).lower()}_light" if call == "light" else call
            address = drawn(given.pop("usd", None)) if call == "from_usd" else None
            kind = "xform" if call == "from_usd" else kind
            if kind not in KINDS:
                raise ValueError(f"light_type {kind.removesuffix('_light')!r} is not one of {', '.join(LIGHTS)}")
            semantics = given.pop("semantics", None)
            visible, material = given.pop("visible", None), prims_of(given.pop("material", []))
            placed = {key: given.pop(key) for key in POSE if key in given}
            under = "/Replicator" if parent is None else str(prims_of(parent)[0].GetPath()).rstrip("/")
            places, targets = [], []
            for _ in range(count):
                path = generate_next_free_path(f"{under}/{KINDS[kind][0]}_Xform", prepend_default_prim=False)
                places.append(app().stage.DefinePrim(path, "Xform"))
                own = name or (KINDS[kind][0] if address is None else "Ref")
                targets.append(make(kind, f"{path}/{own}", dict(given)))
                if address is not None:
                    refer(targets[-1], address, must_exist=False)
                if visible is not None:
                    show(targets[-1:], visible)
                if material:
                    UsdShade.MaterialBindingAPI.Apply(targets[-1]).Bind(UsdShade.Material(material[0]))
                posed(places[-1], dict(placed))
                label(targets[-1], semantics)

            def draw_again() -> None:
                for place, target in zip(places, targets, strict=True):
                    if is_random(placed.values()):
                        posed(place, dict(placed))
                    for key in (key for key in given if is_random([given[key]])):
                        set_attribute(target, ATTRIBUTES[key], drawn(given[key]))

            if is_random((*placed.values(), *given.values())):
                each_frame(draw_again, now=False)
            return Items(places, targets)

        if call != "from_usd":
            return new
        return lambda usd, *, semantics=None, count=1, **options: new(
            usd=usd, semantics=semantics, count=count, **options
        )

    def group(self, items: Any, semantics: Any = None, name: str | None = None) -> Items:
        prims = prims_of(items)
        for prim in prims:
            label(prim, semantics)
        return Items(prims, prims)


class Modify(Refusing):
    """`with items: modify.pose(position=...)`."""

    @staticmethod
    def chosen(given: Any = None) -> list[Any]:
        """The prims of the innermost `with items:`, or the given ones."""
        if given is None and not Items.chosen:
            raise ValueError(f"{CORE}.modify: call it inside `with items:`, or give input_prims")
        return prims_of(Items.chosen[-1] if given is None else given)

    def pose(self, position: Any = None, rotation: Any = None, scale: Any = None, **options: Any) -> None:
        given = {key: value for key, value in options.items() if value is not None}
        prims = self.chosen(given.pop("input_prims", None))
        given.update(position=position, rotation=rotation, scale=scale)

        def act() -> None:
            for prim in prims:
                pose(prim, **{key: drawn(value) for key, value in given.items()})

        each_frame(act)

    def semantics(self, semantics: Any = None, input_prims: Any = None, mode: str = "add") -> None:
        for prim in self.chosen(input_prims):
            label(prim, semantics, mode)

    def attribute(self, name: str, value: Any, attribute_type: Any = None, input_prims: Any = None) -> None:
        prims = self.chosen(input_prims)

        def act() -> None:
            for prim in prims:
                near = (prim, *prim.GetChildren())
                holder = next((one for one in near if one.GetAttribute(name)), prim)
                holder = next((one for one in (holder, *near) if one.GetAttribute(f"inputs:{name}")), holder)
                set_attribute(holder, name, drawn(value))

        each_frame(act)

    def visibility(self, value: Any = None, input_prims: Any = None) -> None:
        prims = self.chosen(input_prims)

        def act() -> None:
            for prim in prims:
                show([prim], drawn(value))

        each_frame(act)


modify = Modify(f"{CORE}.modify", MISSING)
