"""Augmentations of `omni.replicator.core`: functions that change the arrays of annotators."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from graph.isaac.outcomes import UnsupportedError

from .replicator_draws import CORE, triggers

Change = Callable[[np.ndarray], Any]
_HUES = (0, 85, 171)
"""Of pure red, green and blue, in 8 bits."""
_SIXTH = 43


def rgb_to_hsv(data_in: np.ndarray) -> np.ndarray:
    """Hue, saturation and value of 8-bit colours, in 8 bits each."""
    colours = data_in[..., :3].astype(int)
    value, span = colours.max(axis=-1), np.ptp(colours, axis=-1)
    which = colours.argmax(axis=-1)[..., None]
    after, last = (np.take_along_axis(colours, (which + step) % 3, axis=-1)[..., 0] for step in (1, 2))
    hue = np.take(_HUES, which[..., 0]) + _SIXTH * (after - last) // np.maximum(span, 1)
    return _with(data_in, np.where(span > 0, hue, 0), 255 * span // np.maximum(value, 1), value)


def hsv_to_rgb(data_in: np.ndarray) -> np.ndarray:
    """The colours of hue, saturation and value, all in 8 bits."""
    hue, saturation, value = (data_in[..., index].astype(int) for index in range(3))
    sixth = np.minimum(hue // _SIXTH, 5)
    rest = (hue - sixth * _SIXTH) * 6
    low = value * (255 - saturation) >> 8
    falling = value * (255 - (saturation * rest >> 8)) >> 8
    rising = value * (255 - (saturation * (255 - rest) >> 8)) >> 8
    low, falling, rising = (np.where(saturation == 0, value, one) for one in (low, falling, rising))
    shades = [(value, rising, low), (falling, value, low), (low, value, rising)]
    shades += [(low, falling, value), (rising, low, value), (value, low, falling)]
    return _with(data_in, *(np.choose(sixth, [one[index] for one in shades]) for index in range(3)))


def _with(data: np.ndarray, *channels: np.ndarray) -> np.ndarray:
    """The array with other values in its first channels."""
    out = data.copy()
    for index, one in enumerate(channels):
        out[..., index] = one.astype(data.dtype)
    return out


augmentations_default = SimpleNamespace(aug_rgb_to_hsv=rgb_to_hsv, aug_hsv_to_rgb=hsv_to_rgb)
_AUGMENTATIONS: dict[str, Any] = {
    "RgbaToRgb": lambda pixels: pixels[..., :3],
    "RgbToHsv": rgb_to_hsv,
    "HsvToRgb": hsv_to_rgb,
}
_REMEDY = "Warp kernels do not run here; give a function"


def _augmentation(function: Any, **options: Any) -> Any:
    return partial(function, **options) if callable(function) else function


class Augmentation:
    """`Augmentation.from_function(f)`, for `annotator.augment`."""

    from_function = staticmethod(_augmentation)


def register_augmentation(name: str, augmentation: Any) -> None:
    _AUGMENTATIONS[name] = augmentation


def get_augmentation(name: str) -> Any:
    return _AUGMENTATIONS[name]


def augmentation_of(given: Any, options: dict[str, Any]) -> Change:
    """An augmentation with those options that it takes; a seed of None or below 0 is drawn from the global one.

    Raises UnsupportedError unless it is a function or the name of one.
    """
    change = _AUGMENTATIONS.get(given) if isinstance(given, str) else given
    if not callable(change):
        raise UnsupportedError(f"{CORE}.annotators.augment {given!r}: {_REMEDY}")
    known = inspect.signature(change).parameters
    chosen = {name: value for name, value in options.items() if name in known}
    seed = {**getattr(change, "keywords", {}), **chosen}.get("seed", 0)
    if seed is None or seed < 0:
        chosen["seed"] = triggers().seed + triggers().count_draw()
    return partial(change, **chosen)


def changed(data: np.ndarray, change: Change) -> Any:
    """Changed data; those of pictures keep their type."""
    found = change(np.array(data))
    is_picture = data.dtype == np.uint8 and isinstance(found, np.ndarray)
    return found.astype(np.uint8) if is_picture else found
