"""Finds all layers that a scene file would make USD open, and checks them before USD opens them.

A scene may be untrusted. Composing it follows sublayers, references, payloads and value clips to any file of the
machine, and a text layer nested too deeply ends the process inside USD's parser. So every layer is examined first: its
place, its nesting, and the layers that it names.
"""

from __future__ import annotations

import glob
import os
import re
import shlex
import zipfile
import zlib
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from graph.base import asset_roots, limits
from graph.base.errors import Problem, UserError
from graph.base.records import dataclass
from graph.base.shorten import listed

from . import assets
from .assets import StandIn
from .crate import crate_entries, has_path_tree
from .diagnostics import Warn, quiet
from .layer_contents import LayerContents, contents_of
from .layer_text import MAX_NESTING, SCENE_SUFFIXES, depth, longest_text, may_compose, written_prims

Variables = Mapping[str, Any]
"""The variables of a layer stack by name: texts, numbers, truths and lists."""


def stack_variables(layer: Any, above: Variables) -> Variables:
    """The variables of the layer stack with root `layer` (`Sdf.Layer`), overridden by those `above`.

    USD evaluates asset paths such as @`"./${ROBOT}.usda"`@ with them, so the result depends on the path by which a
    layer was reached.
    """
    own = layer.expressionVariables
    return {**own, **above} if own else above


def as_key(variables: Variables) -> str:
    """Equal for equal variables."""
    return repr(sorted((name, repr(value)) for name, value in variables.items())) if variables else ""


def evaluated(asset: str, variables: Variables) -> tuple[str, str]:
    """The path that an asset path evaluates to, and an error message if there is no path.

    A plain path is returned unchanged, without a message. The path is "" if the expression is empty or wrong.
    """
    from graph.sim.usd import Sdf

    if not Sdf.VariableExpression.IsExpression(asset):
        return asset, ""
    result = Sdf.VariableExpression(asset).Evaluate(dict(variables))
    if result.errors:
        return "", f"the variable expression {asset} is wrong: {'; '.join(result.errors)}"
    if result.value is None or result.value == "":
        return "", ""
    if not isinstance(result.value, str):
        return "", f"the variable expression {asset} gives {result.value!r}, which is not a path"
    unset = sorted(set(result.usedVariables) - set(variables))
    why = f"; no expressionVariables give {', '.join(unset)}" if unset else ""
    return result.value, f"{result.value} does not exist (the variable expression {asset}{why})"


@dataclass(frozen=True, slots=True)
class Checked:
    """The layers that a scene may open. While this object exists, opening the scene does not read them again."""

    layers: list[Any]
    files: Mapping[str, tuple[int, int] | None]
    """By layer identifier: device and inode of the file that was checked; None for a stand-in."""
    outside: Sequence[str] = ()
    """Files that it names and may not open; they are muted on the stage before it composes."""

    def confirm(self, stage: Any, before: Iterable[Any] = ()) -> None:
        """Raises UserError if the stage uses a layer (of value clips too) that was not checked.

        `before`: layers that it used already; its own anonymous layers are not files.
        """
        own = {layer.identifier for layer in stage.GetLayerStack() if layer.anonymous}
        own.update(layer.identifier for layer in before)
        for layer in stage.GetUsedLayers(includeClipLayers=True):
            name = layer.identifier
            known = name in self.files and self.files[name] in (None, _identity(layer.realPath))
            if name not in own and not known:
                raise UserError(f"{name}: USD opened this file, which was not checked; the scene is refused")


def _identity(path: str) -> tuple[int, int] | None:
    """Device and inode of a layer's file; None if it has no file."""
    try:
        found = os.stat(_on_disk(path))
    except (OSError, ValueError):
        return None
    return found.st_dev, found.st_ino


def check_scene(
    file: Path,
    roots: Sequence[Path],
    warn: Warn,
    *,
    variables: Variables | None = None,
    sublayer: bool = False,
    skip_outside: bool = False,
) -> Checked:
    """Walks the scene's layers breadth first, and opens only those below one of `roots` (links resolved).

    `variables` are those of the layer stack into which the file is put, as a reference or as a `sublayer`; variable
    expressions in asset paths are followed. Raises UserError with every problem: a missing scene file, a file outside
    the roots, a relative path that leads out of them (whether or not the file exists), an asset path with arguments for
    a file format, a text layer larger than the limits or nested deeper than `MAX_NESTING`, an existing USD file that
    cannot be read, references that multiply beyond the limit. Every other missing asset, or one of another format,
    gives `usd-missing-asset`, a line for each layer. `skip_outside`: files outside the roots are left out, with a line
    `usd-outside-skipped` each, except for value clips.
    """
    from .composed_size import too_many_prims

    if _has_arguments(str(file)):
        raise UserError(f"{file}: USD reads {_ARGUMENTS} in a name as arguments; rename the file or its folder")
    if not file.is_file():
        raise UserError(f"{file}: no such scene file")
    if file.suffix.lower() not in SCENE_SUFFIXES:
        raise UserError(f"{file}: not a USD file; its name must end in {', '.join(SCENE_SUFFIXES)}")
    walk = _Walk([root.expanduser().resolve() for root in roots], warn, skip_outside=skip_outside)
    walk.through(_Wanted(str(file), "", variables or {}, sublayer))
    if walk.problems:
        raise UserError([*walk.problems, *walk.advice()])
    for path, wanted_by in walk.outside.items():
        warn("usd-outside-skipped", path, f"it lies outside the allowed folders ({wanted_by} asks for it); left out")
    for asset, (wanted_by, found) in walk.stand_ins.items():
        code, message = found.note()
        warn(code, asset, f"{message} ({wanted_by} asks for it)")
    for wanted_by, missing in walk.missing.items():
        left_out = "it is" if len(missing) == 1 else "they are"
        warn("usd-missing-asset", wanted_by, f"{listed(list(missing.values()))}; {left_out} left out")
    if any(contents.arcs for contents in walk.contents.values()):
        prims = too_many_prims(walk.layers[str(file)], walk.expressions)
        if prims:
            said = f"{file}: its references multiply into {prims:,} prims or more"
            raise UserError(f"{said}; {limits.allowed('usd.prims')}")
    return Checked(list(walk.layers.values()), walk.files, [path for path in walk.outside if os.path.isabs(path)])


def wanted_assets(file: Path, roots: Sequence[Path]) -> dict[str, tuple[str, str, str]]:
    """What a scene wants from other files, by the asset path as it is written, in the order in which it is met.

    Each with its state (`found`, `stand-in`, `missing`, `outside`), the file or content, and the layer that names it.
    Raises UserError for a scene that cannot be read.
    """
    walk = _Walk([root.expanduser().resolve() for root in roots], lambda *warning: None, skip_outside=True)
    walk.through(_Wanted(str(file), "", {}, False))
    for path, by in walk.outside.items():
        known = next((asset for asset, (_, place, _) in walk.wanted.items() if place == path), path)
        walk.wanted[known] = ("outside", path, by)
    return walk.wanted


@dataclass(frozen=True, slots=True)
class _Wanted:
    """A layer to examine: its path, the layer that names it, the variables of the naming layer stack."""

    path: str
    by: str
    variables: Variables
    sublayer: bool
    """Whether it belongs to the layer stack of the naming layer; otherwise it is the root of its own."""
    clip: bool = False
    """Whether value clips name it."""

    def key(self) -> tuple[str, str, bool]:
        """Equal for requests with an equal result."""
        return self.path, as_key(self.variables), self.sublayer


class _Walk:
    """The layers of a scene, each read once, and followed for every set of variables with which it is reached."""

    def __init__(self, allowed: Sequence[Path], warn: Warn, *, skip_outside: bool = False) -> None:
        self.outside: dict[str, str] = {}
        """Files outside the folders that are left out: path to the layer that names it."""
        self._refused: set[Path] = set()
        """Folders of files outside that are not left out."""
        self._skip_outside = skip_outside
        self.problems: dict[Problem, None] = {}
        self.missing: dict[str, dict[str, str]] = {}
        """By the naming layer: missing assets and their messages."""
        self.layers: dict[str, Any] = {}
        self.files: dict[str, tuple[int, int] | None] = {}
        self.stand_ins: dict[str, tuple[str, StandIn]] = {}
        """By asset path: the layer that names it, and what takes its place."""
        self.contents: dict[str, LayerContents] = {}
        self.expressions: dict[tuple[str, str], set[str]] = {}
        """The results of each variable expression, by the layer that contains it."""
        self.wanted: dict[str, tuple[str, str, str]] = {}
        """By asset path as written: `found`, `stand-in`, `missing` or `outside`; its place; the layer that names it."""
        self._allowed = [*allowed, *asset_roots.present().values()]
        self._warn = warn

    def through(self, first: _Wanted) -> None:
        """Reads everything that `first` leads to. Raises UserError if it cannot be read, or is endless."""
        seen, paths = {first.key()}, {first.path}
        queue = deque([first])
        while queue:
            wanted = queue.popleft()
            if wanted.path not in self.layers and not self._read(wanted):
                continue
            for more in self._asked_by(wanted):
                if more.key() not in seen:
                    seen.add(more.key())
                    paths.add(more.path)
                    queue.append(more)
            if len(seen) > MOST_WAYS * len(paths):
                raise UserError(f"{first.path}: its expression variables make its references multiply; remove some")

    def _read(self, wanted: _Wanted) -> bool:
        """Opens a layer if allowed; else records the reason."""
        path, by = wanted.path, wanted.by
        on_disk = _on_disk(path)
        identity = _identity(path)
        if problem := _outside(on_disk, self._allowed, by):
            self._leave_out(path, problem, by, on_disk.resolve().parent, clip=wanted.clip)
            return False
        if problem := _refused(on_disk, by):
            self.problems[Problem(problem)] = None
            return False
        with quiet(self._warn, path):
            layer, reason = _open_layer(path)
        if layer is not None and identity is not None:
            self.layers[path] = layer
            self.files[layer.identifier] = identity
            contents = contents_of(layer, may_compose(on_disk))
            self.contents[path] = self._redirected(layer, contents) or contents
            return True
        said = reason if reason.startswith(path) else f"{path}: USD cannot read this file; {reason}"
        if not by:
            raise UserError(said)
        if on_disk.suffix.lower() in SCENE_SUFFIXES:
            text = f"{said.rstrip('.')} ({by} asks for it). Repair it, or take out what names it"
            self.problems[Problem(text)] = None
        else:
            self.missing.setdefault(by, {})[path] = f"{path} cannot be read as a USD layer ({reason})"
        return False

    def _redirected(self, layer: Any, contents: LayerContents) -> LayerContents | None:
        """The contents of a layer after its assets were led to mapped files and stand-ins; None if none were."""
        if not any(map(assets.may_be_elsewhere, (*contents.sublayers, *contents.others))):
            return None
        places: dict[str, str] = {}
        for asset in (*contents.sublayers, *contents.others):
            try:
                file = assets.mapped(asset)
            except ValueError as error:
                self.problems[Problem(f"{error} ({layer.identifier} asks for it)")] = None
                continue
            if file is not None:
                places[asset] = str(file)
                self.wanted.setdefault(asset, ("found", str(file), layer.identifier))
            elif found := assets.stand_in(asset):
                places[asset] = found.layer.identifier
                self.files[found.layer.identifier] = None
                self.stand_ins.setdefault(asset, (layer.identifier, found))
                self.wanted.setdefault(asset, ("stand-in", found.what, layer.identifier))
        if not places:
            return None
        from graph.sim.usd import UsdUtils

        UsdUtils.ModifyAssetPaths(layer, lambda asset: places.get(asset, asset))
        return contents_of(layer)

    def advice(self) -> list[Problem]:
        """The command-line option, to be copied, that allows the files refused for their place."""
        folders = [one for one in sorted(self._refused) if one.is_dir()]
        folders = [one for one in folders if not any(other in one.parents for other in folders)]
        if not self._refused:
            return []
        allow = " ".join(f"--allow {shlex.quote(str(one))}" for one in folders)
        give = f"to read what lies outside its folder: {allow}; " if folders else ""
        return [Problem(f"{give}to run without it: --skip-outside", whole=True)]

    def _leave_out(self, path: str, problem: str, by: str, folder: Path, *, clip: bool) -> None:
        """Records a file outside the folders: left out if requested and possible, else a problem."""
        if self._skip_outside and by and not clip:
            self.outside.setdefault(path, by)
        else:
            self.problems[Problem(problem)] = None
            self._refused.add(folder)

    def _asked_by(self, wanted: _Wanted) -> Iterator[_Wanted]:
        """The files that an open layer names."""
        layer, contents = self.layers[wanted.path], self.contents[wanted.path]
        stack = wanted.variables if wanted.sublayer else stack_variables(layer, wanted.variables)
        for named, sublayers in ((contents.sublayers, True), (contents.others, False)):
            for asset in filter(None, named):
                for path in self._files(layer, _on_disk(wanted.path), asset, stack):
                    yield _Wanted(path, layer.identifier, stack, sublayers, asset in contents.clips)

    def _files(self, layer: Any, on_disk: Path, asset: str, variables: Variables) -> list[str]:
        """The existing files of an asset path of a layer; missing ones are recorded."""
        from graph.sim.usd import Ar, Sdf

        if Sdf.Layer.IsAnonymousLayerIdentifier(asset):  # a stand-in
            return []
        plain, complaint = evaluated(asset, variables)
        found: list[str] = []
        if _has_arguments(plain):
            by = f"{plain} ({layer.identifier} asks for it)"
            self.problems[Problem(f"{by}: arguments for a file format are not read; take out {_ARGUMENTS}")] = None
        elif plain:
            anchored = Sdf.ComputeAssetPathRelativeToLayer(layer, plain)
            if "#" in plain:
                # A template of clips may match no file, but outside the folders its existence must not be revealed.
                found = [one for one in glob.glob(re.sub("#+", "*", glob.escape(anchored))) if not _has_arguments(one)]
                if not found and (problem := _climbs_out(plain, on_disk, self._allowed, layer.identifier)):
                    self._leave_out(
                        plain, problem, layer.identifier, (on_disk.parent / plain).resolve().parent, clip=True
                    )
                return found
            found = [resolved for resolved in [str(Ar.GetResolver().Resolve(anchored))] if resolved]
            if found and plain is not asset:
                self.expressions.setdefault((layer.identifier, asset), set()).update(found)
            elif not found and (problem := _climbs_out(plain, on_disk, self._allowed, layer.identifier)):
                self._leave_out(plain, problem, layer.identifier, (on_disk.parent / plain).resolve().parent, clip=False)
            elif not found:
                empty = assets.emptied(layer, asset) if asset_roots.is_address(plain) else ""
                complaint = complaint or " ".join(filter(None, (assets.not_here(plain), empty)))
        if found and all(found[0] != place for _, place, _ in self.wanted.values()):
            self.wanted[asset] = ("found", found[0], layer.identifier)
        if complaint and not found:
            self.wanted.setdefault(asset, ("missing", assets.looked_for(plain, on_disk.parent), layer.identifier))
            self.missing.setdefault(layer.identifier, {})[asset] = complaint
        return found


_ARGUMENTS = ":SDF_FORMAT_ARGS:"
"""The part of an asset path that USD removes, with everything after it, before it looks for the file."""


def _has_arguments(asset: str) -> bool:
    """Whether USD would open another file than the asset path names."""
    from graph.sim.usd import Sdf, Tf

    if _ARGUMENTS in asset:
        return True
    try:
        return bool(Sdf.Layer.SplitIdentifier(asset)[0] != asset)
    except Tf.ErrorException:
        return True


def _on_disk(path: str) -> Path:
    """The file of a layer's path, also for a path inside a package."""
    from graph.sim.usd import Ar

    return Path(Ar.SplitPackageRelativePathOuter(path)[0] if Ar.IsPackageRelativePath(path) else path)


MOST_WAYS = 100
"""The average number of ways in which a layer may be reached, if variables distinguish them."""


def _climbs_out(asset: str, layer: Path, allowed: Sequence[Path], wanted_by: str) -> str | None:
    """A relative path that leads out of the folders; the reaction must not reveal whether the file exists."""
    if ".." not in asset.replace("\\", "/").split("/") or re.match(r"[A-Za-z][A-Za-z0-9+.-]*:|[/\\]", asset):
        return None
    if any((layer.parent / asset).resolve().is_relative_to(root) for root in allowed):
        return None
    folders = ", ".join(map(str, allowed)) or "no folder"
    return f"{asset} leads out of {folders} ({wanted_by} asks for it). Allow its folder with --allow DIR"


def _open_layer(path: str) -> tuple[Any, str]:
    """The layer, or None and the reason."""
    from graph.sim.usd import Sdf, Tf

    try:
        layer = Sdf.Layer.FindOrOpen(path)
        if layer is not None:
            layer.Reload()  # USD keeps layers for the life of the process, but the file may have been written again
        return layer, "it is damaged or of another kind"
    except Tf.ErrorException as error:
        try:
            text = str(error.args[0])
        except UnicodeDecodeError:
            return None, "it is not UTF-8 text"
        reason = " ".join(text.rpartition(" : ")[2].split()).strip("' ")
        if reason.endswith("is not a valid usda layer"):
            return None, 'it is not USD text, which starts with "#usda 1.0"'
        # The parser's messages contain C++ types of its grammar.
        return None, re.sub(r"parse error matching .*pxrInternal.* at (?=')", "no USD text goes on like this: ", reason)


def _outside(path: Path, allowed: Sequence[Path], wanted_by: str) -> str | None:
    """Why a file may not be read because of its place, or None."""
    real = path.resolve()
    if any(real.is_relative_to(root) for root in allowed):
        return None
    by = f" ({wanted_by} asks for it)" if wanted_by else ""
    folders = ", ".join(map(str, allowed)) or "no folder"
    return f"{path} lies outside {folders}{by}. Move it there, or allow its folder with --allow DIR"


def _refused(path: Path, wanted_by: str) -> str | None:
    """Why a file may not be read because of its content, or None."""
    real = path.resolve()
    by = f" ({wanted_by} asks for it)" if wanted_by else ""
    try:
        if longest_text(real) > limits.most("usd.text"):
            return f"{path} is too much USD text{by}; save it as .usdc; {limits.allowed('usd.text')}"
        prims = written_prims(real)
        if prims > limits.most("usd.prims"):
            return f"{path} has about {prims:,} prims{by}; {limits.allowed('usd.prims')}"
        entries = crate_entries(real)
        if entries > limits.most("usd.entries"):
            return f"{path} says that it has {entries:,} entries{by}; {limits.allowed('usd.entries')}"
        if not has_path_tree(real):
            return f"{path} is damaged{by}: its table of paths is not a tree; repair it"
        deep = depth(real) > MAX_NESTING
    except (OSError, RuntimeError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        return f"{path} cannot be read: {error}"
    return f"{path} nests deeper than {MAX_NESTING} levels{by}; USD cannot read it safely" if deep else None
