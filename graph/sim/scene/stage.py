"""Opens a USD stage safely, and restores it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from graph.base.errors import RunError, UserError
from graph.base.records import dataclass

from .diagnostics import Warn as Warn
from .diagnostics import ignore_warning as ignore_warning
from .stage_metadata import NEW_STAGE_RANGE, NEW_STAGE_TIME_CODES


def register_schemas() -> None:
    """Registers the prim types and API schemas of sensors and graphs with USD. Call it before any stage is used.

    TickGraph's own functions do so themselves; only code that opens a stage through pxr first needs this call. USD
    fixes its schema registry at first use and silently ignores later additions, so this raises RunError then.
    """
    from graph.sim.usd import Usd

    if not Usd.SchemaRegistry().FindAppliedAPIPrimDefinition("OmniSensorAPI"):
        raise RunError(
            "USD was used before the sensor schemas were registered, so their prim types are unknown to it. "
            "Call graph.sim.register_schemas() before the first stage is opened or created"
        )


def open_stage(
    path: str | Path | None = None,
    allow_roots: Iterable[str | Path] | None = None,
    warn: Warn = ignore_warning,
    *,
    skip_outside: bool = False,
) -> Any:
    """A stage (`Usd.Stage`) over the scene at `path`; without a path an empty one in metres, Z up.

    An empty one has time codes from 0 to 100, 60 a second, as a new stage of Isaac Sim; the timeline does not end
    there. A file and everything it composes is checked first (see `graph.sim.scene.layers.check_scene`): only files
    below `allow_roots` (default: the scene's own folder) are opened.
    Raises UserError for what must not or cannot be opened;
    a missing reference is only a warning `usd-missing-asset`, and with `skip_outside` so is one that leads out of the
    folders (`usd-outside-skipped`).

    The root layer is anonymous and has the scene as its sublayer: what is authored later stays with this stage and
    never reaches the file, nor another stage in the same process.
    """
    register_schemas()
    from graph.sim.usd import Sdf, Usd, UsdGeom

    root = Sdf.Layer.CreateAnonymous(f"{Path(path or 'world').stem}.usda")
    if path is None:
        stage = Usd.Stage.Open(root)
        UsdGeom.SetStageMetersPerUnit(stage, UsdGeom.LinearUnits.meters)
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        stage.SetTimeCodesPerSecond(NEW_STAGE_TIME_CODES)
        stage.SetStartTimeCode(NEW_STAGE_RANGE[0])
        stage.SetEndTimeCode(NEW_STAGE_RANGE[1])
        return stage
    from .diagnostics import quiet
    from .layer_text import leave_out_path_values
    from .layers import check_scene
    from .stage_faults import check_metadata, repair_transforms, tell_assumed_units, tell_other_units

    file = Path(path).expanduser().absolute()
    roots = [file.parent] if allow_roots is None else [Path(each) for each in allow_roots]
    # Kept while the stage opens, so that nothing is parsed twice.
    checked = check_scene(file, roots, warn, skip_outside=skip_outside)
    leave_out_path_values(checked.layers, warn)
    with quiet(warn, str(path)):
        scene = Sdf.Layer.FindOrOpen(str(file))
        if scene is None:
            raise UserError(f"{path}: USD cannot read this file")
        _copy_metadata(scene, root)
        if not checked.outside:
            root.subLayerPaths.append(scene.identifier)
        stage = Usd.Stage.Open(root)
        if checked.outside:  # muted before anything composes: USD does not open them
            stage.MuteAndUnmuteLayers(list(checked.outside), [])
            root.subLayerPaths.append(scene.identifier)
        checked.confirm(stage)
    check_metadata(stage)
    tell_assumed_units(stage, warn)
    tell_other_units(stage, warn)
    repair_transforms(stage, warn)
    return stage


def add_scene(
    stage: Any, path: Path, roots: Iterable[str | Path], warn: Warn = ignore_warning, *, skip_outside: bool = False
) -> None:
    """Puts a USD file over the stage's present files, checked as in `open_stage`; units stay."""
    from graph.sim.usd import Sdf

    from .diagnostics import quiet
    from .layer_text import leave_out_path_values
    from .layers import check_scene

    variables = stage.GetRootLayer().expressionVariables
    folders = [Path(each) for each in roots]
    checked = check_scene(path, folders, warn, variables=variables, sublayer=True, skip_outside=skip_outside)
    leave_out_path_values(checked.layers, warn)
    with quiet(warn, str(path)):
        layer = Sdf.Layer.FindOrOpen(str(path))
        if layer is None:
            raise UserError(f"{path}: USD cannot read this file")
        before = stage.GetUsedLayers()
        stage.MuteAndUnmuteLayers(list(checked.outside), [])
        stage.GetRootLayer().subLayerPaths.insert(0, layer.identifier)
        checked.confirm(stage, before)


def _copy_metadata(scene: Any, root: Any) -> None:
    """Copies units, up axis, time codes and default prim, which count only in the root layer."""
    for key in scene.pseudoRoot.ListInfoKeys():
        if key not in ("subLayers", "subLayerOffsets", "primOrder", "primChildren"):
            try:
                root.pseudoRoot.SetInfo(key, scene.pseudoRoot.GetInfo(key))
            except TypeError:  # the text format accepts any value
                wrong = scene.pseudoRoot.GetInfo(key)
                raise UserError(f"{scene.identifier}: its {key} cannot be {wrong!r}; correct its metadata") from None


@dataclass
class _Saved:
    layer: Any
    copy: Any | None


class StageState:
    """The content of a stage's layers, to be restored bit for bit.

    Layers that are files and were not changed are read again on `restore` if they changed since; all others are copied.
    """

    def __init__(self, stage: Any) -> None:
        from graph.sim.usd import Sdf

        self._stage = stage
        self._target = stage.GetEditTarget()
        self._saved = []
        for layer in stage.GetUsedLayers():
            copy = None
            if layer.anonymous or layer.dirty:
                copy = Sdf.Layer.CreateAnonymous(layer.GetDisplayName())
                copy.TransferContent(layer)
            self._saved.append(_Saved(layer, copy))

    def restore(self) -> None:
        """Restores the content of every layer; may be called any number of times."""
        from graph.sim.usd import Sdf

        with Sdf.ChangeBlock():
            for saved in self._saved:
                if saved.copy is not None:
                    saved.layer.TransferContent(saved.copy)
        for saved in self._saved:
            if saved.copy is None and saved.layer.dirty:
                saved.layer.Reload(True)
        self._stage.SetEditTarget(self._target)
