"""The world that graphs run over: settings, clocks, timeline, stage, Fabric, physics, renderer scheduler, App.

Names resolve on first use (PEP 562): importing this package loads none of the libraries below it.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .app import App as App
    from .bus import CountingSink as CountingSink
    from .bus import MemorySink as MemorySink
    from .bus import MessageBus as MessageBus
    from .fidelity import Fidelity as Fidelity
    from .managers import RenderingManager as RenderingManager
    from .managers import SimulationManager as SimulationManager
    from .mjc_scene import NewtonMjcScene as NewtonMjcScene
    from .physics_scene import PhysicsScene as PhysicsScene
    from .physx_scene import PhysxGpuCfg as PhysxGpuCfg
    from .physx_scene import PhysxScene as PhysxScene
    from .recording import McapSink as McapSink
    from .rendering import RenderingEvent as RenderingEvent
    from .rendering import RenderProduct as RenderProduct
    from .schedule import Tick as Tick
    from .schedule import TickSchedule as TickSchedule
    from .settings import Settings as Settings
    from .simulation_events import SimulationEvent as SimulationEvent
    from .stage import register_schemas as register_schemas
    from .wall_clock import RealClock as RealClock
    from .wall_clock import VirtualClock as VirtualClock

_HOME = {
    "App": "app",
    "CountingSink": "bus",
    "Fidelity": "fidelity",
    "McapSink": "recording",
    "MemorySink": "bus",
    "MessageBus": "bus",
    "NewtonMjcScene": "mjc_scene",
    "PhysicsScene": "physics_scene",
    "PhysxGpuCfg": "physx_scene",
    "PhysxScene": "physx_scene",
    "RealClock": "wall_clock",
    "RenderProduct": "rendering",
    "RenderingEvent": "rendering",
    "RenderingManager": "managers",
    "Settings": "settings",
    "SimulationEvent": "simulation_events",
    "SimulationManager": "managers",
    "Tick": "schedule",
    "TickSchedule": "schedule",
    "VirtualClock": "wall_clock",
    "register_schemas": "stage",
}
__all__ = [
    "App",
    "CountingSink",
    "Fidelity",
    "McapSink",
    "MemorySink",
    "MessageBus",
    "NewtonMjcScene",
    "PhysicsScene",
    "PhysxGpuCfg",
    "PhysxScene",
    "RealClock",
    "RenderProduct",
    "RenderingEvent",
    "RenderingManager",
    "Settings",
    "SimulationEvent",
    "SimulationManager",
    "Tick",
    "TickSchedule",
    "VirtualClock",
    "register_schemas",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOME[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})
