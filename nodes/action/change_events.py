"""Events of changes: graph variables, properties of prims."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graph.base.records import dataclass, field
from graph.node import Attribute, Database, node_type

from .events import ONLY_PLAYBACK
from .inboxes import ignored
from .notices import StageWatch


@dataclass(slots=True)
class LastValue:
    """The last value that was seen, if any."""

    seen: bool = False
    value: Any = None


@node_type(
    "omni.graph.action.OnVariableChange",
    version=2,
    event=-1,
    inputs={
        "onlyPlayback": ONLY_PLAYBACK,
        "variableName": Attribute("token", "name of the variable", default="", literal_only=True),
    },
    outputs={"changed": Attribute("execution", "fires when the value differs from that of the last evaluation")},
    memory=LastValue,
)
def on_variable_change(db: Database) -> bool:
    """Fire when a variable differs from its value in the last evaluation, at first from the value in the file."""
    name = db.inputs.variableName
    if not name:
        return False
    if name not in db.variables:
        from graph.base.suggest import did_you_mean

        db.fail(f'the graph has no variable "{name}"{did_you_mean(name, db.variables)}')
    memory, value = db.memory, db.variables[name]
    before = memory.value if memory.seen else db.variables.initial(name)
    memory.seen, memory.value = True, value
    if _equal(before, value) or ignored(db):
        return False
    db.fire("changed")
    return True


def _equal(one: Any, other: Any) -> bool:
    if hasattr(one, "tolist") or hasattr(other, "tolist"):
        import numpy as np

        return bool(np.array_equal(one, other))
    return bool(one == other)


@dataclass(slots=True)
class Watch:
    """A subscription to the stage's notices, and the properties that changed since the last evaluation."""

    path: str = ""
    stop: Callable[[], None] | None = None
    changed: list[str] = field(default_factory=list)


def _end_watch(db: Database) -> None:
    watch: Watch = db.memory
    if watch.stop is not None:
        watch.stop()
    watch.stop, watch.path = None, ""


@node_type(
    "omni.graph.action.OnObjectChange",
    version=5,
    event=True,
    inputs={
        "name": Attribute("token", "name of the property; empty: any property of the prim", literal_only=True),
        "onlyPlayback": ONLY_PLAYBACK,
        "path": Attribute(
            "path",
            "path of a prim or property, where `prim` is empty",
            optional=True,
            literal_only=True,
            role="prim",
        ),
        "prim": Attribute("target", "the prim", optional=True, literal_only=True),
    },
    outputs={
        "changed": Attribute("execution", "fires once per evaluation, however much has changed"),
        "propertyName": Attribute("token", "the property that changed last"),
    },
    memory=Watch,
    release=_end_watch,
)
def on_object_change(db: Database) -> bool:
    """Fire when a property of a prim was written on the stage since the last evaluation."""
    inputs, watch = db.inputs, db.memory
    path, name = (inputs.prim[0] if inputs.prim else inputs.path), inputs.name
    if "." in path:
        path, _, name = path.partition(".")
    if not path:
        return False
    if watch.path != path:
        _end_watch(db)
        watch.path, watch.stop = path, _watch(db.app.stage, path, watch.changed)
    changed = [one for one in watch.changed if not name or one == name]
    watch.changed.clear()
    if not changed or ignored(db):
        return False
    db.outputs.propertyName = changed[-1]
    db.fire("changed")
    return True


def _watch(stage: Any, path: str, changed: list[str]) -> Callable[[], None]:
    """Records the names of the prim's properties as they change; returns the function that ends this."""

    def told(notice: Any) -> None:
        for one in (*notice.GetChangedInfoOnlyPaths(), *notice.GetResyncedPaths()):
            if one.IsPropertyPath() and str(one.GetPrimPath()) == path and one.name not in changed:
                changed.append(one.name)

    return StageWatch(stage, told)
