"""Arrays made, indexed, filled, shortened, rotated and sliced; inputs are never written to."""

from __future__ import annotations

from typing import Any

from graph.node import Attribute, Database, node_type
from graph.values.coercion import dtype_of
from graph.values.types import concrete_type

from .array_edits import ARRAY, ARRAYS, ELEMENTS, INDEX, element_for, places_of, resized
from .like_inputs import edited_array, element_of, filled_array, same_type
from .promotion import array_of_first

ELEMENT = Attribute(("array_elements",), "an element")
_NAMES = (
    *("bool", "double", "float", "half", "int", "int64", "token", "uchar", "uint", "uint64"),
    *("double[2]", "double[3]", "double[4]", "matrixd[2]", "matrixd[3]", "matrixd[4]"),
    *("float[2]", "float[3]", "float[4]", "half[2]", "half[3]", "half[4]", "int[2]", "int[3]", "int[4]"),
    *("timecode", "frame[4]"),
    *(f"color{kind}[{size}]" for size in (3, 4) for kind in "dfh"),
    *(f"{role}{kind}[3]" for role in ("normal", "point") for kind in "dfh"),
    *(f"quat{kind}[4]" for kind in "dfh"),
    *(f"texcoord{kind}[{size}]" for size in (2, 3) for kind in "dfh"),
    *(f"vector{kind}[3]" for kind in "dfh"),
)
ARRAY_TYPES = ("auto", *(f"{name}[]" for name in _NAMES))


@node_type(
    "omni.graph.nodes.ConstructArray",
    version=1,
    inputs={
        "arraySize": Attribute("int", "elements of the array", default=1, literal_only=True, minimum=0),
        "arrayType": Attribute(
            "token",
            "type of the array; auto takes that of the first input whose type is known",
            default="auto",
            literal_only=True,
            allowed_tokens=ARRAY_TYPES,
        ),
        "input0": ELEMENT,
    },
    outputs={"array": Attribute(("arrays",), "the array")},
    dynamic_inputs={"input{n}": ELEMENT},
    resolve=array_of_first,
)
def construct_array(db: Database) -> None:
    """Make an array of input0, input1, ...; a smaller arraySize truncates it, a larger one repeats the last element."""
    size = db.inputs.arraySize
    if size < 0:
        db.fail(f"input arraySize is {size}; give it 0 or more")
    elements = db.dynamic_inputs("input")[:size]
    array_type = concrete_type(str(db.output_type("array")))
    db.claim(size * 8 * max(1, array_type.count) * (array_type.count if array_type.square else 1))
    elements += elements[-1:] * (size - len(elements))
    if array_type.storage == "token":
        db.outputs.array = elements
        return
    import numpy as np

    try:
        db.outputs.array = np.array(elements, dtype_of(array_type)).reshape(size, *array_type.shape)
    except OverflowError:
        db.fail(f"an input does not fit {array_type.element}; choose a wider arrayType")


@node_type(
    "omni.graph.nodes.ArrayIndex",
    version=1,
    inputs={
        "array": Attribute(("arrays",), "the array to look into"),
        "index": INDEX,
    },
    outputs={"value": Attribute(("array_elements",), "the element there")},
    resolve=element_of("array", "value"),
)
def array_index(db: Database) -> None:
    """Read one element of an array."""
    array, index = db.inputs.array, _index(db)
    element = array[index]
    db.outputs.value = element.item() if getattr(element, "ndim", None) == 0 else element


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
        "index": INDEX,
    },
    outputs={"array": CHANGED},
    resolve=same_type("array", "array"),
)
def array_remove_index(db: Database) -> None:
    """Remove one element from an array; an index out of range fails."""
    array, index = db.inputs.array, _index(db)
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


def _index(db: Database) -> int:
    """The input index. Fails the node if the array has no such element."""
    index: int = db.inputs.index
    length = len(db.inputs.array)
    if not -length <= index < length:
        db.fail(f"input index is {index}, but the array has {length} elements")
    return index
