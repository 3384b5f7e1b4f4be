"""Flow control: which execution outputs follow an activation, and in which order."""

from __future__ import annotations

from graph.base.records import dataclass, field
from graph.node import Attribute, Database, node_type

EXEC_IN = Attribute("execution", "activates the node")
OUTPUT = Attribute("execution", "one of the outputs output0, output1, ...")


@node_type(
    "omni.graph.action.Branch",
    version=2,
    inputs={"execIn": EXEC_IN, "condition": Attribute("bool", "which way to go", default=False)},
    outputs={
        "execTrue": Attribute("execution", "follows when the condition is true"),
        "execFalse": Attribute("execution", "follows when the condition is false"),
    },
)
def branch(db: Database) -> None:
    """Follow execTrue or execFalse."""
    db.fire("execTrue" if db.inputs.condition else "execFalse")


@dataclass(slots=True)
class _Door:
    open: bool | None = None


@node_type(
    "omni.graph.action.Gate",
    version=2,
    inputs={
        "enter": Attribute("execution", "passes to `exit` while the gate is open"),
        "toggle": Attribute("execution", "opens a closed gate, closes an open one; never fires `exit`"),
        "startClosed": Attribute("bool", "whether the gate is closed at the start", default=False),
    },
    outputs={"exit": Attribute("execution", "follows `enter` through an open gate")},
    memory=_Door,
)
def gate(db: Database) -> None:
    """Pass activations while open; startClosed sets the state at play."""
    memory = db.memory
    if memory.open is None:
        memory.open = not db.inputs.startClosed
    if db.triggered("toggle"):
        memory.open = not memory.open
    if memory.open and db.triggered("enter"):
        db.fire("exit")


@dataclass(slots=True)
class _Passed:
    yes: bool = False


@node_type(
    "omni.graph.action.Once",
    version=2,
    inputs={"execIn": EXEC_IN, "reset": Attribute("execution", "the next activation is a first one again")},
    outputs={
        "once": Attribute("execution", "follows the first activation"),
        "after": Attribute("execution", "follows every later activation"),
    },
    memory=_Passed,
)
def once(db: Database) -> None:
    """Distinguish the first activation from the later ones."""
    memory = db.memory
    if db.triggered("reset"):
        memory.yes = False
    if db.triggered("execIn"):
        db.fire("after" if memory.yes else "once")
        memory.yes = True


@node_type(
    "omni.graph.action.Counter",
    version=2,
    inputs={"execIn": EXEC_IN, "reset": Attribute("execution", "sets the count to 0; fires nothing")},
    outputs={
        "execOut": Attribute("execution", "follows every counted activation"),
        "count": Attribute("int", "activations since the start or the last reset"),
    },
    state={"count": Attribute("int", "the count so far")},
)
def counter(db: Database) -> None:
    """Count activations."""
    count = 0 if db.triggered("reset") else db.state.count
    if db.triggered("execIn"):
        count += 1
        db.fire("execOut")
    db.state.count = db.outputs.count = count


@dataclass(slots=True)
class _Side:
    next_is_a: bool = True


@node_type(
    "omni.graph.action.FlipFlop",
    version=2,
    inputs={"execIn": EXEC_IN},
    outputs={
        "a": Attribute("execution", "follows the first, third, fifth ... activation"),
        "b": Attribute("execution", "follows the second, fourth, sixth ... activation"),
        "isA": Attribute("bool", "whether this activation went to `a`"),
    },
    memory=_Side,
)
def flip_flop(db: Database) -> None:
    """Alternate between two outputs."""
    memory = db.memory
    db.outputs.isA = memory.next_is_a
    db.fire("a" if memory.next_is_a else "b")
    memory.next_is_a = not memory.next_is_a


@dataclass(slots=True)
class _Turn:
    """The output that is next, and all outputs."""

    next: int = 0
    outputs: list[str] = field(default_factory=list)


@node_type(
    "omni.graph.action.Multisequence",
    version=2,
    inputs={"execIn": EXEC_IN},
    outputs={"output0": OUTPUT},
    dynamic_outputs={"output{n}": OUTPUT},
    memory=_Turn,
)
def multisequence(db: Database) -> None:
    """Follow output0 to its end, then output1, and so on; a latent node behind one output does not delay the next."""
    for output in _outputs(db):
        db.fire(output)


def _outputs(db: Database) -> list[str]:
    """output0, output1, ... up to the last one in the graph."""
    memory = db.memory
    if not memory.outputs:
        memory.outputs = db.dynamic_outputs("output")
    names: list[str] = memory.outputs
    return names


@node_type(
    "omni.graph.action.Multigate",
    version=2,
    inputs={"execIn": EXEC_IN, "reset": Attribute("execution", "the next activation goes to output0; fires nothing")},
    outputs={"output0": OUTPUT},
    dynamic_outputs={"output{n}": OUTPUT},
    memory=_Turn,
)
def multigate(db: Database) -> None:
    """Follow one output per activation, in turn."""
    memory = db.memory
    if db.triggered("reset"):
        memory.next = 0
    if db.triggered("execIn"):
        outputs = _outputs(db)
        db.fire(outputs[memory.next % len(outputs)])
        memory.next = (memory.next + 1) % len(outputs)


@node_type(
    "omni.graph.action.SwitchToken",
    version=2,
    inputs={"execIn": EXEC_IN, "value": Attribute("token", "the text to look for", default="")},
    dynamic_inputs={
        "branch{x}": Attribute("token", "a text; the output of the same ending follows when value equals it")
    },
    dynamic_outputs={"output{x}": Attribute("execution", "follows when value equals the branch of the same ending")},
)
def switch_token(db: Database) -> None:
    """Follow the first output whose branch equals the value; without a match nothing follows."""
    for name, text in zip(db.dynamic_input_names(), db.dynamic_inputs(), strict=True):
        if text == db.inputs.value:
            output = "output" + name.removeprefix("branch")
            if output in db.dynamic_outputs():
                db.fire(output)
            return


class _Odd:
    """Whether the next activation is an odd one."""

    def __init__(self) -> None:
        self.next_is_odd = True


@node_type(
    "omni.graph.action.Sequence",
    version=2,
    inputs={"execIn": Attribute("execution", "goes on at one of the outputs")},
    outputs={
        "a": Attribute("execution", "follows at the first, third, ... activation"),
        "b": Attribute("execution", "follows at the second, fourth, ... activation"),
    },
    memory=_Odd,
)
def sequence(db: Database) -> None:
    """Follow a and b in turn, one per activation. To follow both, use Multisequence."""
    db.fire("a" if db.memory.next_is_odd else "b")
    db.memory.next_is_odd = not db.memory.next_is_odd
