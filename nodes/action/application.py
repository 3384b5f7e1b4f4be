"""The end of a run."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type
from graph.node.declaration import CLOSING


@node_type(
    "omni.graph.action.ExitApplication",
    version=1,
    inputs={"execIn": Attribute("execution", "ends the run")},
)
def exit_application(db: Database) -> None:
    """End the run after this update: recordings are finished, `graph run` reports and exits with 0."""
    db.app.exit_requested = True


@node_type(
    "omni.graph.action.OnClosing",
    version=2,
    event=True,
    phase=CLOSING,
    outputs={"execOut": Attribute("execution", "fires once, when the App is about to close")},
)
def on_closing(db: Database) -> None:
    """Fire once when the App is about to close: at the end of `graph run`, at `App.close()`.

    Nothing else in the graph starts then. The world, the nodes' values and the recordings are as the last update left
    them. A playing timeline stops afterwards, and what the graph writes to the stage meanwhile is undone by that stop.
    """
    db.fire("execOut")
