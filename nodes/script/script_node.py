"""A node that runs its own Python script."""

from __future__ import annotations

import traceback
from importlib import import_module
from pathlib import Path
from typing import Any

from graph.base.inputs import start_of
from graph.base.records import dataclass, field
from graph.evaluate.script_permission import REFUSED
from graph.node import Attribute, Database, node_type
from graph.ogn.database import OgnDatabase, log_print
from graph.ogn.kit_modules import kit

MAX_BYTES = 1_000_000
CALLBACKS = ("setup", "compute", "cleanup")


@dataclass(slots=True)
class _Script:
    """The script as last read, and the functions that it defines."""

    origin: tuple[Any, ...] = ()
    """The source when it was read: the text itself, or a file and its modification time."""
    code: Any = None
    names: dict[str, Any] = field(default_factory=dict)
    db: ScriptView | None = None


class ScriptView(OgnDatabase):
    """The database of one script, with private memory that is made together with the script."""

    @property
    def internal_state(self) -> Any:
        """Whatever the script keeps between computes."""
        return self._own


def _clean_up(db: Database) -> None:
    """Calls the script's cleanup, if it was set up."""
    memory = db.memory
    if memory is not None and memory.db is not None:
        cleanup, script_db = memory.names.get("cleanup"), memory.db
        memory.db = None
        if callable(cleanup):
            _guarded(db, lambda: cleanup(script_db))


@node_type(
    "omni.graph.scriptnode.ScriptNode",
    version=2,
    runs_code=True,
    inputs={
        "execIn": Attribute("execution", "runs the script's compute"),
        "script": Attribute("string", "the script", default="", optional=True),
        "scriptPath": Attribute(
            "token", "file of the script where usePath is set, in the graph file's folder", default="", optional=True
        ),
        "usePath": Attribute("bool", "whether scriptPath names the script", default=False, optional=True),
    },
    outputs={"execOut": Attribute("execution", "follows unless compute returns False")},
    state={"omni_initialized": Attribute("bool", "whether the script has been set up")},
    dynamic_inputs={"{field}": Attribute("any", "an input that the file adds")},
    dynamic_outputs={"{field}": Attribute("any", "an output that the file adds")},
    memory=_Script,
    release=_clean_up,
)
def script_node(db: Database) -> bool:
    """Run a script: setup(db) before its first compute and when it changes, compute(db), cleanup(db) at the stop.

    A script without these functions runs as a whole each time, with `db` defined. Scripts run only if the user allows
    it: `graph run --allow-scripts`, or `allow_scripts=True` of App.from_file, run_node and run_graph.
    """
    if db.context.scripts != "run":
        if db.context.scripts == "skip":
            return False
        db.fail(f"it {REFUSED}")
    memory, origin = db.memory, _origin(db)
    if origin != memory.origin:
        _clean_up(db)
        memory.origin = ()
        _load(db, memory, origin)
    compute = memory.names.get("compute")
    if callable(compute):
        worked = _guarded(db, lambda: compute(memory.db))
    elif any(name in memory.names for name in CALLBACKS):
        worked = None
    else:
        worked = _guarded(db, lambda: exec(memory.code, memory.names))
    memory.db.outputs.close()
    if worked is False:
        db._enabled.clear()
        return False
    if "execOut" not in db._enabled:
        db.fire("execOut")
    return True


def _load(db: Database, memory: _Script, origin: tuple[Any, ...]) -> None:
    """Loads a script: defines its functions and calls its setup."""
    source = _text(db, *origin) if len(origin) > 1 else origin[0]
    memory.db = ScriptView(db)
    memory.names = {"__name__": "__script__", "db": memory.db, "print": log_print}
    with kit().acting_on(db.context.app):
        memory.names["og"] = import_module("omni.graph.core")
    memory.code = _guarded(db, lambda: compile(source, _label(db), "exec"))
    if any(f"def {name}" in source for name in CALLBACKS):
        _guarded(db, lambda: exec(memory.code, memory.names))
        setup = memory.names.get("setup")
        if callable(setup):
            _guarded(db, lambda: setup(memory.db))
    memory.origin = origin
    db.state.omni_initialized = True


def _origin(db: Database) -> tuple[Any, ...]:
    """The script's text, or its file and modification time. Fails the node for a file outside the allowed folders."""
    inputs = db.inputs
    if not inputs.usePath:
        return (str(inputs.script),)
    if not inputs.scriptPath:
        db.fail("input scriptPath is empty; give it the name of a Python file, or clear usePath")
    folders = [folder.resolve() for folder in getattr(db.context.app, "folders", ())] or [Path.cwd().resolve()]
    path = (folders[0] / inputs.scriptPath).resolve()
    if not any(path.is_relative_to(folder) for folder in folders):
        db.fail(f"input scriptPath names {path}, which lies outside {folders[0]}; move it there or allow its folder")
    try:
        return path, path.stat().st_mtime_ns
    except OSError as error:
        db.fail(f"{path} cannot be read: {error.strerror}")


def _text(db: Database, path: Path, _: int) -> str:
    """The text of the script's file."""
    try:
        data = start_of(path, MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            db.fail(f"{path} is larger than {MAX_BYTES} bytes; that is not a script")
        return data.decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        return str(db.fail(f"{path} cannot be read: {reason}"))


def _label(db: Database) -> str:
    return f"<script of {db.path}>"


def _guarded(db: Database, call: Any) -> Any:
    """The result of a call. Fails the node, with the script's line, if the script raises."""
    from graph.node.database import NodeError

    try:
        with kit().acting_on(db.context.app):
            return call()
    except NodeError:
        raise
    except Exception as error:
        label = _label(db)
        lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == label]
        line = error.lineno if isinstance(error, SyntaxError) else lines[-1] if lines else None
        text = error.msg if isinstance(error, SyntaxError) else str(error)
        text += kit().advice(error) if isinstance(error, ImportError) else ""
        raise NodeError(f"line {line} of its script: {type(error).__name__}: {text}") from error
