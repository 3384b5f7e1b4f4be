"""`Worlds`: many worlds at once. Most of it measures, so its code is with the sensors."""

from importlib import import_module
from typing import Any

Worlds: Any = import_module("sensors.device.worlds").Worlds
