"""Arrays filled, shortened, rotated and sliced; inputs are never written to."""

from __future__ import annotations

from typing import Any

from graph.node import Attribute, Database, node_type

from .array_edits import ARRAY, ARRAYS, ELEMENTS, element_for, places_of, resized
from .like_inputs import edited_array, filled_array, same_type

CHANGED = Attribute(ARRAYS, "the array that comes of it")


@node_type(
    "omni.graph.nodes.ArrayAppendValue",
    version=1,
    inputs={"array": ARRAY, "value": Attribute(ELEMENTS, "the element to put at the end")},
    outputs={"array": CHANGED},
    resolve=edited_array,
)
def array_append_value(db: Database) -> None:
    """Append an element to an array."""
    array = db.inputs.array
    result = resized(db, array, len(array) + 1)
    result[len(array)] = element_for(db, "value")
    db.outputs.array = result


@node_type(
    "omni.graph.nodes.ArrayFill",
    version=1,
    inputs={"array": ARRAY, "fillValue": Attribute(ELEMENTS, "what every element is to be")},
    outputs={"array": CHANGED},
    resolve=filled_array,
)
def array_fill(db: Database) -> None:
    """Give an array of the same length with one value everywhere."""
    array, value = db.inputs.array, element_for(db, "fillValue")
    if isinstance(array, list):
        db.outputs.array = [value] * len(array)
        return
    result = resized(db, array, len(array))
    result[:] = value
    db.outputs.array = result


@node_type(
    "omni.graph.nodes.ArrayRemoveIndex",
    version=1,
    inputs={
        "array": ARRAY,
        "index": Attribute("int", "position from 0, or from the end where negative (-1 is the last)", default=0),
    },
    outputs={"array": CHANGED},
    resolve=same_type("array", "array"),
)
def array_remove_index(db: Database) -> None:
    """Remove one element from an array; an index out of range fails."""
    array, index = db.inputs.array, db.inputs.index
    if not -len(array) <= index < len(array):
        db.fail(f"input index is {index}, but the array has {len(array)} elements")
    db.outputs.array = _without(array, [index % len(array)])


@node_type(
    "omni.graph.nodes.ArrayRemoveValue",
    version=1,
    inputs={
        "array": ARRAY,
        "removeAll": Attribute("bool", "whether to take out every such element, not just the first", default=False),
        "value": Attribute(ELEMENTS, "the element to take out"),
    },
    outputs={"array": CHANGED, "found": Attribute("bool", "whether there was one")},
    resolve=edited_array,
)
def array_remove_value(db: Database) -> None:
    """Remove the elements that equal a value from an array."""
    array = db.inputs.array
    places = places_of(array, element_for(db, "value"))
    db.outputs.found = bool(places)
    db.outputs.array = _without(array, places if db.inputs.removeAll else places[:1])


@node_type(
    "omni.graph.nodes.ArrayRotate",
    version=1,
    inputs={
        "array": ARRAY,
        "steps": Attribute("int", "places to go towards the end, towards the start where negative", default=0),
    },
    outputs={"array": CHANGED},
    resolve=same_type("array", "array"),
)
def array_rotate(db: Database) -> None:
    """Rotate an array: elements that leave it at one end enter at the other."""
    array = db.inputs.array
    steps = db.inputs.steps % len(array) if len(array) else 0
    if isinstance(array, list):
        db.outputs.array = array[len(array) - steps :] + array[: len(array) - steps]
        return
    import numpy as np

    db.outputs.array = np.roll(array, steps, axis=0)


@node_type(
    "omni.graph.nodes.ArraySlice",
    version=1,
    inputs={
        "array": Attribute(("arrays", "string"), "the array, or a text"),
        "end": Attribute("int", "position behind the last element taken, from the end where negative", default=0),
        "start": Attribute("int", "position of the first element taken, from the end where negative", default=0),
        "useLength": Attribute(
            "bool", "whether to take all to the end instead of the elements up to `end`", default=True
        ),
    },
    outputs={"array": Attribute(("arrays", "string"), "the elements from start to end, the end left out")},
    resolve=same_type("array", "array"),
)
def array_slice(db: Database) -> None:
    """Take a part of an array; positions out of range mean its ends, a start behind the end gives an empty array."""
    array, inputs = db.inputs.array, db.inputs
    part = array[inputs.start : len(array) if inputs.useLength else inputs.end]
    db.outputs.array = part.copy() if hasattr(part, "dtype") else part


@node_type(
    "omni.graph.nodes.PartialSum",
    version=1,
    inputs={"array": Attribute("int[]", "whole numbers", default=[])},
    outputs={"partialSum": Attribute("int[]", "for each place the sum of the numbers before it", default=[])},
)
def partial_sum(db: Database) -> None:
    """Sum the elements before each position: 3, 1, 4 gives 0, 3, 4. A sum that no int can hold fails."""
    import numpy as np

    array = db.inputs.array
    sums = np.cumsum(array, dtype=np.int64) - array
    if len(sums) and np.abs(sums).max() >= 2**31:
        db.fail(f"a sum of {len(array)} numbers is {int(np.abs(sums).max())}, which an int cannot hold")
    db.outputs.partialSum = sums.astype(np.int32)


def _without(array: Any, places: list[int]) -> Any:
    """The array without the elements at these places."""
    if isinstance(array, list):
        left_out = set(places)
        return [one for place, one in enumerate(array) if place not in left_out]
    import numpy as np

    return np.delete(array, places, axis=0)
