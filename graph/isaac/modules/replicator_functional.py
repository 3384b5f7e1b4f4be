"""`functional` of `omni.replicator.core`: calls that author prims, or write files, at once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from graph.isaac.outcomes import Refusing
from graph.sim.usd import Sdf, UsdPhysics, UsdShade

from . import replicator_files as files
from .replicator_draws import CORE
from .replicator_prims import KINDS, MISSING, POSE, label, make, pose, posed, prims_of, set_attribute, show
from .replicator_scatter import functional_randomizer
from .stage import generate_next_free_path, refer
from .visual_materials import OmniGlassMaterial, OmniPbrMaterial, VisualMaterial

MATERIALS: dict[str, type[VisualMaterial]] = {"OmniPBR": OmniPbrMaterial, "OmniGlass": OmniGlassMaterial}


class FunctionalCreate(Refusing):
    """`functional.create.cube(position=..., parent="/World", name="Cube")`: a prim with its pose and labels."""

    def __getattr__(self, name: str) -> Any:
        return self._maker(name) if name in (*KINDS, "reference") else super().__getattr__(name)

    def _maker(self, call: str) -> Callable[..., Any]:
        def new(*, name: str | None = None, parent: Any = None, semantics: Any = None, **options: Any) -> Any:
            given = {key: value for key, value in options.items() if value is not None}
            path = _free(parent, name or ("Ref" if call == "reference" else KINDS[call][0]))
            placed = {key: given.pop(key) for key in POSE if key in given}
            address = given.pop("usd_path", None) if call == "reference" else None
            prim = make("xform" if call == "reference" else call, path, given)
            if address is not None:
                refer(prim, address, must_exist=False)
            posed(prim, placed)
            label(prim, semantics)
            return prim

        return new

    def material(
        self, mdl: str, bind_prims: Any = None, name: str | None = None, parent: Any = None, **inputs: Any
    ) -> Any:
        """A material of an MDL file, with inputs of its shader, bound to prims. Returns its prim."""
        word = Path(mdl).stem
        given = {key: value for key, value in inputs.items() if value is not None}
        kind = MATERIALS.get(word)
        if kind is None:
            kinds = {key: _input_kind(value) for key, value in given.items()}
            kind = type(word, (VisualMaterial,), {"inputs": kinds, "identity": ("mdl", word)})
        made = kind(_free("/Looks" if parent is None else parent, name or word))
        if word not in MATERIALS:
            made.shaders[0].SetSourceAsset(Sdf.AssetPath(mdl), "mdl")
        for key, value in given.items():
            made.set_input_values(key, value)
        for prim in prims_of(bind_prims) if bind_prims is not None else ():
            if prim:
                UsdShade.MaterialBindingAPI.Apply(prim).Bind(made.materials[0])
        return made.prims[0]


def _free(parent: Any, name: str) -> str:
    """A free path below a prim or a path; None stands for the root. Raises ValueError for an invalid prim."""
    if parent is None or isinstance(parent, str):
        return generate_next_free_path(f"{(parent or '').rstrip('/')}/{name}", prepend_default_prim=False)
    above = prims_of(parent)[0]
    if not above:
        raise ValueError(f"parent {parent} is not a prim of the stage")
    return generate_next_free_path(f"{above.GetPath()}/{name}", prepend_default_prim=False)


def _input_kind(value: Any) -> str:
    """The type of a shader's input that has such a value."""
    if isinstance(value, (bool, str)):
        return "Bool" if isinstance(value, bool) else "Asset"
    return {2: "Float2", 3: "Color3f"}.get(len(value), "Float") if hasattr(value, "__len__") else "Float"


class FunctionalBatch(Refusing):
    """`functional.create_batch.cube(count=3, ...)`: a list of prims that are alike."""

    def __getattr__(self, name: str) -> Any:
        if name not in (*KINDS, "reference", "material"):
            return super().__getattr__(name)
        one = getattr(FunctionalCreate(f"{CORE}.functional.create", MISSING), name)
        return lambda count=1, **options: [one(**options) for _ in range(count)]


class FunctionalModify(Refusing):
    """`functional.modify.pose(prims, position_value=...)`."""

    def pose(self, prims: Any, **options: Any) -> None:
        for prim in prims_of(prims):
            pose(prim, **{name.removesuffix("_value"): value for name, value in options.items() if value is not None})

    def position(self, prims: Any, value: Any) -> None:
        self.pose(prims, position=value)

    def rotation(self, prims: Any, value: Any) -> None:
        self.pose(prims, rotation=value)

    def scale(self, prims: Any, value: Any) -> None:
        self.pose(prims, scale=value)

    def semantics(self, prims: Any, semantics: Any, mode: str = "add") -> None:
        for prim in prims_of(prims):
            label(prim, semantics, mode)

    def attribute(self, prims: Any, name: str, value: Any) -> None:
        for prim in prims_of(prims):
            set_attribute(prim, name, value)

    def visibility(self, prims: Any, value: Any) -> None:
        show(prims, value)


class FunctionalPhysics(Refusing):
    """`functional.physics.apply_collider(prims)`."""

    def apply_collider(self, prims: Any) -> None:
        for prim in prims_of(prims):
            UsdPhysics.CollisionAPI.Apply(prim)

    def apply_rigid_body(self, prims: Any) -> None:
        for prim in prims_of(prims):
            UsdPhysics.RigidBodyAPI.Apply(prim)


class Functional(Refusing):
    """`omni.replicator.core.functional`: calls that author, or write a file, at once."""

    create = FunctionalCreate(f"{CORE}.functional.create", MISSING)
    create_batch = FunctionalBatch(f"{CORE}.functional.create_batch", MISSING)
    modify = FunctionalModify(f"{CORE}.functional.modify", MISSING)
    physics = FunctionalPhysics(f"{CORE}.functional.physics", MISSING)
    randomizer = functional_randomizer
    write_image = staticmethod(files.write_image)
    write_json = staticmethod(files.write_json)
    write_np = staticmethod(files.write_np)


functional = Functional(f"{CORE}.functional", MISSING)
