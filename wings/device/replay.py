"""Work on a device that is the same for every frame: recorded once, then replayed by one call."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from graph.sim.devices import warp

ALIGNED = 16
"""Every input begins at a multiple of so many bytes."""


class Replay:
    """Launches and copies of `work`, which always uses the same arrays.

    The first call runs it, which loads its kernels; the second records it; all later ones replay the record. recorded:
    False runs it every time, for work whose arrays change.
    """

    def __init__(self, device: Any, work: Callable[[], None], *, recorded: bool = True) -> None:
        self._device, self._work, self._recorded = device, work, recorded
        self._warm = False
        self._graph: Any = None

    def __call__(self) -> None:
        """Does the work, or has the device repeat it; it may not be done yet."""
        wp = warp()
        if self._graph is not None:
            wp.capture_launch(self._graph)
        elif not (self._warm and self._recorded):
            self._work()
            self._warm = True
        else:
            with wp.ScopedCapture(device=self._device) as capture:
                self._work()
            self._graph = capture.graph
            wp.capture_launch(self._graph)


class Inputs:
    """Arrays that change from frame to frame and are brought to a device by one copy.

    fields: name -> Warp's type of the elements, and the shape. host: NumPy arrays to write to; there: Warp arrays.
    """

    def __init__(self, device: Any, fields: dict[str, tuple[Any, tuple[int, ...]]]) -> None:
        wp = warp()
        begins, size = {}, 0
        for name, (kind, shape) in fields.items():
            begins[name] = size
            size += -(-wp.types.type_size_in_bytes(kind) * int(np.prod(shape)) // ALIGNED) * ALIGNED
        self._host = host_array(device, size, wp.uint8)
        self._there = wp.zeros(size, dtype=wp.uint8, device=device)
        self.host: dict[str, np.ndarray] = {}
        self.there: dict[str, Any] = {}
        for name, (kind, shape) in fields.items():
            for arrays, block in ((self.host, self._host), (self.there, self._there)):
                view = wp.array(ptr=block.ptr + begins[name], dtype=kind, shape=shape, device=block.device)
                view.owner = block  # keeps the memory while the view is alive
                arrays[name] = view.numpy() if block is self._host else view

    def bring(self) -> None:
        """Copies them to the device; what is written to `host` before the work is done there may arrive or not."""
        warp().copy(self._there, self._host)


def host_array(device: Any, size: int, kind: Any) -> Any:
    """A Warp array on the host that a device reads and writes without a detour; kind: Warp's type of an element."""
    return warp().zeros(size, dtype=kind, device="cpu", pinned=device.is_cuda)


def finish(device: Any) -> None:
    """Waits until a device has done what it was given."""
    if device.is_cuda:
        warp().synchronize_stream(device.stream)


def on_host(block: Any, size: int) -> np.ndarray:
    """(size,) uint8, the first bytes of a block of a device; on the processor the block itself."""
    if not block.device.is_cuda:
        return np.asarray(block.numpy()[:size])
    room = _rooms.get(block.device.alias)
    if room is None or room.size < size:
        room = _rooms[block.device.alias] = host_array(block.device, max(size, 1 << 20), warp().uint8)
    if size:
        warp().copy(room, block, count=size)
    finish(block.device)
    return np.array(room.numpy()[:size])


_rooms: dict[str, Any] = {}
"""By device, host memory through which results pass."""
