"""Measures and searches arrays, and returns edited copies; inputs are never written to."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from graph.node import Attribute, Database, node_type
from graph.values.conversion import converter
from graph.values.types import concrete_type
from nodes.bounds import at_least

from .like_inputs import appended, edited_array, searched_array

ARRAYS, ELEMENTS = ("arrays",), ("array_elements",)
ARRAY = Attribute(ARRAYS, "the array")
INDEX = Attribute("int", "position from 0, or from the end where negative (-1 is the last)", default=0)


@node_type(
    "omni.graph.nodes.ArrayGetSize",
    version=1,
    inputs={"array": ARRAY},
    outputs={"size": Attribute("int", "elements of the array")},
)
def array_get_size(db: Database) -> None:
    """Count the elements of an array."""
    db.outputs.size = len(db.inputs.array)


@node_type(
    "omni.graph.nodes.ArrayFindValue",
    version=1,
    inputs={"array": ARRAY, "value": Attribute(ELEMENTS, "the element to look for")},
    outputs={"index": Attribute("int", "position of the first equal element; -1 without one")},
    resolve=searched_array,
)
def array_find_value(db: Database) -> None:
    """Find the first element that equals a value."""
    db.outputs.index = next(iter(places_of(db.inputs.array, db.inputs.value)), -1)


@node_type(
    "omni.graph.nodes.ArraySetIndex",
    version=1,
    inputs={
        "array": ARRAY,
        "index": INDEX,
        "resizeToFit": Attribute("bool", "whether an index behind the end makes the array longer", default=False),
        "value": Attribute(ELEMENTS, "the element to put there"),
    },
    outputs={"array": Attribute(ARRAYS, "the array with that element")},
    resolve=edited_array,
)
def array_set_index(db: Database) -> None:
    """Replace one element; with resizeToFit, an index behind the end extends the array with zeros."""
    array, index = db.inputs.array, db.inputs.index
    length = len(array)
    if index >= length and db.inputs.resizeToFit:
        length = index + 1
    if not -len(array) <= index < length:
        fit = "; set resizeToFit or correct it" if index > 0 else ""
        db.fail(f"input index is {index}, but the array has {len(array)} elements{fit}")
    result = resized(db, array, length)
    result[index] = element_for(db, "value")
    db.outputs.array = result


@node_type(
    "omni.graph.nodes.ArrayInsertValue",
    version=1,
    inputs={
        "array": ARRAY,
        "index": Attribute("int", "position before which it goes, from the end where negative", default=0),
        "value": Attribute(ELEMENTS, "the element to put in"),
    },
    outputs={"array": Attribute(ARRAYS, "the array with one element more")},
    resolve=edited_array,
)
def array_insert_value(db: Database) -> None:
    """Insert an element; an index beyond either end means that end."""
    array, index = db.inputs.array, db.inputs.index
    length = len(array)
    position = min(max(index if index >= 0 else index + length, 0), length)
    result = resized(db, array, length + 1)
    result[position + 1 :] = array[position:]
    result[position] = element_for(db, "value")
    db.outputs.array = result


@node_type(
    "omni.graph.nodes.ArrayResize",
    version=1,
    check=at_least(newSize=0),
    inputs={"array": ARRAY, "newSize": Attribute("int", "elements that it is to have", default=0)},
    outputs={"array": Attribute(ARRAYS, "the array cut off, or filled up with zeros")},
    resolve=edited_array,
)
def array_resize(db: Database) -> None:
    """Give an array another length."""
    size = db.inputs.newSize
    if size < 0:
        db.fail(f"input newSize is {size}; give it 0 or more")
    db.outputs.array = resized(db, db.inputs.array, size)


@node_type(
    "omni.graph.nodes.AppendArray",
    version=1,
    inputs={"input0": Attribute(ARRAYS, "the first array"), "input1": Attribute(ARRAYS, "the second array")},
    outputs={"array": Attribute(ARRAYS, "all of them, one behind the other")},
    dynamic_inputs={"input{n}": Attribute(ARRAYS, "one more array")},
    resolve=appended,
)
def append_array(db: Database) -> None:
    """Join arrays of one type."""
    arrays = db.dynamic_inputs("input")
    db.claim(sum(len(array) * 8 if isinstance(array, list) else array.nbytes for array in arrays))
    if isinstance(arrays[0], list):
        db.outputs.array = [text for array in arrays for text in array]
        return
    import numpy as np

    db.outputs.array = np.concatenate(arrays)


def resized(db: Database, array: Any, size: int) -> Any:
    """A copy of the array, cut off or extended with zeros (in matrices too) or empty texts."""
    each = 8 if isinstance(array, list) else array.dtype.itemsize * math.prod(array.shape[1:])
    db.claim(size * each)
    if isinstance(array, list):
        return array[:size] + [""] * (size - len(array))
    import numpy as np

    result = np.zeros((size, *array.shape[1:]), array.dtype)
    result[: len(array)] = array[:size]
    return result


def element_for(db: Database, name: str) -> Any:
    """The value of an input as an element of the array."""
    value_type, array_type = db.input_type(name), db.input_type("array")
    if value_type is None or array_type is None:
        return getattr(db.inputs, name)
    convert: Callable[[Any], Any] | None = converter(concrete_type(value_type), concrete_type(array_type).element)
    try:
        return getattr(db.inputs, name) if convert is None else convert(getattr(db.inputs, name))
    except ValueError as error:
        return db.fail(f"input {name}: {error}")


def places_of(array: Any, value: Any) -> list[int]:
    """Indices of the elements that equal a value."""
    if isinstance(array, list):
        return [place for place, one in enumerate(array) if one == value]
    import numpy as np

    same = np.atleast_1d(array == value).reshape(len(array), -1).all(axis=1) if len(array) else np.zeros(0, bool)
    return [int(place) for place in np.flatnonzero(same)]
