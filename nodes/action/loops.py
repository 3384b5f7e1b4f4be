"""Loops: the whole loop runs within one evaluation of the graph."""

from __future__ import annotations

from collections.abc import Iterator

from graph.base.records import dataclass
from graph.node import Attribute, Database, NodeAtLoad, node_type
from nodes.data.like_inputs import element_of

LOOP_BODY = Attribute("execution", "follows once per pass, to its end, before the next pass")
FINISHED = Attribute("execution", "follows once after the last pass")


@dataclass(slots=True)
class _Pass:
    index: int = 0
    broken: bool = False
    running: bool = False


def _check_loop(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    """A written step that leads nowhere."""
    if "step" in node.given and node.db.inputs.step == 0:
        yield "step", "0 leads nowhere; give the loop a positive or negative step"


@node_type(
    "omni.graph.action.ForLoop",
    version=2,
    check=_check_loop,
    inputs={
        "execIn": Attribute("execution", "starts the loop"),
        "breakLoop": Attribute("execution", "fired from within the body: no further pass"),
        "start": Attribute("int", "value of the first pass", default=0),
        "stop": Attribute("int", "the loop ends before this value", default=0),
        "step": Attribute("int", "added after each pass; may be negative", default=1),
    },
    outputs={
        "loopBody": LOOP_BODY,
        "finished": FINISHED,
        "index": Attribute("int", "number of the pass, from 0"),
        "value": Attribute("int", "start + step x index"),
    },
    state={"i": Attribute("int", "-1 while idle, else number of the pass", default=-1)},
    memory=_Pass,
)
def for_loop(db: Database) -> None:
    """Run one pass for each value = start + step x index below `stop` (above, for a negative step).

    After a normal end `value` is the first value that did not qualify; after a break both outputs keep their values.
    """
    memory, inputs, outputs, state = db.memory, db.inputs, db.outputs, db.state
    if db.triggered("breakLoop"):
        memory.broken = memory.running
        return
    if inputs.step == 0:
        db.fail("input step is 0; give the loop a positive or negative step")
    if db.triggered("execIn"):
        memory.index, memory.broken, memory.running = 0, False, True
        outputs.index = 0
        _check_passes(db)
    else:
        memory.index += 1
    value = inputs.start + inputs.step * memory.index
    if not -(2**31) <= value < 2**31:
        db.fail(f"start {inputs.start} and step {inputs.step} lead to {value}, which an int cannot hold; lower them")
    if not memory.broken:
        outputs.value = value
        if value < inputs.stop if inputs.step > 0 else value > inputs.stop:
            state.i = outputs.index = memory.index
            db.fire_and_return("loopBody")
            return
    memory.running = False
    state.i = -1
    db.fire("finished")


def _check_passes(db: Database) -> None:
    """Refuses at once a loop that the evaluator would stop after a million passes, unless the body may break it."""
    inputs, limit = db.inputs, db.node.graph.step_limit
    passes = len(range(inputs.start, inputs.stop, inputs.step))
    if passes > limit and not db.wires_into("breakLoop"):
        db.fail(
            f"start {inputs.start}, stop {inputs.stop} and step {inputs.step} make {passes} passes in one update; at "
            f"most {limit} are possible: give it fewer, or break the loop by breakLoop"
        )


@dataclass(slots=True)
class _Element:
    index: int = 0


@node_type(
    "omni.graph.action.ForEach",
    version=2,
    inputs={
        "execIn": Attribute("execution", "starts the loop"),
        "arrayIn": Attribute(("arrays",), "the elements to go through"),
    },
    outputs={
        "loopBody": LOOP_BODY,
        "finished": FINISHED,
        "arrayIndex": Attribute("int", "position of the element, from 0"),
        "element": Attribute(("array_elements",), "the element of this pass"),
    },
    memory=_Element,
    resolve=element_of("arrayIn", "element"),
)
def for_each(db: Database) -> None:
    """Run one pass for each element; an empty array only finishes. Both data outputs keep their last values."""
    memory = db.memory
    memory.index = 0 if db.triggered("execIn") else memory.index + 1
    array = db.inputs.arrayIn
    if memory.index < len(array):
        db.outputs.arrayIndex = memory.index
        element = array[memory.index]
        db.outputs.element = element.item() if getattr(element, "ndim", None) == 0 else element
        db.fire_and_return("loopBody")
    else:
        db.fire("finished")
