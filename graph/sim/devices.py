"""Devices other than the processor: their names, NVIDIA Warp, and the plug-in that computes on them.

Only this file imports Warp.
"""

from __future__ import annotations

import functools
import re
from importlib import import_module
from types import ModuleType
from typing import Any

from graph.base.errors import UserError
from graph.base.extras import install_command
from graph.base.plugins import DEVICES, load
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


def plugin_of(name: str) -> Any:
    """The module that computes on a device, by its name as in the knob `device`.

    It is an entry point of the group `tickgraph.devices`, whose name is the device's up to the colon, and has
    - `device_of(name)`: the device; raises UserError if this machine does not have it
    - `DeviceWorld`, `DeviceLidar`, `DeviceCamera`: casts, frames of lidars and colours of cameras on it
    - `Worlds`: many worlds of one file; `DeviceTwin`: the physics of one world a second time
    - `compare(name)`: the same rays on the device and on the processor, for `graph doctor --device`
    Raises UserError for an invalid name, and for a plug-in that cannot be used.
    """
    check_name(name)
    return load(DEVICES, name.partition(":")[0], ModuleType)


def check_name(name: str) -> None:
    """Raises UserError for an invalid name of a device."""
    if not re.fullmatch(rf"cuda(:\d+)?|{WARP_HOST}", name, re.ASCII):
        raise UserError(f"device {name}: there is no such device; give cuda, cuda:N (N from 0) or {WARP_HOST}")
