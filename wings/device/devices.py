"""The devices of NVIDIA Warp: which there are, and what to do if one is missing or full."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from graph.base.errors import UserError
from graph.sim.devices import WARP_HOST, check_name, warp


def device_of(name: str) -> Any:
    """Warp's device of a value of the knob `device`. Raises UserError if this machine does not have it."""
    check_name(name)
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
