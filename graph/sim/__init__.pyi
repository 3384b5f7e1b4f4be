"""The types of the public names; `__init__.py` says where each is imported from at its first use."""

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

from .fidelity import Fidelity as Fidelity
from .messages.bus import CountingSink as CountingSink
from .messages.bus import MemorySink as MemorySink
from .messages.bus import MessageBus as MessageBus
from .renderer.products import RenderProduct as RenderProduct
from .renderer.schedule import Tick as Tick
from .renderer.schedule import TickSchedule as TickSchedule
from .scene.stage import register_schemas as register_schemas
from .settings import Settings as Settings
from .timing.run_loop import RealClock as RealClock
from .timing.run_loop import VirtualClock as VirtualClock
from .worlds import Worlds as Worlds
