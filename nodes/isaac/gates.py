"""Gates that count activations: every n-th, or one per play."""

from __future__ import annotations

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type


@dataclass(slots=True)
class _Count:
    activations: int = 0


@node_type(
    "isaacsim.core.nodes.IsaacSimulationGate",
    version=1,
    inputs={
        "execIn": Attribute("execution", "an activation to count"),
        "step": Attribute("uint", "activations per firing; 0 never fires", default=1),
    },
    outputs={"execOut": Attribute("execution", "fires on every `step`-th activation while playing")},
    memory=_Count,
)
def simulation_gate(db: Database) -> bool:
    """Pass every `step`-th activation (step 2: the 2nd, 4th, ...), counted while the timeline plays."""
    if not db.context.is_playing:
        return False
    memory = db.memory
    memory.activations += 1
    if memory.activations != db.inputs.step:
        return False
    memory.activations = 0
    db.fire("execOut")
    return True


@dataclass(slots=True)
class _Ran:
    once: bool = False


@node_type(
    "isaacsim.core.nodes.OgnIsaacRunOneSimulationFrame",
    version=1,
    inputs={"execIn": Attribute("execution", "an activation; only the first one after play counts")},
    outputs={"step": Attribute("execution", "fires once per play; a stop arms it again, a pause does not")},
    memory=_Ran,
)
def run_one_simulation_frame(db: Database) -> bool:
    """Fire once per play."""
    if db.memory.once:
        return False
    db.memory.once = True
    db.fire("step")
    return True
