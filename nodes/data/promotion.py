"""Output types of data nodes from their input types: the `resolve` functions of open attributes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from graph.base.suggest import did_you_mean
from graph.node import KnownTypes
from graph.values.conversion import convertible
from graph.values.types import DECIMALS, TYPES, Type, concrete_type

if TYPE_CHECKING:
    from graph.node.declaration import Resolve

    Answer = Mapping[str, Type]

_SIGNED_BITS = {"uchar": 9, "int": 32, "uint": 33, "int64": 64, "uint64": 64}


def common_storage(storages: Iterable[str]) -> str:
    """The storage for all of these numbers: the widest real one, else the narrowest integer (at most int64)."""
    given = set(storages)
    reals = [real for real in DECIMALS if real in given]
    if reals:
        return reals[-1]
    if len(given) == 1:
        return given.pop()
    bits = max(_SIGNED_BITS[storage] for storage in given)
    return "int" if bits <= 32 else "int64"


def common_type(types: Iterable[Type]) -> Type:
    """The type of a calculation with operands of these types: numbers are repeated to tuples, tuples to arrays.

    A role (point, vector, ...) is kept if all tuples have it. Raises ValueError for tuples of different size.
    """
    given = list(dict.fromkeys(types))
    if len(given) == 1:
        return given[0]
    shaped = [one for one in given if one.count > 1]
    storage = common_storage(one.storage for one in given)
    element = _common_tuple(shaped, storage) if shaped else TYPES[storage]
    if not shaped and all(one.role == "timecode" for one in given):
        element = TYPES["timecode"]
    return element.array_of() if any(one.array for one in given) else element


def _common_tuple(shaped: list[Type], storage: str) -> Type:
    first = shaped[0]
    if {(one.count, one.square) for one in shaped} != {(first.count, first.square)}:
        raise ValueError(f"{' and '.join(one.name for one in shaped)} have different numbers of components")
    if first.square:
        return first.element
    roles = {one.role for one in shaped}
    role = roles.pop() if len(roles) == 1 else ""
    if not role:
        return concrete_type(f"{storage if storage in (*DECIMALS, 'int') else 'double'}[{first.count}]")
    return concrete_type(f"{role}{storage[0]}[{first.count}]")


def promoted(output: str, *names: str) -> Resolve:
    """The output has the common type of these inputs; without names, of all inputs."""

    def resolve(known: KnownTypes) -> Answer:
        types = tuples_of_one_size(known, *names)
        return {output: common_type(types)} if types else {}

    return resolve


def quotient(output: str) -> Resolve:
    """As `promoted`, but the quotient of integers is a double."""

    def resolve(known: KnownTypes) -> Answer:
        types = tuples_of_one_size(known)
        if not types:
            return {}
        result = common_type(types)
        if result.storage in DECIMALS:
            return {output: result}
        double = common_type([TYPES["double"], *types])
        return {output: double}

    return resolve


def input_types(known: KnownTypes, *names: str) -> list[Type]:
    """The types of these inputs; without names, of all inputs. Empty while one of them is open."""
    chosen = [f"inputs:{name}" for name in names] or [name for name in known if name.startswith("inputs:")]
    types = [type_ for name in chosen if (type_ := known[name]) is not None]
    return types if len(types) == len(chosen) else []


def tuples_of_one_size(known: KnownTypes, *chosen: str) -> list[Type]:
    """As `input_types`. Raises ValueError, which names both inputs and their sources, for tuples of different size."""
    types = input_types(known, *chosen)
    if all(one.count == 1 for one in types):
        return types
    names = list(chosen) or [name.removeprefix("inputs:") for name in known if name.startswith("inputs:")]
    shaped = [(name, one) for name, one in zip(names, types, strict=False) if one.count > 1]
    for name, one in shaped[1:]:
        if (one.count, one.square) != (shaped[0][1].count, shaped[0][1].square):
            ends = f"{known.end(shaped[0][0])} and {known.end(name)}"
            raise ValueError(f"{ends} have different numbers of components; give it tuples of one size, or numbers")
    return types


def components_of(name: str, outputs: str) -> Resolve:
    """Each output is one number of the tuple; a tuple of another size is refused."""

    def resolve(known: KnownTypes) -> Answer:
        whole = known[f"inputs:{name}"]
        if whole is None:
            return {}
        if whole.count != len(outputs) or whole.square:
            other = f"; use BreakVector{whole.count}" if 2 <= whole.count <= 4 and not whole.square else ""
            raise ValueError(f"{known.end(name)} must have {len(outputs)} components{other}")
        return {f"outputs:{output}": whole.component for output in outputs}

    return resolve


def tuple_from(names: str, output: str) -> Resolve:
    """The output is a tuple of the inputs, or an array of tuples if an input is an array."""

    def resolve(known: KnownTypes) -> Answer:
        parts = input_types(known, *names)
        if not parts:
            return {}
        storage = common_storage(part.storage for part in parts)
        if storage not in (*DECIMALS, "int"):
            # OGN has tuples only of int, half, float and double.
            storage = "int" if storage == "uchar" else "double"
        whole = concrete_type(f"{storage}[{len(names)}]")
        for name, part in zip(names, parts, strict=True):
            if part.count > 1:
                raise ValueError(f"{known.end(name)} must be a number or an array of numbers")
        return {output: whole.array_of() if any(part.array for part in parts) else whole}

    return resolve


def array_of_first(known: KnownTypes) -> Answer:
    """ConstructArray: arrayType, or the array of the first resolved input; open inputs take its element type."""
    inputs = [name for name in known if name.startswith("inputs:input")]
    wanted = known.value("arrayType")
    if wanted == "auto":
        element = next((known[name] for name in inputs if known[name] is not None), None)
        if element is None:
            return {}
        array = element.array_of()
    else:
        array = concrete_type(wanted)
        for name in inputs:
            given = known[name]
            if given is not None and not convertible(given, array.element):
                end = known.end(name.removeprefix("inputs:"))
                raise ValueError(f"{end} cannot go into {array}; set arrayType to auto or correct it")
    return {"outputs:array": array, **{name: array.element for name in inputs if known[name] is None}}


def missing_variable(name: str, variables: Iterable[str]) -> str:
    """The mistake of a node that names a variable that its graph does not have."""
    if not name:
        return "input variableName is empty; give it the name of a graph variable"
    return f'the graph has no variable "{name}"{did_you_mean(name, variables)}'


def variable_type(known: KnownTypes) -> Answer:
    """`value` has the type of the graph variable named by `variableName`. Raises ValueError for an unknown one."""
    name = known.value("variableName")
    found = known.variable(name)
    if found is None and not known.unfinished:
        raise ValueError(missing_variable(name, known.variables))
    return {} if found is None else {"outputs:value": found, "inputs:value": found}


def condition_type(output: str, *names: str) -> Resolve:
    """The output is bool, or bool[] if one of the inputs is an array."""

    def resolve(known: KnownTypes) -> Answer:
        types = input_types(known, *names)
        if not types:
            return {}
        return {f"outputs:{output}": TYPES["bool[]" if any(one.array for one in types) else "bool"]}

    return resolve


def comparison_type(known: KnownTypes) -> Answer:
    """Compare: as `condition_type`, for two numbers, tuples of one size or texts, single or in arrays."""
    a, b = known["inputs:a"], known["inputs:b"]
    if a is None or b is None:
        return {}
    if _worded(a) != _worded(b) or (a.count, a.square) != (b.count, b.square):
        raise ValueError(
            f"{known.end('a')} and {known.end('b')} cannot be compared; give it two numbers, two texts or two tuples "
            "of one size"
        )
    return {"outputs:result": TYPES["bool[]" if a.array or b.array else "bool"]}


def _worded(type_: Type) -> bool:
    return type_.storage in ("token", "string")


def selected_type(known: KnownTypes) -> Answer:
    """SelectIf: the common type of both values, an array if the condition is one.

    A single condition selects a whole value, so both values need one shape.
    """
    types = input_types(known, "condition", "ifTrue", "ifFalse")
    if not types:
        return {}
    condition, *sides = types
    if sides[0].count != sides[1].count or (sides[0].array != sides[1].array and not condition.array):
        raise ValueError(f"{known.end('ifTrue')} and {known.end('ifFalse')} differ in shape; give it two of one shape")
    if all(side.numeric for side in sides):
        chosen = common_type(sides)
    elif sides[0].element is sides[1].element:
        chosen = sides[0] if sides[0].array else sides[1]
    elif all(side.text for side in sides):
        chosen = TYPES["string"]
    else:
        raise ValueError(
            f"{known.end('ifTrue')} and {known.end('ifFalse')} have no common type; give it two numbers, two texts or "
            "two values of one type"
        )
    return {"outputs:result": chosen.array_of() if condition.array and not chosen.array else chosen}


_ROLES = {
    "Color": "color",
    "Normal": "normal",
    "Point": "point",
    "Quaternion": "quat",
    "TexCoord": "texcoord",
    "Vector": "vector",
    "Matrix": "matrix",
    "Frame": "frame",
}
ROLES = ("None", "Color", "Frame", "Matrix", "Normal", "Point", "Quaternion", "TexCoord", "Timecode", "Vector")
"""The roles that ToDouble can give a value; None keeps the shape and removes the role."""


def double_of(known: KnownTypes) -> Answer:
    """ToDouble: the shape of the value in doubles, with the wanted role. Raises ValueError if OGN has no such type."""
    given = known["inputs:value"]
    if given is None:
        return {}
    wanted = known.value("role")
    if wanted == "Timecode":
        name = "timecode" if given.count == 1 else ""
    elif wanted != "None":
        name = f"{_ROLES[wanted]}d[{given.count}]" if wanted != "Frame" else f"frame[{given.count}]"
    elif given.square:
        name = f"matrixd[{given.count}]"
    else:
        name = "double" if given.count == 1 else f"double[{given.count}]"
    if name not in TYPES or TYPES[name].square != given.square:
        raise ValueError(f"{known.end('value')} cannot have the role {wanted}; set role to None or to one that fits")
    return {"outputs:converted": TYPES[f"{name}[]"] if given.array else TYPES[name]}


REAL_ROLES = ("None", "Color", "Normal", "Point", "Quaternion", "TexCoord", "Vector")
"""The roles that ToFloat and ToHalf can give a value; matrices, frames and time codes exist only in doubles."""


def real_of(storage: str) -> Resolve:
    """ToFloat, ToHalf: as `double_of`, in another storage."""

    def resolve(known: KnownTypes) -> Answer:
        given = known["inputs:value"]
        if given is None:
            return {}
        wanted = known.value("role")
        if wanted != "None":
            name = f"{_ROLES[wanted]}{storage[0]}[{given.count}]"
        else:
            name = storage if given.count == 1 else f"{storage}[{given.count}]"
        if name not in TYPES or given.square:
            role, way = (
                ("", "leave it in doubles") if wanted == "None" else (f" in the role {wanted}", "set role to None")
            )
            raise ValueError(f"{known.end('value')} cannot become {storage}{role}; {way}")
        return {"outputs:converted": TYPES[f"{name}[]"] if given.array else TYPES[name]}

    return resolve
