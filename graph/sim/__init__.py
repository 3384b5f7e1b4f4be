"""What scripts import: App, settings, clocks, stage and messages of the world, Isaac Sim's managers, the MCAP writer.

A table of names, imported at their first use (PEP 562), which defines nothing; their types stand in `__init__.pyi`.
It is for users: our own code imports a name from the module that defines it.
"""

from graph.base.lazy_names import lazy_names

_HOMES = {
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
__all__ = list(_HOMES)

__getattr__, __dir__ = lazy_names(__name__, _HOMES)
