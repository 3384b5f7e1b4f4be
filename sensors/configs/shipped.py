"""Every shipped sensor configuration, and how one is found by a name."""

from __future__ import annotations

import re
from collections.abc import Iterable

from graph.base.errors import UserError
from graph.base.suggest import did_you_mean
from sensors.radar.configs import ASSETS, RadarAsset

from .cameras import CameraAsset, camera_assets
from .catalog import Asset, Variant, assets

AnyAsset = Asset | CameraAsset | RadarAsset

AXES = "x forward, y left, z up; azimuth counter-clockwise from x, elevation up from the xy plane"
"""Sensor frame of every lidar and radar."""


def all_assets() -> tuple[AnyAsset, ...]:
    """Every shipped configuration: lidars, cameras, radars, each by path."""
    return (*assets(), *camera_assets(), *ASSETS)


def find_asset(name: str) -> tuple[AnyAsset, Variant]:
    """The asset of a name and, for the name of a product, its variant.

    Raises UserError with a similar name or all short names.
    """
    for asset in all_assets():
        if name.casefold() in {spelling.casefold() for spelling in asset.spellings}:
            return asset, None
    for asset in all_assets():
        for product in asset.products:
            if name.casefold() == product.casefold():
                return asset, product
    begun = [asset.short_name for asset in all_assets() if _begins_a_word(name, (asset.short_name, *asset.spellings))]
    names = [spelling for asset in all_assets() for spelling in (*asset.spellings, *asset.products)]
    if begun:
        hint = f"; there {'is' if len(begun) == 1 else 'are'} {', '.join(begun)}"
    else:
        hint = did_you_mean(name, names) or f"; there are {', '.join(asset.short_name for asset in all_assets())}"
    raise UserError(f'no sensor config "{name}"{hint}')


def _begins_a_word(name: str, spellings: Iterable[str]) -> bool:
    """Whether a series (`OS`) or a maker (`Ouster`) is named: the beginning of a word of some spelling."""
    pattern = rf"(?<![^\W_]){re.escape(name)}"
    return len(name) > 1 and any(re.search(pattern, spelling, re.IGNORECASE) for spelling in spellings)
