"""Settings of the App, read and written; the start of the timeline."""

from __future__ import annotations

from typing import Any

from graph.base.errors import UserError
from graph.node import Attribute, Database, node_type

PATH = Attribute("string", "path of the setting, such as /app/player/useFastMode", default="")
VALUES = ("arrays", "array_elements", "bool", "bool[]")


@node_type(
    "omni.graph.nodes.ReadSetting",
    version=1,
    volatile=True,
    inputs={"settingPath": PATH},
    outputs={"value": Attribute((*VALUES, "string"), "its value")},
)
def read_setting(db: Database) -> bool:
    """Read a setting; for an unset one the output keeps its value, one with settings below it fails."""
    from fractions import Fraction

    from graph.values.coercion import coerce
    from graph.values.types import TYPES

    path, value = db.inputs.settingPath, _get(db)
    if value is None:
        db.warn("setting-unset", f'nobody has set "{path}"; give it a value, or correct the path')
        return False
    if isinstance(value, dict):
        db.fail(f"{path} has settings below it; name one of those")
    value = float(value) if isinstance(value, Fraction) else value
    wanted = db.output_type("value")
    if wanted is not None:
        try:
            kind = TYPES[wanted]
            value = coerce(kind, str(value) if kind.text and not isinstance(value, str) else value)
        except ValueError as error:
            db.fail(f"setting {path}: {error}")
    db.outputs.value = value
    return True


@node_type(
    "omni.graph.nodes.WriteSetting",
    version=1,
    inputs={
        "execIn": Attribute("execution", "writes the setting"),
        "settingPath": PATH,
        "value": Attribute((*VALUES, "string"), "the value to write"),
    },
    outputs={"execOut": Attribute("execution", "follows once it is written")},
)
def write_setting(db: Database) -> None:
    """Write a setting of the App; a value that the setting does not accept fails."""
    value = db.inputs.value
    try:
        db.app.settings.set(db.inputs.settingPath, value.tolist() if hasattr(value, "tolist") else value)
    except UserError as error:
        db.fail(str(error))
    db.fire("execOut")


def _get(db: Database) -> Any:
    try:
        return db.app.settings.get(db.inputs.settingPath)
    except UserError as error:
        return db.lack(str(error))


@node_type(
    "omni.graph.nodes.StartTimeline",
    version=1,
    inputs={"execIn": Attribute("execution", "starts it")},
    outputs={"execOut": Attribute("execution", "follows at once; the timeline plays from the next update on")},
)
def start_timeline(db: Database) -> None:
    """Play the timeline from its present time, from the next update on; a playing timeline continues."""
    db.app.timeline.play()
    db.fire("execOut")
