"""The event of a physics step, for graphs that are evaluated in each step."""

from __future__ import annotations

from fractions import Fraction

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from graph.node.declaration import NEVER_FIRES, PHYSICS_STEP

STAGE = "on_demand"


@dataclass(slots=True)
class _Seen:
    """Physics steps and wall time at the last evaluation; -1 before the first."""

    steps: int = -1
    system: Fraction | None = None
    told: bool = False


@node_type(
    "isaacsim.core.nodes.OnPhysicsStep",
    version=1,
    event=True,
    phase=PHYSICS_STEP,
    outputs={
        "step": Attribute("execution", "fires in every physics step, before the sensors and the update's other graphs"),
        "deltaSimulationTime": Attribute("double", "length of the physics step", unit="s"),
        "deltaSystemTime": Attribute(
            "double", "wall time since the step before, in whole microseconds; 0 at the first one", unit="s"
        ),
    },
    memory=_Seen,
)
def on_physics_step(db: Database) -> bool:
    """Fire once per physics step; the graph's pipeline stage must be on_demand, and it is then evaluated in each step.

    In a graph of another stage the node warns once and never fires. An evaluation between two steps does not fire it.
    """
    memory = db.memory
    stage = db.node.graph.pipeline_stage
    if stage != STAGE:
        if not memory.told:
            memory.told = True
            db.warn("physics-step-stage", NEVER_FIRES.format(stage=stage))
        return False
    app = db.app
    simulation = app.simulation
    steps = simulation.get_num_physics_steps()
    if steps in (0, memory.steps):
        return False
    now = app.wall_clock.now()
    passed = Fraction(0) if memory.system is None else now - memory.system
    memory.steps, memory.system = steps, now
    db.outputs.deltaSimulationTime = float(1 / simulation.steps_per_second)
    db.outputs.deltaSystemTime = int(passed * 1_000_000) / 1_000_000
    db.fire("step")
    return True
