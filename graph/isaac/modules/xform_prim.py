"""`XformPrim` of `isaacsim.core.experimental.prims`."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.outcomes import tell_inert
from graph.isaac.results import Result, numbers, result, rows, words
from graph.sim.usd import UsdGeom, UsdShade
from sensors.xform import local_pose

from .prim_base import Prim
from .visual_materials import VisualMaterial
from .xforms import put, world_parts


class XformPrim(Prim):
    def __init__(
        self,
        paths: Any,
        *,
        resolve_paths: bool = True,
        positions: Any = None,
        translations: Any = None,
        orientations: Any = None,
        scales: Any = None,
        reset_xform_op_properties: bool = False,
    ) -> None:
        super().__init__(paths, resolve_paths=resolve_paths)
        if positions is not None and translations is not None:
            raise ValueError("positions (world) and translations (local) exclude each other")
        if reset_xform_op_properties:
            self.reset_xform_op_properties()
        if positions is not None or (orientations is not None and translations is None):
            self.set_world_poses(positions, orientations)
        elif translations is not None:
            self.set_local_poses(translations, orientations)
        if scales is not None:
            self.set_local_scales(scales)

    @property
    def is_non_root_articulation_link(self) -> bool:
        from .prim_utils import is_prim_non_root_articulation_link

        return any(map(is_prim_non_root_articulation_link, self.prims))

    def reset_xform_op_properties(self) -> None:
        for prim in self.prims:
            translation, orientation = local_pose(prim)
            put(prim, translation=translation, orientation=orientation)

    def get_world_poses(self, *, indices: Any = None) -> tuple[Result, Result]:
        found = [world_parts(self.paths[one]) for one in numbers(indices, len(self))]
        return result([one for one, _ in found]), result([one for _, one in found])

    def set_world_poses(self, positions: Any = None, orientations: Any = None, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        places = rows(positions, len(chosen), 3, "positions")
        turns = rows(orientations, len(chosen), 4, "orientations")
        for row, one in enumerate(chosen):
            place = places[row] if places is not None else world_parts(self.paths[one])[0]
            put(self.prims[one], position=place, orientation=None if turns is None else turns[row])

    def get_local_poses(self, *, indices: Any = None) -> tuple[Result, Result]:
        found = [local_pose(self.prims[one]) for one in numbers(indices, len(self))]
        return result([one for one, _ in found]), result([one for _, one in found])

    def set_local_poses(self, translations: Any = None, orientations: Any = None, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        places = rows(translations, len(chosen), 3, "translations")
        turns = rows(orientations, len(chosen), 4, "orientations")
        for row, one in enumerate(chosen):
            put(
                self.prims[one],
                translation=None if places is None else places[row],
                orientation=None if turns is None else turns[row],
            )

    def get_local_scales(self, *, indices: Any = None) -> Result:
        out = []
        for one in numbers(indices, len(self)):
            matrix = np.array(UsdGeom.Xformable(self.prims[one]).GetLocalTransformation())
            out.append(np.linalg.norm(matrix[:3, :3], axis=1))
        return result(out)

    def set_local_scales(self, scales: Any = None, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        given = rows(scales, len(chosen), 3, "scales")
        for row, one in enumerate(chosen):
            put(self.prims[one], scale=None if given is None else given[row])

    def get_visibilities(self, *, indices: Any = None) -> Result:
        found = [UsdGeom.Imageable(self.prims[one]) for one in numbers(indices, len(self))]
        return result([[one.ComputeVisibility() != UsdGeom.Tokens.invisible] for one in found], bool)

    def set_visibilities(self, visibilities: Any, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        for one, seen in zip(chosen, words(visibilities, len(chosen)), strict=True):
            imageable = UsdGeom.Imageable(self.prims[one])
            (imageable.MakeVisible if np.all(seen) else imageable.MakeInvisible)()

    def apply_visual_materials(
        self, materials: Any, *, weaker_than_descendants: Any = None, indices: Any = None
    ) -> None:
        chosen = numbers(indices, len(self))
        for one, material in zip(chosen, words(materials, len(chosen)), strict=True):
            prims = getattr(material, "prims", None) or [getattr(material, "prim", None)]
            if prims[0]:
                UsdShade.MaterialBindingAPI.Apply(self.prims[one]).Bind(UsdShade.Material(prims[0]))
            else:
                tell_inert(f"{type(material).__name__} on {self.paths[one]}")

    def get_applied_visual_materials(self, *, indices: Any = None) -> list[Any]:
        found = [UsdShade.MaterialBindingAPI(self.prims[one]) for one in numbers(indices, len(self))]
        bound = [one.GetDirectBinding().GetMaterial() for one in found]
        return [VisualMaterial.fetch_instances(one.GetPrim())[0] if one else None for one in bound]

    def get_default_state(self, *, indices: Any = None) -> tuple[Any, ...]:
        return self._defaults.get("positions", indices), self._defaults.get("orientations", indices)

    def set_default_state(
        self, positions: Any = None, orientations: Any = None, *_: Any, indices: Any = None, **__: Any
    ) -> None:
        self._defaults.set("positions", positions, 3, indices)
        self._defaults.set("orientations", orientations, 4, indices)

    def reset_to_default_state(self, *, warn_on_non_default_state: bool = False) -> None:
        self._defaults.apply("positions", self.set_world_poses)
        self._defaults.apply("orientations", lambda turns, indices: self.set_world_poses(None, turns, indices=indices))
