"""What is computed on a device of NVIDIA Warp, a CUDA GPU or Warp's own processor code: rays, frames, many worlds.

The entry points `cuda` and `warp-cpu` of the group `tickgraph.devices` are this module (`graph.sim.devices.plugin_of`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.lazy_names import lazy_names as _lazy_names

if TYPE_CHECKING:
    from .camera import DeviceCamera
    from .check import compare
    from .devices import device_of
    from .lidar import DeviceLidar
    from .twin import DeviceTwin
    from .world import DeviceWorld
    from .worlds import Worlds

_HOMES = {
    "DeviceCamera": "camera",
    "DeviceLidar": "lidar",
    "DeviceTwin": "twin",
    "DeviceWorld": "world",
    "Worlds": "worlds",
    "compare": "check",
    "device_of": "devices",
}

__all__ = ["DeviceCamera", "DeviceLidar", "DeviceTwin", "DeviceWorld", "Worlds", "compare", "device_of"]

__getattr__, __dir__ = _lazy_names(__name__, _HOMES)
