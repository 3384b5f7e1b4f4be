"""The keyboard: events of its keys, and which are down; without a window, tests and scripts press them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graph.base.records import dataclass, field
from graph.node import Attribute, Database, node_type
from graph.sim.keyboard import KEYS, keyboard_of

from .events import ONLY_PLAYBACK
from .inboxes import ignored

MODIFIERS = {"shiftIn": "Shift", "altIn": "Alt", "ctrlIn": "Control"}


@dataclass(slots=True)
class Typed:
    """What happened to the key since the last evaluation: True for a press with the right modifiers."""

    key: str = ""
    stop: Callable[[], None] | None = None
    happened: list[bool] = field(default_factory=list)
    down: bool = False


def _end(db: Database) -> None:
    if db.memory.stop is not None:
        db.memory.stop()
    db.memory.stop = None


@node_type(
    "omni.graph.action.OnKeyboardInput",
    version=4,
    event=True,
    inputs={
        "altIn": Attribute("bool", "an alt key must be down", default=False, literal_only=True),
        "ctrlIn": Attribute("bool", "a control key must be down", default=False, literal_only=True),
        "keyIn": Attribute("token", "the key", default="A", literal_only=True, allowed_tokens=KEYS),
        "onlyPlayback": ONLY_PLAYBACK,
        "shiftIn": Attribute("bool", "a shift key must be down", default=False, literal_only=True),
    },
    outputs={
        "isPressed": Attribute("bool", "whether the key is down"),
        "keyOut": Attribute("token", "the key"),
        "pressed": Attribute("execution", "fires when the key goes down with just these modifiers"),
        "released": Attribute("execution", "fires when it is let go after that"),
    },
    memory=Typed,
    release=_end,
)
def on_keyboard_input(db: Database) -> bool:
    """Fire once for every press and once for every release of a key; never fires without a keyboard."""
    inputs, memory = db.inputs, db.memory
    if db.context.app is None:
        return False
    if memory.key != inputs.keyIn:
        _end(db)
        wanted = {name: getattr(inputs, name) for name in MODIFIERS}
        memory.key, memory.stop = inputs.keyIn, _listen(keyboard_of(db.context.app), memory, inputs.keyIn, wanted)
    happened, memory.happened = memory.happened, []
    if not happened or ignored(db):
        return False
    db.outputs.keyOut = memory.key
    db.outputs.isPressed = happened[-1]
    for pressed in happened:
        db.fire("pressed" if pressed else "released")
    return True


def _listen(keyboard: Any, memory: Typed, key: str, wanted: dict[str, bool]) -> Callable[[], None]:
    def told(name: str, down: bool) -> None:
        if name != key:
            return
        held = {port: getattr(keyboard, word.lower()) for port, word in MODIFIERS.items() if word not in key}
        if down and all(wanted[port] == state for port, state in held.items()):
            memory.down = True
            memory.happened.append(True)
        elif not down and memory.down:
            memory.down = False
            memory.happened.append(False)

    stop: Callable[[], None] = keyboard.listen(told)
    return stop


@node_type(
    "omni.graph.nodes.ReadKeyboardState",
    version=1,
    volatile=True,
    inputs={"key": Attribute("token", "the key to look at", default="A", allowed_tokens=KEYS)},
    outputs={
        "altOut": Attribute("bool", "whether an alt key is down"),
        "ctrlOut": Attribute("bool", "whether a control key is down"),
        "isPressed": Attribute("bool", "whether the key is down"),
        "shiftOut": Attribute("bool", "whether a shift key is down"),
    },
)
def read_keyboard_state(db: Database) -> None:
    """Read which keys are down on the App's keyboard (`graph.sim.keyboard.keyboard_of`)."""
    keyboard, key, outputs = keyboard_of(db.app), db.inputs.key, db.outputs
    if key not in KEYS:
        db.fail(f"input key is {key!r}, which is not a key; use a name such as A, Key1 or Space")
    outputs.altOut, outputs.ctrlOut, outputs.shiftOut = keyboard.alt, keyboard.control, keyboard.shift
    outputs.isPressed = key in keyboard.pressed
