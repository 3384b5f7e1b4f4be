"""The world that graphs run on: settings, clocks, timeline, stage, Fabric, physics, renderer scheduler, App.

Names are imported at their first use (PEP 562): importing this package loads no heavy library.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.lazy_names import lazy_names

if TYPE_CHECKING:
    from .app import App as App
    from .fidelity import Fidelity as Fidelity
    from .managers.current import RenderingManager as RenderingManager
    from .managers.current import SimulationManager as SimulationManager
    from .managers.mjc_scene import NewtonMjcScene as NewtonMjcScene
    from .managers.physics_scene import PhysicsScene as PhysicsScene
    from .managers.physx_scene import PhysxGpuCfg as PhysxGpuCfg
    from .managers.physx_scene import PhysxScene as PhysxScene
    from .managers.rendering import RenderingEvent as RenderingEvent
    from .managers.simulation_events import IsaacEvents as IsaacEvents
    from .managers.simulation_events import SimulationEvent as SimulationEvent
    from .messages.bus import CountingSink as CountingSink
    from .messages.bus import MemorySink as MemorySink
    from .messages.bus import MessageBus as MessageBus
    from .messages.recording import McapSink as McapSink
    from .renderer.products import RenderProduct as RenderProduct
    from .renderer.schedule import Tick as Tick
    from .renderer.schedule import TickSchedule as TickSchedule
    from .scene.stage import register_schemas as register_schemas
    from .settings import Settings as Settings
    from .timing.wall_clock import RealClock as RealClock
    from .timing.wall_clock import VirtualClock as VirtualClock

_HOME = {
    "App": "app",
    "CountingSink": "messages.bus",
    "Fidelity": "fidelity",
    "IsaacEvents": "managers.simulation_events",
    "McapSink": "messages.recording",
    "MemorySink": "messages.bus",
    "MessageBus": "messages.bus",
    "NewtonMjcScene": "managers.mjc_scene",
    "PhysicsScene": "managers.physics_scene",
    "PhysxGpuCfg": "managers.physx_scene",
    "PhysxScene": "managers.physx_scene",
    "RealClock": "timing.wall_clock",
    "RenderProduct": "renderer.products",
    "RenderingEvent": "managers.rendering",
    "RenderingManager": "managers.current",
    "Settings": "settings",
    "SimulationEvent": "managers.simulation_events",
    "SimulationManager": "managers.current",
    "Tick": "renderer.schedule",
    "TickSchedule": "renderer.schedule",
    "VirtualClock": "timing.wall_clock",
    "register_schemas": "scene.stage",
}
__all__ = [
    "App",
    "CountingSink",
    "Fidelity",
    "IsaacEvents",
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

__getattr__, __dir__ = lazy_names(__name__, _HOME)
