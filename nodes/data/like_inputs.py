"""Output types of data nodes that keep their input's type or shape; see `promotion` for calculations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from graph.node import KnownTypes
from graph.values.conversion import convertible
from graph.values.types import DECIMALS, TYPES, Type, concrete_type

from .promotion import common_type, input_types

if TYPE_CHECKING:
    from graph.node.declaration import Resolve

    Answer = Mapping[str, Type]


def same_type(name: str, output: str) -> Resolve:
    """The output has the type of the input."""

    def resolve(known: KnownTypes) -> Answer:
        given = known[f"inputs:{name}"]
        return {} if given is None else {f"outputs:{output}": given}

    return resolve


def renamed(name: str, output: str, element: str) -> Resolve:
    """The output has a fixed type, an array of it if the input is an array."""

    def resolve(known: KnownTypes) -> Answer:
        given = known[f"inputs:{name}"]
        return {} if given is None else {f"outputs:{output}": concrete_type(element + "[]" * given.array)}

    return resolve


def real_like(name: str, output: str) -> Resolve:
    """The output has the type of the input, with integers as doubles."""

    def resolve(known: KnownTypes) -> Answer:
        given = known[f"inputs:{name}"]
        if given is None or given.storage in DECIMALS:
            return {} if given is None else {f"outputs:{output}": given}
        real = TYPES["double"] if given.count == 1 else concrete_type(f"double[{given.count}]")
        return {f"outputs:{output}": real.array_of() if given.array else real}

    return resolve


def signed(name: str, output: str) -> Resolve:
    """The output has the type of the input. Raises ValueError for a type without negative numbers."""

    def resolve(known: KnownTypes) -> Answer:
        given = known[f"inputs:{name}"]
        if given is None:
            return {}
        if given.storage in ("uchar", "uint", "uint64"):
            raise ValueError(f"{known.end(name)} has no negative numbers; convert it to a type that has")
        return {f"outputs:{output}": given}

    return resolve


def whole_of(name: str, output: str) -> Resolve:
    """The output has the shape of the input, in ints. Raises ValueError for a matrix."""

    def resolve(known: KnownTypes) -> Answer:
        given = known[f"inputs:{name}"]
        if given is None:
            return {}
        if given.square:
            raise ValueError(f"{known.end(name)}: there are no matrices of whole numbers; give it numbers or tuples")
        element = "int" if given.count == 1 else f"int[{given.count}]"
        return {f"outputs:{output}": concrete_type(element + "[]" * given.array)}

    return resolve


def length_of(name: str, output: str) -> Resolve:
    """A number for a number; a real number for a vector; arrays of these for arrays. Raises ValueError for a matrix."""

    def resolve(known: KnownTypes) -> Answer:
        given = known[f"inputs:{name}"]
        if given is None:
            return {}
        if given.square:
            raise ValueError(f"{known.end(name)} is a matrix, which has no length; give it a number or a vector")
        number = given.component
        if given.count > 1 and number.storage not in DECIMALS:
            number = TYPES["double"]
        return {f"outputs:{output}": number.array_of() if given.array else number}

    return resolve


def product_of(output: str) -> Resolve:
    """A number for two vectors or two arrays of numbers; an array if one is an array of vectors."""

    def resolve(known: KnownTypes) -> Answer:
        types = input_types(known)
        if not types:
            return {}
        flat = [one.array and one.count == 1 for one in types]
        no_vector = any(one.square or (one.scalar and one.count == 1) for one in types)
        if no_vector or len(set(flat)) > 1 or len({one.count for one in types}) > 1:
            ends = f"{known.end('a')} and {known.end('b')}"
            raise ValueError(f"{ends} have no dot product; give it two vectors of one size")
        number = common_type(types).component
        return {f"outputs:{output}": number if all(flat) or not any(one.array for one in types) else number.array_of()}

    return resolve


def incremented(known: KnownTypes) -> Answer:
    """Increment: the result has the type of the value."""
    value = known["inputs:value"]
    return {} if value is None else {"outputs:result": value}


def edited_array(known: KnownTypes) -> Answer:
    """The output is an array like the input; an open `value` is one of its elements."""
    array = known["inputs:array"]
    return {} if array is None else {"outputs:array": array, **searched_array(known)}


def searched_array(known: KnownTypes) -> Answer:
    """An open `value` is an element of the array. Raises ValueError if it cannot be one."""
    return _element_input(known, "value")


def filled_array(known: KnownTypes) -> Answer:
    """The output is an array like the input; an open `fillValue` is one of its elements."""
    array = known["inputs:array"]
    return {} if array is None else {"outputs:array": array, **_element_input(known, "fillValue")}


def _element_input(known: KnownTypes, name: str) -> Answer:
    array = known["inputs:array"]
    if array is None or f"inputs:{name}" not in known:
        return {}
    value = known[f"inputs:{name}"]
    if value is None:
        return {f"inputs:{name}": array.element}
    if not convertible(value, array.element):
        raise ValueError(f"{known.end(name)} cannot go into {known.end('array')}; give it {array.element}")
    return {}


def appended(known: KnownTypes) -> Answer:
    """AppendArray: the type of the first resolved array, for all of them. Raises ValueError if another one differs."""
    inputs = [name for name in known if name.startswith("inputs:")]
    first = next((known[name] for name in inputs if known[name] is not None), None)
    if first is None:
        return {}
    for name in inputs:
        given = known[name]
        if given is not None and not convertible(given, first):
            start = next(one for one in inputs if known[one] is not None)
            ends = " and ".join(known.end(one.removeprefix("inputs:")) for one in (start, name))
            raise ValueError(f"{ends} cannot be put into one array; give it arrays of one type")
    return {"outputs:array": first, **{name: first for name in inputs if known[name] is None}}


def joined_text(known: KnownTypes) -> Answer:
    """BuildString: the type of `a`, an array if any part is one."""
    types = input_types(known)
    if not types:
        return {}
    return {"outputs:value": TYPES["token[]"] if any(one.array for one in types) else types[0]}
