"""Texts joined, and made of other values."""

from __future__ import annotations

import itertools

from graph.node import Attribute, Database, node_type

from .conversions import VALUES, written
from .like_inputs import joined_text

TEXTS = ("string", "token", "token[]")


@node_type(
    "omni.graph.nodes.BuildString",
    version=2,
    inputs={"a": Attribute(TEXTS, "the start"), "b": Attribute(TEXTS, "what follows")},
    outputs={"value": Attribute(TEXTS, "all of it, of the type of a; an array where one of them is")},
    dynamic_inputs={"{operand}": Attribute(TEXTS, "what follows then")},
    resolve=joined_text,
)
def build_string(db: Database) -> None:
    """Join texts; arrays element by element, with a single text repeated for each."""
    parts = [db.inputs.a, db.inputs.b, *db.dynamic_inputs()]
    lengths = {len(part) for part in parts if isinstance(part, list)}
    if not lengths:
        db.claim(sum(map(len, parts)) * 4)
        db.outputs.value = "".join(parts)
        return
    if len(lengths) > 1:
        db.fail(f"the arrays have {' and '.join(map(str, sorted(lengths)))} elements; they need one length")
    [length] = lengths
    rows = [part if isinstance(part, list) else [part] * length for part in parts]
    db.claim(sum(map(len, itertools.chain.from_iterable(rows))) * 4)
    db.outputs.value = ["".join(row) for row in zip(*rows, strict=True)]


@node_type(
    "omni.graph.nodes.ToToken",
    version=1,
    inputs={"value": Attribute(VALUES, "the value to write down")},
    outputs={"converted": Attribute("token", "the value as a token")},
)
def to_token(db: Database) -> None:
    """Convert a value to a token, with the text of ToString."""
    db.outputs.converted = written(db.inputs.value, str(db.input_type("value")).endswith("[]"))
