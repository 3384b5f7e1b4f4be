"""The devices of NVIDIA Warp: which there are, and what to do if one is missing. Only this file imports Warp."""

from __future__ import annotations

import functools
from importlib import import_module
from typing import Any

from graph.base.errors import UserError
from graph.base.extras import install_command
from graph.base.silence import silenced

HOST = "cpu"
"""The device of an App without Warp: NumPy, Numba and Open3D."""

WARP_HOST = "warp-cpu"
"""Warp's kernels, compiled for the processor: slow, and the same results as on a card but for rounding."""


@functools.cache
def warp() -> Any:
    """The module `warp`, without its greeting. Raises UserError if it is not installed."""
    try:
        found = import_module("warp")
    except ImportError as error:
        raise UserError(f"another device than cpu needs NVIDIA Warp; run: {install_command('gpu')}") from error
    found.config.log_level = found.LOG_ERROR
    found.config.enable_backward = False
    with silenced():  # without a driver, Warp says so in its own words
        found.init()
    return found


def device_of(name: str) -> Any:
    """Warp's device of a value of the knob `device`. Raises UserError if this machine does not have it."""
    wp = warp()
    if name == WARP_HOST:
        return wp.get_device("cpu")
    cards = wp.get_cuda_devices()
    number = int(name.partition(":")[2] or 0)
    if not cards:
        raise UserError(
            f"device {name}: no CUDA device is there, or its driver is missing or too old; "
            "`graph doctor --device` says which, and --device cpu runs without one"
        )
    if number >= len(cards):
        raise UserError(f"device {name}: this machine has {len(cards)} (cuda:0 to cuda:{len(cards) - 1})")
    return cards[number]


def refuse_beyond(device: Any, needed: int, what: str) -> None:
    """Raises UserError if `needed` bytes are more than the free memory of a card."""
    if device.is_cuda and needed > device.free_memory:
        raise UserError(
            f"{what} needs {needed / 2**30:.2f} GiB on {device.name}, which has {device.free_memory / 2**30:.2f} GiB "
            "free; use fewer worlds or rays"
        )
