"""The keyboard as a value."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type
from graph.sim.keyboard import KEYS, keyboard_of


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
