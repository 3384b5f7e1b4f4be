"""Values of a type of one's choice, for attributes that take many, and what nodes make of them."""

from graph.testing import run_node


def of(type_name, value):
    """An input that is of this type."""
    return {"type": type_name, "value": value}


def outcome(kind, output="result", **inputs):
    """An output of a node of this kind, and the name of its type."""
    trace = run_node(kind, inputs=inputs)
    return trace.value(output), trace.node.types[f"outputs:{output}"].name


def result(kind, output="result", **inputs):
    """The outcome with arrays as lists."""
    value, type_name = outcome(kind, output, **inputs)
    return (value.tolist() if hasattr(value, "tolist") else value), type_name
