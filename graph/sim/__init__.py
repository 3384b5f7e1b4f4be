"""The face of the world that graphs run on: App, settings, clocks, stage, messages, and Isaac Sim's managers.

Names are imported at their first use (PEP 562): importing this package loads no heavy library.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.lazy_names import lazy_names

if TYPE_CHECKING:
    from graph.isaac.managers import app_utils as app_utils
    from graph.isaac.managers.app import App as App
    from graph.isaac.managers.current import RenderingManager as RenderingManager
    from graph.isaac.managers.current import SimulationManager as SimulationManager
    from graph.isaac.managers.mjc_scene import NewtonMjcScene as NewtonMjcScene
    from graph.isaac.managers.physics_scene import PhysicsScene as PhysicsScene
    from graph.isaac.managers.physx_scene import PhysxGpuCfg as PhysxGpuCfg
    from graph.isaac.managers.physx_scene import PhysxScene as PhysxScene
    from graph.isaac.managers.rendering import RenderingEvent as RenderingEvent
    from graph.isaac.managers.simulation_events import IsaacEvents as IsaacEvents
    from graph.isaac.managers.simulation_events import SimulationEvent as SimulationEvent
    from graph.recording.mcap_sink import McapSink as McapSink
    from graph.sim.timing.run_loop import RealClock as RealClock
    from graph.sim.timing.run_loop import VirtualClock as VirtualClock

    from .fidelity import Fidelity as Fidelity
    from .messages.bus import CountingSink as CountingSink
    from .messages.bus import MemorySink as MemorySink
    from .messages.bus import MessageBus as MessageBus
    from .renderer.products import RenderProduct as RenderProduct
    from .renderer.schedule import Tick as Tick
    from .renderer.schedule import TickSchedule as TickSchedule
    from .scene.stage import register_schemas as register_schemas
    from .settings import Settings as Settings
    from .worlds import Worlds as Worlds

_HOME = {
    "App": ".isaac.managers.app",
    "CountingSink": "messages.bus",
    "Fidelity": "fidelity",
    "IsaacEvents": ".isaac.managers.simulation_events",
    "McapSink": ".recording.mcap_sink",
    "MemorySink": "messages.bus",
    "MessageBus": "messages.bus",
    "NewtonMjcScene": ".isaac.managers.mjc_scene",
    "PhysicsScene": ".isaac.managers.physics_scene",
    "PhysxGpuCfg": ".isaac.managers.physx_scene",
    "PhysxScene": ".isaac.managers.physx_scene",
    "RealClock": "timing.run_loop",
    "RenderProduct": "renderer.products",
    "RenderingEvent": ".isaac.managers.rendering",
    "RenderingManager": ".isaac.managers.current",
    "Settings": "settings",
    "SimulationEvent": ".isaac.managers.simulation_events",
    "SimulationManager": ".isaac.managers.current",
    "Tick": "renderer.schedule",
    "TickSchedule": "renderer.schedule",
    "VirtualClock": "timing.run_loop",
    "Worlds": "worlds",
    "app_utils": ".isaac.managers.app_utils",
    "register_schemas": "scene.stage",
}
__all__ = list(_HOME)

__getattr__, __dir__ = lazy_names(__name__, _HOME)
