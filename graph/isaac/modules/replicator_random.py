"""`get` and `randomizer` of `omni.replicator.core`: prims by path, type and label; what changes them in each frame."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from graph.isaac.outcomes import Refusing
from graph.isaac.session import app
from graph.sim.usd import UsdGeom, UsdShade

from . import prim_utils
from .replicator_draws import CORE, Draw, distribution, drawn, each_frame
from .replicator_prims import Items, Modify, modify, prims_of
from .replicator_scatter import in_volumes, on_surfaces, scatter, units

MISSING_RANDOM = "this randomizer is not here; modify.pose and modify.attribute take distributions"


@contextmanager
def new_layer(name: str | None = None) -> Iterator[Any]:
    """The layer that edits go to: `stop` takes no notice of layers here, so that none of its own is needed."""
    yield app().stage.GetEditTarget().GetLayer()


class Get:
    """`get.prims(semantics=[("class", "box")])`, and `get.camera(...)` for the prims of one type."""

    def prims(
        self,
        path_pattern: str | None = None,
        path_match: str | None = None,
        path_pattern_exclusion: str | None = None,
        prim_types: Any = None,
        prim_types_exclusion: Any = None,
        semantics: Any = None,
        semantics_exclusion: Any = None,
        cache_prims: bool = True,
        ignore_case: bool = True,
        name: str | None = None,
    ) -> Items:
        """The prims that fit everything that is given. path_pattern: a regular expression; path_match: a part of it."""
        flags = re.IGNORECASE if ignore_case else 0

        def fits(prim: Any) -> bool:
            path = str(prim.GetPath())
            kind = str(prim.GetTypeName()).lower()
            return (
                (path_pattern is None or re.search(path_pattern, path, flags) is not None)
                and (path_match is None or path_match in path)
                and (path_pattern_exclusion is None or re.search(path_pattern_exclusion, path, flags) is None)
                and (prim_types is None or kind in _types(prim_types))
                and (prim_types_exclusion is None or kind not in _types(prim_types_exclusion))
                and (semantics is None or _labelled(prim, semantics))
                and (semantics_exclusion is None or not _labelled(prim, semantics_exclusion))
            )

        found = [prim for prim in app().stage.Traverse() if fits(prim)]
        return Items(found, found)

    def prim_at_path(self, path: Any, name: str | None = None) -> Items:
        found = prims_of(path if isinstance(path, (list, tuple)) else str(path))
        return Items(found, found)

    def __getattr__(self, name: str) -> Callable[..., Items]:
        if name.startswith("_"):
            raise AttributeError(name)
        return lambda path_pattern=None, **named: self.prims(
            path_pattern, **{"prim_types": [name.replace("_", "")], **named}
        )


def _types(given: Any) -> set[str]:
    return {str(one).lower() for one in ([given] if isinstance(given, str) else given)}


def _labelled(prim: Any, semantics: Any) -> bool:
    """Whether a prim has one of the labels."""
    pairs = semantics.items() if isinstance(semantics, dict) else semantics
    held = prim_utils.get_labels(prim)
    return any(label in held.get(taxonomy, ()) for taxonomy, label in pairs)


class Randomizer(Refusing):
    """`randomizer.register(function)`; then `randomizer.function()` inside a trigger."""

    def __init__(self, name: str, why: str) -> None:
        super().__init__(name, why)
        self._own: dict[str, Callable[..., Any]] = {}

    def register(self, fn: Callable[..., Any], override: bool = True, fn_name: str | None = None) -> None:
        self._own[fn_name or fn.__name__] = fn

    def __getattr__(self, name: str) -> Any:
        return self.__dict__["_own"].get(name) or super().__getattr__(name)

    def rotation(
        self, min_angle: Any = (-180.0, -180.0, -180.0), max_angle: Any = (180.0, 180.0, 180.0), seed: int | None = None
    ) -> None:
        """Turns the chosen prims about x, y and z by angles [deg] between the two."""
        modify.pose(rotation=distribution.uniform(min_angle, max_angle, seed=seed))

    def materials(self, materials: Any, seed: int | None = None, input_prims: Any = None) -> None:
        """Binds one of the materials, drawn for each prim."""
        given = prims_of(materials) if not isinstance(materials, Draw) else None
        pick = materials if given is None else distribution.choice(given, seed=seed)
        prims = Modify.chosen(input_prims)

        def act() -> None:
            for prim in prims:
                material = prims_of(drawn(pick))[0]
                UsdShade.MaterialBindingAPI.Apply(prim).Bind(UsdShade.Material(material))

        each_frame(act)

    def scatter_2d(
        self,
        surface_prims: Any,
        no_coll_prims: Any = None,
        min_samp: Any = (None, None, None),
        max_samp: Any = (None, None, None),
        seed: int | None = None,
        offset: float = 0.0,
        check_for_collisions: bool = False,
        input_prims: Any = None,
        name: str | None = None,
    ) -> None:
        """Puts the chosen prims at random places on surfaces; min_samp and max_samp bound them."""
        prims, surfaces, obstacles = Modify.chosen(input_prims), prims_of(surface_prims), prims_of(no_coll_prims or [])
        unit = units(seed)

        def act() -> None:
            places = on_surfaces(surfaces, drawn(offset), unit)
            scatter(prims, places, (min_samp, max_samp), obstacles, check_for_collisions)

        each_frame(act)

    def scatter_3d(
        self,
        volume_prims: Any = None,
        no_coll_prims: Any = None,
        volume_excl_prims: Any = None,
        min_samp: Any = (None, None, None),
        max_samp: Any = (None, None, None),
        resolution_scaling: float = 1.0,
        voxel_size: float = 0.0,
        check_for_collisions: bool = False,
        prevent_vol_overlap: bool = True,
        viz_sampled_voxels: bool = False,
        seed: int | None = None,
        input_prims: Any = None,
        name: str | None = None,
    ) -> None:
        """Puts the chosen prims at random places inside volumes; min_samp and max_samp bound them, or are the room."""
        prims, obstacles = Modify.chosen(input_prims), prims_of(no_coll_prims or [])
        volumes, excluded = prims_of(volume_prims or []), prims_of(volume_excl_prims or [])
        limits, unit = (min_samp, max_samp), units(seed)

        def act() -> None:
            places = in_volumes(volumes, excluded, limits, unit)
            scatter(prims, places, limits, obstacles, check_for_collisions)

        each_frame(act)

    def color(self, colors: Any, seed: int | None = None, input_prims: Any = None) -> None:
        """Sets the display colour of the chosen shapes, and of those below them, to a drawn one."""
        pick = colors if isinstance(colors, Draw) else distribution.choice(list(colors), seed=seed)
        shapes = [one for prim in Modify.chosen(input_prims) for one in _shapes(prim)]

        def act() -> None:
            for shape in shapes:
                shape.CreateDisplayColorAttr().Set([tuple(np.asarray(drawn(pick), float).tolist())])

        each_frame(act)


def _shapes(prim: Any) -> list[Any]:
    below = [UsdGeom.Gprim(one) for one in (prim, *prim.GetChildren())]
    return [one for one in below if one]


get = Get()
randomizer = Randomizer(f"{CORE}.randomizer", MISSING_RANDOM)
