"""Frames of one lidar whose channels stay on the device until they are read as NumPy arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from graph.sim.devices import warp
from sensors.channels import CHANNELS
from sensors.gmo import ElementFlags
from sensors.gmo.layout import AUX_ARRAYS, XYZ_CHANNELS, layout_of
from sensors.lidar.pattern import Pattern
from sensors.lidar.returns import BEAM_CHANNELS

from .scan import DeviceScan

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

    The block is copied to the host once, when the first of them is read. offsets: of the channels in the block; count:
    of rows.
    """

    def __init__(self, block: Any, offsets: Mapping[str, int], count: int) -> None:
        self._block, self._offsets, self._count = block, offsets, count
        self._host: np.ndarray | None = None
        self.fetched: dict[str, np.ndarray] = {}
        """Those that were read as NumPy arrays."""

    def __getitem__(self, name: str) -> np.ndarray:
        found = self.fetched.get(name)
        if found is None:
            channel, begin = CHANNELS[name], self._offsets[name]
            if self._host is None:
                self._host = self._block.numpy()
            size = self._count * channel.width * channel.dtype.itemsize
            found = self.fetched[name] = self._host[begin : begin + size].view(channel.dtype).reshape(self._shape(name))
        return found

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
        return np.array(self._block[:size].numpy(), copy=not self._block.device.is_cuda)  # there it is a copy already


class DeviceFrames:
    """Makes the frames of a lidar in one world. tables: channel -> rows of the surfaces, as of `Scanner`."""

    def __init__(self, scan: DeviceScan, pattern: Pattern, tables: Mapping[str, Callable[[], np.ndarray]]) -> None:
        from . import scan_kernels

        self.scan, self._pattern, self._tables, self._kernels = scan, pattern, tables, scan_kernels
        wp, device = warp(), scan.geometry.device
        self._found, self._before, self._rows = (
            wp.zeros(len(pattern), dtype=wp.int32, device=device) for _ in range(3)
        )
        self._plans: dict[frozenset[str], _Plan] = {}

    def frame(self, channels: frozenset[str]) -> tuple[DeviceArrays, int]:
        """The channels of the scan that was made last, without the firings that had no return; and the returns."""
        wp, kernels, device = warp(), self._kernels, self.scan.geometry.device
        size = self.scan.firings
        wp.launch(kernels.mark, dim=size, inputs=[self.scan.channels.distance], outputs=[self._found], device=device)
        wp.utils.array_scan(self._found, self._before, inclusive=True)
        wp.launch(kernels.number, dim=size, inputs=[self._found, self._before, self._rows], device=device)
        plan = self._plans.get(channels)
        if plan is None:
            plan = self._plans[channels] = _Plan(self, channels)
        count = int(self._before[size - 1 :].numpy()[0]) if size else 0
        offsets, total = plan.offsets(count)
        block = wp.zeros(total, dtype=wp.uint8, device=device)
        if count:
            places = wp.array([offsets[name] for name in plan.names], dtype=wp.int32, device=device)
            wp.launch(
                kernels.gather,
                dim=(count, len(plan.names)),
                inputs=[self._rows, self.scan.channels, *plan.tables, places],
                outputs=[block],
                device=device,
            )
        return DeviceArrays(block, offsets, count), count

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
    """Where each of some channels comes from."""

    def __init__(self, frames: DeviceFrames, channels: frozenset[str]) -> None:
        wp, device = warp(), frames.scan.geometry.device
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
        columns = np.array(fields, np.int32).reshape(-1, 3).T
        self.tables = [
            *(wp.array(_joined(part), dtype=wp.uint8, device=device) for part in parts),
            *(wp.array(np.ascontiguousarray(column), dtype=wp.int32, device=device) for column in columns),
        ]
        """The arguments of `gather` about the fields: rows of the firings and surfaces, sources, columns, widths."""

    def offsets(self, count: int) -> tuple[dict[str, int], int]:
        """Where channels of `count` rows begin in a block, first as a GenericModelOutput has them; and its size."""
        aux = [name for name in AUX_ARRAYS if name in self.names]
        known, size = layout_of(count, aux)
        axes = dict(zip("xyz", XYZ_CHANNELS["SPHERICAL"], strict=True))
        found = {axes.get(name, name): begin for name, begin in known.items()}
        for name in self.names:
            if name not in found:
                size = -(-size // 8) * 8
                found[name] = size
                size += count * CHANNELS[name].width * CHANNELS[name].dtype.itemsize
        return {name: found[name] for name in self.names}, size


def _bytes(name: str, values: Any) -> np.ndarray:
    rows = np.ascontiguousarray(np.asarray(values, CHANNELS[name].dtype))
    return rows.reshape(len(rows), -1).view(np.uint8)


def _joined(parts: Sequence[np.ndarray]) -> np.ndarray:
    return np.ascontiguousarray(np.concatenate(parts, axis=1)) if parts else np.zeros((0, 0), np.uint8)
