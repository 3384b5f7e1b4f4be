"""Log output, through Python's logger `tickgraph`."""

from __future__ import annotations

import logging

from graph.node import Attribute, Database, node_type

LOGGER = logging.getLogger("tickgraph")
_LEVELS = {
    "Verbose": logging.DEBUG,
    "Info": logging.INFO,
    "Warn": logging.WARNING,
    "Warning": logging.WARNING,
    "Error": logging.ERROR,
}
EXEC_IN = Attribute("execution", "writes the message")
EXEC_OUT = Attribute("execution", "follows once it is written")


@node_type(
    "omni.graph.action.LogMessage",
    version=1,
    inputs={
        "channel": Attribute(
            "token",
            "name of the source that the message is given",
            default="omni.graph.nodes_core.plugin",
            literal_only=True,
        ),
        "execIn": EXEC_IN,
        "logLevel": Attribute(
            "token", "how grave it is", default="Info", allowed_tokens=("Verbose", "Info", "Warn", "Error")
        ),
        "message": Attribute("string", "the text", default=""),
    },
    outputs={"execOut": EXEC_OUT},
)
def log_message(db: Database) -> None:
    """Log a message under the logger `tickgraph`, with the channel before it."""
    inputs = db.inputs
    LOGGER.log(_level(db), "[%s] %s", inputs.channel, inputs.message)
    db.fire("execOut")


@node_type(
    "omni.graph.ui_nodes.PrintText",
    version=1,
    inputs={
        "execIn": EXEC_IN,
        "logLevel": Attribute("token", "how grave it is", default="Info", allowed_tokens=("Info", "Warning", "Error")),
        "text": Attribute("string", "the text", default=""),
        "toScreen": Attribute("bool", "for a viewport; without one the text is logged all the same", default=False),
        "viewport": Attribute("token", "for a viewport: which one", default=""),
    },
    outputs={"execOut": EXEC_OUT},
)
def print_text(db: Database) -> None:
    """Log a text under the logger `tickgraph`."""
    LOGGER.log(_level(db), "%s", db.inputs.text)
    db.fire("execOut")


def _level(db: Database) -> int:
    level = db.inputs.logLevel
    if level not in _LEVELS:
        db.fail(f"input logLevel is {level!r}; it must be Info, a warning or an error")
    return _LEVELS[level]
