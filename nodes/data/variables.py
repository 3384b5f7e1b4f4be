"""Graph variables, read and written by the nodes of a graph."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type

from .promotion import missing_variable, variable_type

NAME = Attribute("token", "name of the variable", default="", literal_only=True)
GRAPH = Attribute(
    "target", "the graph that owns the variable; none means the node's own graph, and no other is allowed"
)
TARGET_PATH = Attribute("token", "prim of a graph instance; not supported, leave it empty", default="", optional=True)


def _check(db: Database) -> str:
    """The variable's name. Fails the node if its graph does not have the variable."""
    name: str = db.inputs.variableName
    own = db.path.rpartition("/")[0]
    other = [path for path in db.inputs.graph or () if path != own]
    if other:
        db.fail(f"input graph is {other[0]}; a node reaches only the variables of its own graph, {own}")
    if db.inputs.targetPath:
        db.fail("input targetPath names a graph instance; leave it empty")
    if name not in db.variables:
        db.lack(missing_variable(name, db.variables))
    return name


@node_type(
    "omni.graph.core.ReadVariable",
    version=2,
    volatile=True,
    inputs={"graph": GRAPH, "targetPath": TARGET_PATH, "variableName": NAME},
    outputs={"value": Attribute("any", "the variable's value")},
    resolve=variable_type,
)
def read_variable(db: Database) -> None:
    """Read a variable."""
    db.outputs.value = db.variables[_check(db)]


@node_type(
    "omni.graph.core.WriteVariable",
    version=2,
    inputs={
        "execIn": Attribute("execution", "writes the value"),
        "graph": GRAPH,
        "targetPath": TARGET_PATH,
        "value": Attribute("any", "the value to write, of the variable's type"),
        "variableName": NAME,
    },
    outputs={
        "execOut": Attribute("execution", "follows once the value is written"),
        "value": Attribute("any", "the value that was written"),
    },
    resolve=variable_type,
)
def write_variable(db: Database) -> None:
    """Write a variable and pass the value on."""
    name = _check(db)
    db.variables[name] = db.inputs.value
    db.outputs.value = db.variables[name]
    db.fire("execOut")
