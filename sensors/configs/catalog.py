"""The lidar configurations that ship: compact data files, found by any of their spellings."""

from __future__ import annotations

import difflib
import functools
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from importlib import resources
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from graph.errors import UserError
from sensors.lidar.attributes import config_from_attributes
from sensors.lidar.config import EMITTER_INTEGERS, EmitterState, LidarConfig
from sensors.lidar.names import snake_case

Variant = str | Mapping[str, str] | None


@dataclass(frozen=True, slots=True)
class Asset:
    """One data file: the asset path it answers to, further names, and its variants (the first is the default)."""

    path: str
    aliases: tuple[str, ...]
    document: Mapping[str, Any]

    @property
    def variants(self) -> tuple[Any, ...]:
        """What `variant=` may be: names, or {set: name} mappings."""
        return tuple(entry["variant"] for entry in self.document.get("variants", ()))

    @property
    def spellings(self) -> tuple[str, ...]:
        """Asset path, file stem, stem without the vendor, both with spaces for underscores; then further names."""
        path = PurePosixPath(self.path)
        vendor = path.relative_to("/Isaac/Sensors").parts[0]
        short = path.stem.removeprefix(f"{vendor}_")
        names = (self.path, path.stem, path.stem.replace("_", " "), short, short.replace("_", " "), *self.aliases)
        return tuple(dict.fromkeys(names))

    def config(self, variant: Variant = None) -> LidarConfig:
        """The configuration of a variant. Raises UserError naming the variants there are."""
        entry = self._variant_entry(variant)
        core = {**self.document["core"], **entry.get("core", {})}
        states = [dict(state) for state in self.document["emitterStates"]]
        for state, changes in zip(states, entry.get("emitterStates", ()), strict=False):
            state.update(changes)
        arrays = tuple(_emitter_state(state) for state in states)
        return config_from_attributes(core, arrays, name=PurePosixPath(self.path).stem)

    def _variant_entry(self, variant: Variant) -> Mapping[str, Any]:
        entries: list[Mapping[str, Any]] = list(self.document.get("variants", ()))
        if variant is None or variant == "" or variant == {}:
            return entries[0] if entries else {}
        wanted = variant if isinstance(variant, str) else dict(variant)
        for entry in entries:
            if entry["variant"] == wanted or (isinstance(wanted, dict) and wanted == {"sensor": entry["variant"]}):
                return entry
        there = ", ".join(map(str, self.variants)) or "none"
        raise UserError(f"lidar config {self.path} has no variant {variant!r}; variants: {there}")


@functools.cache
def assets() -> tuple[Asset, ...]:
    """Every shipped asset, ordered by path."""
    found = []
    for file in resources.files(__package__).joinpath("data").iterdir():
        if file.name.endswith(".json"):
            document = json.loads(file.read_text(encoding="utf-8"))
            found.append(Asset(document["asset"], tuple(document.get("aliases", ())), document))
    return tuple(sorted(found, key=lambda asset: asset.path))


def supported() -> dict[str, list[Any]]:
    """Asset path -> variants: the table SUPPORTED_LIDAR_CONFIGS."""
    return {asset.path: list(asset.variants) for asset in assets()}


def find(config: str, variant: Variant = None) -> LidarConfig:
    """The shipped configuration of this name. A variant's own name is a spelling too.

    Raises UserError with up to three close matches, the short names, and the table that lists them all.
    """
    for asset in assets():
        if config in asset.spellings:
            return asset.config(variant)
        if config in asset.variants and variant is None:
            return asset.config(config)
    names = [name for asset in assets() for name in (*asset.spellings, *filter(_is_text, asset.variants))]
    close = difflib.get_close_matches(config, names, n=3, cutoff=0.6)
    hint = f"; did you mean {' or '.join(close)}?" if close else "."
    short = ", ".join(asset.aliases[0] if asset.aliases else min(asset.spellings, key=len) for asset in assets())
    raise UserError(f"no lidar config {config!r}{hint} There are: {short} (see SUPPORTED_LIDAR_CONFIGS)")


def load(config: str, variant: Variant = None, *, base: Path | None = None, roots: Sequence[Path] = ()) -> LidarConfig:
    """A configuration by shipped name, or from a vendor profile by the path of its .json file.

    A relative path starts at `base` (else the working directory); with `roots` the file must lie below one of them.
    Raises UserError.
    """
    if not config.lower().endswith(".json"):
        return find(config, variant)
    from sensors.lidar.vendor import load_profile

    if variant:
        raise UserError(f"lidar config {config}: a profile file has no variants")
    path = (base / config if base is not None else Path(config)).resolve()
    if roots and not any(path.is_relative_to(Path(root).resolve()) for root in roots):
        raise UserError(f"lidar config {config}: outside the file's folder; allow it with --allow {path.parent}")
    return load_profile(path)


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _emitter_state(arrays: Mapping[str, Any]) -> EmitterState:
    fields: dict[str, np.ndarray] = {}
    for key, spec in arrays.items():
        name, values = snake_case(key), _expand(spec)
        whole = name in EMITTER_INTEGERS
        fields[name] = np.array([math.floor(value) if whole else float(value) for value in values])
    return EmitterState(**fields)


def _expand(spec: Any) -> list[Fraction]:
    """A list of numbers, or the short forms {first, step, count[, modulo]}, {each, times}, {repeat, times}."""
    if isinstance(spec, Mapping):
        if "each" in spec:
            return [value for value in _expand(spec["each"]) for _ in range(spec["times"])]
        if "repeat" in spec:
            return _expand(spec["repeat"]) * int(spec["times"])
        first, step = Fraction(str(spec["first"])), Fraction(str(spec["step"]))
        values = [first + step * index for index in range(spec["count"])]
        return [value % spec["modulo"] for value in values] if "modulo" in spec else values
    return [Fraction(str(value)) for value in spec]
