"""The devices of NVIDIA Warp: which there are, and what to do if one is missing. Only this file imports Warp."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator
from contextlib import contextmanager
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


def same_device(name: str, other: str) -> bool:
    """Whether two names are of one device; "cuda" is the first card."""
    return name.replace("cuda:0", "cuda") == other.replace("cuda:0", "cuda")


def device_of(name: str) -> Any:
    """Warp's device of a value of the knob `device`. Raises UserError if this machine does not have it."""
    if name != WARP_HOST and not re.fullmatch(r"cuda(:\d+)?", name, re.ASCII):
        raise UserError(f"device {name}: there is no such device; give cuda, cuda:N (N from 0) or {WARP_HOST}")
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


@contextmanager
def allocating(device: Any, what: str) -> Iterator[None]:
    """Raises UserError, with the bytes, if memory of a device is not enough for what is made inside."""
    try:
        yield
    except RuntimeError as error:
        missing = re.match(r"Failed to allocate (\d+) bytes", str(error))
        if missing is None:
            raise
        raise UserError(
            f"{what} need {int(missing[1]) / 2**30:.2f} GiB more on {device.name} than there is; use fewer worlds, or "
            "less room for contacts and rows"
        ) from error


def refuse_beyond(device: Any, needed: int, what: str) -> None:
    """Raises UserError if `needed` bytes are more than the free memory of a card."""
    if device.is_cuda and needed > device.free_memory:
        raise UserError(
            f"{what} needs {needed / 2**30:.2f} GiB on {device.name}, which has {device.free_memory / 2**30:.2f} GiB "
            "free; use fewer worlds or rays"
        )
