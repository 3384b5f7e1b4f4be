"""A node that only copies its input."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type


@node_type(
    "isaacsim.core.nodes.IsaacTestNode",
    version=1,
    inputs={
        "execIn": Attribute("execution", "copies the text"),
        "input": Attribute("string", "a text"),
    },
    outputs={"output": Attribute("string", "the same text")},
)
def test_node(db: Database) -> None:
    """Copy a text."""
    db.outputs.output = db.inputs.input
