"""Sensors of PhysX: a rotating lidar and a curtain of light beams, which nodes poll; and a proximity sensor.

None of them has a render product. `ProximitySensor`, `register_sensor` and `clear_sensors` have the names of
`isaacsim.sensors.physx`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.lazy_names import lazy_names as _lazy_names

if TYPE_CHECKING:
    from .proximity import ProximitySensor, clear_sensors, register_sensor

__all__ = ["ProximitySensor", "clear_sensors", "register_sensor"]

__getattr__, __dir__ = _lazy_names(__name__, dict.fromkeys(__all__, "proximity"))
