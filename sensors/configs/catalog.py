"""The shipped lidar configurations: compact data files, found by any of their spellings."""

from __future__ import annotations

import functools
import json
from collections.abc import Iterator, Mapping, Sequence
from functools import reduce
from itertools import product
from pathlib import Path, PurePosixPath
from types import NoneType
from typing import Any

from graph.base.errors import UserError
from graph.base.inputs import start_of
from graph.base.records import dataclass
from graph.base.suggest import nearest
from sensors.lidar.attributes import config_from_attributes
from sensors.lidar.config import LidarConfig
from sensors.lidar.names import PRIM_TYPE

from .beams import emitter_states
from .spelling import short_name, spellings


@dataclass(frozen=True, slots=True)
class Entry:
    """One variant: its name (text, or a choice for each variant set), and its changes of the base."""

    variant: str | dict[str, str] | None
    base: Mapping[str, Any]
    changes: tuple[Mapping[str, Any], ...] = ()

    @property
    def document(self) -> Mapping[str, Any]:
        """The document of this variant."""
        return reduce(merged, self.changes, self.base)


def entries(document: Mapping[str, Any]) -> Iterator[Entry]:
    """Every variant, in order; a single one without a name if the document has no `sets`.

    `sets`: set name -> {choice: changes}. A choice may restrict the choices of other sets (`with`: {set: [choices]}).
    `named` joins the choices to one name: "OS0_{Model}ch{Mode}res".
    """
    sets: Mapping[str, Mapping[str, Any]] = document.get("sets", {})
    if not sets:
        yield Entry(None, document)
        return
    for choices in product(*sets.values()):
        chosen = dict(zip(sets, choices, strict=True))
        changes = tuple(sets[name][choice] for name, choice in chosen.items())
        together = (each for change in changes for each in change.get("with", {}).items())
        if all(chosen[name] in allowed for name, allowed in together):
            yield Entry(document["named"].format(**chosen) if "named" in document else chosen, document, changes)


def merged(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with `changes` applied: objects are merged, anything else is replaced."""
    out = dict(base)
    for key, value in changes.items():
        known = out.get(key)
        out[key] = merged(known, value) if isinstance(known, Mapping) and isinstance(value, Mapping) else value
    return out


LARGEST = 1 << 24
"""Bytes of a data file of this package, at most."""

Variant = str | Mapping[str, str] | None


@dataclass(frozen=True, slots=True)
class Asset:
    """One data file: its asset path, further names, and its variants."""

    path: str
    aliases: tuple[str, ...]
    entries: tuple[Entry, ...]
    source: str = ""
    """The source of its figures."""
    default: Any = None
    """The variant used if the user names none; None is the first."""
    prim_type: str = PRIM_TYPE
    """Type of the sensor prims that it configures."""

    @property
    def variants(self) -> tuple[Any, ...]:
        """The values of `variant=`: names, or {set: name} mappings; empty if there is only one form."""
        return tuple(entry.variant for entry in self.entries if entry.variant is not None)

    @property
    def spellings(self) -> tuple[str, ...]:
        """Asset path, file stem, stem without the vendor, both with spaces for underscores; then further names."""
        return spellings(self.path, self.aliases)

    @property
    def short_name(self) -> str:
        """The name used in messages."""
        return short_name(self.path, self.aliases)

    @property
    def products(self) -> tuple[str, ...]:
        """Names that determine a variant: variants that are text, and choices of the set `Product`."""
        names = [v if isinstance(v, str) else v.get("Product", "") for v in self.variants]
        return tuple(dict.fromkeys(filter(None, names)))

    def config(self, variant: Variant = None) -> LidarConfig:
        """The configuration of a variant. Raises UserError with the existing variants."""
        document = self._entry(variant).document
        states, derived = emitter_states(document)
        return config_from_attributes({**document["core"], **derived}, states, name=PurePosixPath(self.path).stem)

    def figures(self, variant: Variant = None) -> dict[str, Any]:
        """What one variant is like, as `graph sensors` lists it."""
        from .figures import summary

        return summary(self.config(variant))

    def _entry(self, variant: Variant) -> Entry:
        """The entry of a variant; if a mapping leaves sets out, the first (or the default) that fits."""
        if not variant:
            return next((entry for entry in self.entries if entry.variant == self.default), self.entries[0])
        wanted = variant if isinstance(variant, str) else dict(variant)
        fitting = [entry for entry in self.entries if _fits(entry.variant, wanted)]
        if fitting:
            return next((entry for entry in fitting if entry.variant == self.default), fitting[0])
        raise UserError(f"lidar config {self.path} has no variant {wanted!r}{self._hint(wanted)}")

    def _hint(self, wanted: str | dict[str, str]) -> str:
        """Similar names if any, else all names."""
        if not self.variants:
            return "; it has no variants"
        sets: dict[str, list[str]] = {}
        for variant in self.variants:
            for name, choice in ({"sensor": variant} if isinstance(variant, str) else variant).items():
                if choice not in sets.setdefault(name, []):
                    sets[name].append(choice)
        if isinstance(wanted, str):
            return f": {_offer(wanted, [choice for choices in sets.values() for choice in choices])}"
        for name, choice in wanted.items():
            if name not in sets:
                return f"; its variant sets are {', '.join(sets)}"
            if choice not in sets[name]:
                return f": {_offer(str(choice), sets[name])}"
        name, choice = next(iter(wanted.items()))
        beside = [
            ", ".join(v for k, v in entry.items() if k != name) for entry in self.variants if entry[name] == choice
        ]
        return f": {choice} goes with {'; '.join(beside)}"


def _offer(wrong: str, names: Sequence[str]) -> str:
    close = _close(wrong, names)
    return f"did you mean {' or '.join(close)}?" if close else f"there are {', '.join(names)}"


def _close(wrong: str, names: Sequence[str]) -> list[str]:
    """Up to three names similar to a wrong one, without regard to case."""
    folded = {name.lower(): name for name in reversed(names)}
    return [folded[near] for near in nearest(wrong.lower(), folded, 3)]


def _fits(variant: Any, wanted: str | dict[str, str]) -> bool:
    if isinstance(variant, str):
        return wanted in (variant, {"sensor": variant})
    if variant is None:
        return False
    if isinstance(wanted, str):
        return wanted in variant.values()
    return all(variant.get(name) == choice for name, choice in wanted.items())


@functools.cache
def assets() -> tuple[Asset, ...]:
    """Every shipped asset, ordered by path."""
    documents = shipped("data")
    found = []
    for document in documents.values():
        if "base" in document:
            document = merged(documents[document["base"]], document)
        names = tuple(document.get("aliases", ()))
        found.append(
            Asset(document["asset"], names, tuple(entries(document)), document["source"], document.get("default"))
        )
    return tuple(sorted(found, key=lambda asset: asset.path.lower()))


def shipped(folder: str) -> dict[str, Any]:
    """The JSON documents in a folder of this package, by the names of their files."""
    here = Path(__file__).parent / folder
    return {path.stem: json.loads(start_of(path, LARGEST)) for path in here.iterdir() if path.suffix == ".json"}


def supported() -> dict[str, list[Any]]:
    """Asset path -> variants: the table SUPPORTED_LIDAR_CONFIGS."""
    return {asset.path: list(asset.variants) for asset in assets()}


def find(config: str, variant: Variant = None) -> LidarConfig:
    """The shipped configuration of this name; the name of a variant or of a product is accepted too.

    Raises UserError with up to three similar names, or the short names of all.
    """
    for asset in assets():
        if config in asset.spellings:
            return asset.config(variant)
    for asset in assets():
        if config in asset.products:
            return asset.config({"Product": config, **variant} if isinstance(variant, Mapping) else variant or config)
    names = [name for asset in assets() for name in (*asset.spellings, *asset.products)]
    close = _close(config, names if " " in config else [name for name in names if " " not in name])
    short = ", ".join(asset.short_name for asset in assets())
    hint = f"did you mean {' or '.join(close)}?" if close else f"there are {short};"
    raise UserError(f"no lidar config {config!r}; {hint} `graph sensors` lists all")


def load(config: str, variant: Variant = None, *, base: Path | None = None, roots: Sequence[Path] = ()) -> LidarConfig:
    """A configuration by shipped name, or from a vendor profile by the path of its .json file.

    A relative path starts at `base` (else the working directory); with `roots` the file must lie below one of them.
    Raises UserError.
    """
    if not isinstance(config, str):
        raise UserError("a lidar config is text: a name, or the path of a profile's .json file")
    if not isinstance(variant, (str, Mapping, NoneType)):
        raise UserError("a variant is text, or a mapping from variant sets to choices")
    if not config.lower().endswith(".json"):
        return find(config, variant)
    from sensors.lidar.vendor import load_profile

    if variant:
        raise UserError(f"lidar config {config}: a profile file has no variants")
    path = (base / config if base is not None else Path(config)).resolve()
    if roots and not any(path.is_relative_to(Path(root).resolve()) for root in roots):
        raise UserError(f"lidar config {config}: outside the file's folder; allow it with --allow {path.parent}")
    return load_profile(path)
