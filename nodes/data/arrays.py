"""Arrays constructed and indexed."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type
from graph.values.coercion import dtype_of
from graph.values.types import concrete_type

from .promotion import array_of_first, element_of

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
        "index": Attribute("int", "position from 0, or from the end where negative (-1 is the last)", default=0),
    },
    outputs={"value": Attribute(("array_elements",), "the element there")},
    resolve=element_of("array", "value"),
)
def array_index(db: Database) -> None:
    """Read one element of an array."""
    array, index = db.inputs.array, db.inputs.index
    if not -len(array) <= index < len(array):
        db.fail(f"input index is {index}, but the array has {len(array)} elements")
    element = array[index]
    db.outputs.value = element.item() if getattr(element, "ndim", None) == 0 else element
