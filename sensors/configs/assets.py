"""Layers for the sensor assets of Isaac Sim (`/Isaac/Sensors/...`), from the built-in configurations."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import PurePosixPath
from typing import Any

from graph.sim.scene.assets import StandIn

from . import author_config
from .cameras import camera_assets
from .catalog import assets


def stand_in(tail: str) -> StandIn | None:
    """The layer for a sensor asset by its path from `/Isaac/` on; None for an unknown sensor.

    Its variants are those of the original. An asset `.usda` is the sensor itself; another has it below an Xform.
    """
    from graph.sim.scene.stage import register_schemas
    from graph.sim.usd import Usd, UsdGeom

    known: list[tuple[str, tuple[str, ...], Any, str]] = [
        *((one.path, one.spellings, one, one.prim_type) for one in assets()),
        *((one.path, (), one, "Camera") for one in camera_assets()),
    ]
    found = [one for one in known if one[0].lower() == tail.lower()]
    found = found or [one for one in known if PurePosixPath(tail).stem in one[1]]
    if not found:
        return None
    path, _, asset, prim_type = found[0]
    register_schemas()
    name = PurePosixPath(path).stem
    stage = Usd.Stage.CreateInMemory(f"{name}.usda")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    itself = PurePosixPath(tail).suffix == ".usda"
    root = stage.DefinePrim(f"/{name}", prim_type if itself else "Xform")
    sensor = root if itself else stage.DefinePrim(f"/{name}/sensor", prim_type)
    stage.SetDefaultPrim(root)
    for variant in asset.variants or (None,):
        _author(root, sensor, path, variant)
    chosen = asset.default if asset.default is not None else next(iter(asset.variants), None)
    for name, choice in _choices(chosen).items():
        root.GetVariantSet(name).SetVariantSelection(choice)
    return StandIn.of(stage, f"the built-in configuration {asset.short_name}", exact=True)


def _choices(variant: Any) -> Mapping[str, str]:
    """Variant set -> variant."""
    return variant if isinstance(variant, Mapping) else {"sensor": variant} if variant else {}


def _author(root: Any, sensor: Any, path: str, variant: Any) -> None:
    """Authors a configuration in its variant: in variants within each other where there are several sets."""
    from graph.sim.usd import Sdf, Usd

    with ExitStack() as inside:
        for name, choice in _choices(variant).items():
            chosen = root.GetVariantSets().AddVariantSet(name)
            chosen.AddVariant(choice)
            chosen.SetVariantSelection(choice)
            inside.enter_context(chosen.GetVariantEditContext())
        scratch = Usd.Stage.CreateInMemory()
        author_config(scratch.DefinePrim("/sensor", sensor.GetTypeName()), path, variant)
        stage = root.GetStage()
        stage.OverridePrim(sensor.GetPath())
        place = stage.GetEditTarget().MapToSpecPath(sensor.GetPath())
        Sdf.CopySpec(scratch.GetRootLayer(), "/sensor", stage.GetRootLayer(), place)
