"""The run itself."""

from __future__ import annotations

from typing import Any

from graph import Attribute, node_type


@node_type(
    "omni.graph.action.ExitApplication",
    version=1,
    inputs={"execIn": Attribute("execution", "ends the run")},
)
def exit_application(db: Any) -> None:
    """End the run after this update: recordings are finished, `graph run` reports and exits with 0."""
    db.app.exit_requested = True
