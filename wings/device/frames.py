"""Frames of one lidar whose channels stay on the device until they are read as NumPy arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from graph.sim.devices import warp
from sensors.channels import CHANNELS
from sensors.gmo import ElementFlags
from sensors.gmo.layout import AUX_ARRAYS, ELEMENT_ARRAYS, HEADER, XYZ_CHANNELS
from sensors.lidar.pattern import Pattern
from sensors.lidar.returns import BEAM_CHANNELS

from .replay import finish, host_array, on_host
from .scan import DeviceScan

FIRST = -(-HEADER.itemsize // 8) * 8
"""Where in a block the arrays begin."""

MEASURED = {"distance": 2, "beamDistance": 2, "xyz": 3, "hitNormals": 4, "scalar": 5, "velocities": 6}
"""Measured channels -> their numbers in the kernel `gather`."""

ANGLES = {
    "azimuth": "azimuth_deg",
    "elevation": "elevation_deg",
    "beamAzimuth": "azimuth_deg",
    "timeOffsetNs": "offset_ns",
}
"""Channels of the firings beside `BEAM_CHANNELS` -> the pattern's arrays."""

CONSTANT = {"flags": int(ElementFlags.VALID), "echoId": 0}


class DeviceArrays(Mapping[str, np.ndarray]):
    """Channels of a frame in one block of bytes on a device; as a mapping they are NumPy arrays.

    The block is copied to the host once, when the first of them is read. offsets: of the channels in the block; size:
    of what is used of it; count: of rows.
    """

    def __init__(self, block: Any, offsets: Mapping[str, int], size: int, count: int) -> None:
        self._block, self._offsets, self._size, self._count = block, offsets, size, count
        self._host: np.ndarray | None = None
        self.fetched: dict[str, np.ndarray] = {}
        """Those that were read as NumPy arrays."""

    def __getitem__(self, name: str) -> np.ndarray:
        found = self.fetched.get(name)
        if found is None:
            channel, begin = CHANNELS[name], self._offsets[name]
            if self._host is None:
                self._host = on_host(self._block, self._size)
            size = self._count * channel.width * channel.dtype.itemsize
            found = self.fetched[name] = self._host[begin : begin + size].view(channel.dtype).reshape(self._shape(name))
        return found

    def __contains__(self, name: object) -> bool:
        return name in self._offsets  # without a copy to the host

    def __iter__(self) -> Iterator[str]:
        return iter(self._offsets)

    def __len__(self) -> int:
        return len(self._offsets)

    def _shape(self, name: str) -> tuple[int, ...]:
        width = CHANNELS[name].width
        return (self._count, width) if width > 1 else (self._count,)

    def on_device(self, name: str) -> Any:
        """The channel as a Warp array of its own type, (count,) or (count, width), without a copy."""
        wp, block = warp(), self._block
        kind = wp.dtype_from_numpy(CHANNELS[name].dtype)
        place = block.ptr + self._offsets[name]
        found = wp.array(ptr=place, dtype=kind, shape=self._shape(name), device=block.device)
        found.owner = block  # keeps the memory while the view is alive
        return found

    def packed(self, offsets: Mapping[str, int], size: int, coords: str) -> np.ndarray | None:
        """The whole GenericModelOutput buffer of this layout but for its header, new; None if the block has another."""
        names = dict(zip("xyz", XYZ_CHANNELS[coords], strict=False))
        if any(self._offsets.get(names.get(name, name)) != begin for name, begin in offsets.items()):
            return None
        if self._host is not None or not self._block.device.is_cuda:
            return np.array((self._block.numpy() if self._host is None else self._host)[:size])
        return on_host(self._block, size)


class DeviceFrames:
    """Makes the frames of a lidar in one world. tables: channel -> rows of the surfaces, as of `Scanner`."""

    def __init__(self, scan: DeviceScan, pattern: Pattern, tables: Mapping[str, Callable[[], np.ndarray]]) -> None:
        from . import scan_kernels

        self.scan, self._pattern, self._tables, self._kernels = scan, pattern, tables, scan_kernels
        self.gathering = scan_kernels.gather
        wp, device = warp(), scan.geometry.device
        self._found, self.before, self.rows = (wp.zeros(len(pattern), dtype=wp.int32, device=device) for _ in range(3))
        self._total = host_array(device, 1, wp.int32)
        self._count = self._total.numpy()
        self._plans: dict[frozenset[str], _Plan] = {}

    def find(self) -> None:
        """Numbers the firings of the scan that was made last which had a return."""
        wp, kernels, device, size = warp(), self._kernels, self.scan.geometry.device, self.scan.firings
        wp.launch(kernels.mark, dim=size, inputs=[self.scan.channels.distance], outputs=[self._found], device=device)
        wp.utils.array_scan(self._found, self.before, inclusive=True)
        wp.launch(kernels.number, dim=size, inputs=[self._found, self.before, self.rows], device=device)
        wp.copy(self._total, self.before, src_offset=max(size - 1, 0), count=min(size, 1))

    def frame(self, channels: frozenset[str]) -> tuple[DeviceArrays, int]:
        """The channels of the firings that were found last, and their number."""
        plan = self._plans.get(channels)
        if plan is None:
            plan = self._plans[channels] = _Plan(self, channels)
        block = plan.gather()
        finish(self.scan.geometry.device)
        count = int(self._count[0])
        return DeviceArrays(block, *plan.offsets(count), count), count

    def of_firings(self, name: str) -> np.ndarray | None:
        """The rows (n, bytes) of a channel that only depends on the firing; None for another."""
        if name in CONSTANT:
            return _bytes(name, np.full(len(self._pattern), CONSTANT[name]))
        attribute = BEAM_CHANNELS.get(name) or ANGLES.get(name)
        return _bytes(name, getattr(self._pattern, attribute)) if attribute else None

    def of_surfaces(self, name: str) -> np.ndarray | None:
        """The rows (s, bytes) of a channel that only depends on the surface; None for another."""
        return _bytes(name, self._tables[name]()) if name in self._tables else None


class _Plan:
    """Where each of some channels comes from, and where in a block of bytes it goes."""

    def __init__(self, frames: DeviceFrames, channels: frozenset[str]) -> None:
        wp, device = warp(), frames.scan.geometry.device
        self._device = device
        self.names: list[str] = []
        parts: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
        fields: list[tuple[int, int, int]] = []
        for name in sorted(channels):
            width = CHANNELS[name].width * CHANNELS[name].dtype.itemsize
            source = MEASURED.get(name)
            if source is None:
                found = [frames.of_firings(name), frames.of_surfaces(name)]
                source = next((number for number, rows in enumerate(found) if rows is not None), None)
                if source is None:
                    continue
                rows = found[source]
                assert rows is not None
                fields.append((source, sum(part.shape[1] for part in parts[source]), width))
                parts[source].append(rows)
            else:
                fields.append((source, 0, width))
            self.names.append(name)
        axes = dict(zip("xyz", XYZ_CHANNELS["SPHERICAL"], strict=True))
        aux = [name for name in AUX_ARRAYS if name in self.names]
        known = [axes.get(name, name) for name in (*ELEMENT_ARRAYS, *aux)]
        self._slots = {name: CHANNELS[name].width * CHANNELS[name].dtype.itemsize for name in (*known, *self.names)}
        slot = {name: number for number, name in enumerate(self._slots)}
        columns = [*np.array(fields, np.int32).reshape(-1, 3).T, [slot[name] for name in self.names]]
        tables = [
            *(wp.array(_joined(part), dtype=wp.uint8, device=device) for part in parts),
            *(_integers(column, device) for column in (*columns, [*self._slots.values()])),
        ]
        size = frames.scan.firings
        self._most = self.offsets(size)[1]
        block = wp.zeros(self._most, dtype=wp.uint8, device=device)
        inputs = [frames.before, frames.rows, frames.scan.channels, *tables, FIRST]
        self._kept = inputs  # the recorded launch holds their addresses only
        self._launch = wp.launch(
            frames.gathering,
            dim=(size, len(self.names)),
            inputs=inputs,
            outputs=[block],
            device=device,
            record_cmd=True,
        )
        self._place = len(inputs)

    def gather(self) -> Any:
        """A new block with the channels of the firings that were found last."""
        wp = warp()
        block = wp.zeros(self._most, dtype=wp.uint8, device=self._device)
        if self.names and self._most > FIRST:
            self._launch.set_param_at_index(self._place, block)
            self._launch.launch()
        return block

    def offsets(self, count: int) -> tuple[dict[str, int], int]:
        """Where channels of `count` rows begin in a block, first as a GenericModelOutput has them; and its size."""
        begins, size = {}, FIRST
        for name, width in self._slots.items():
            begins[name] = -(-size // 8) * 8
            size = begins[name] + count * width
        return {name: begins[name] for name in self.names}, size


def _bytes(name: str, values: Any) -> np.ndarray:
    rows = np.ascontiguousarray(np.asarray(values, CHANNELS[name].dtype))
    return rows.reshape(len(rows), CHANNELS[name].width).view(np.uint8)


def _integers(values: Any, device: Any) -> Any:
    wp = warp()
    return wp.array(np.ascontiguousarray(values, np.int32), dtype=wp.int32, device=device)


def _joined(parts: Sequence[np.ndarray]) -> np.ndarray:
    return np.ascontiguousarray(np.concatenate(parts, axis=1)) if parts else np.zeros((0, 0), np.uint8)
