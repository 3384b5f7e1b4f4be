"""Output types of data nodes that keep their input's type or shape; see `promotion` for calculations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial, wraps
from typing import TYPE_CHECKING

from graph.node import KnownTypes
from graph.values.conversion import convertible
from graph.values.types import DECIMALS, TYPES, Type, concrete_type

from .promotion import common_type, input_types

if TYPE_CHECKING:
    from graph.node.declaration import Resolve

    Answer = Mapping[str, Type]
    End = Callable[[], str]


def _from_input(type_of: Callable[..., Type]) -> Callable[..., Resolve]:
    """Makes the `resolve` of an output from `type_of(end, type, *more)` of one input.

    `end()` names the input and its source in an error message. The result is called with the input's name, the
    output's name, and `more`. While the input's type is unknown, the output's is.
    """

    @wraps(type_of)
    def made(name: str, output: str, *more: str) -> Resolve:
        def resolve(known: KnownTypes) -> Answer:
            given = known[f"inputs:{name}"]
            return {} if given is None else {f"outputs:{output}": type_of(partial(known.end, name), given, *more)}

        return resolve

    return made


@_from_input
def same_type(_end: End, given: Type) -> Type:
    """The output has the type of the input."""
    return given


@_from_input
def element_of(_end: End, given: Type) -> Type:
    """The output is an element of the array input."""
    return given.element


@_from_input
def renamed(_end: End, given: Type, element: str) -> Type:
    """The output has a fixed type, an array of it if the input is an array."""
    return concrete_type(element + "[]" * given.array)


@_from_input
def real_like(_end: End, given: Type) -> Type:
    """The output has the type of the input, with integers as doubles."""
    if given.storage in DECIMALS:
        return given
    real = TYPES["double"] if given.count == 1 else concrete_type(f"double[{given.count}]")
    return real.array_of() if given.array else real


@_from_input
def signed(end: End, given: Type) -> Type:
    """The output has the type of the input. Raises ValueError for a type without negative numbers."""
    if given.storage in ("uchar", "uint", "uint64"):
        raise ValueError(f"{end()} has no negative numbers; convert it to a type that has")
    return given


@_from_input
def whole_of(end: End, given: Type) -> Type:
    """The output has the shape of the input, in ints. Raises ValueError for a matrix."""
    if given.square:
        raise ValueError(f"{end()}: there are no matrices of whole numbers; give it numbers or tuples")
    element = "int" if given.count == 1 else f"int[{given.count}]"
    return concrete_type(element + "[]" * given.array)


@_from_input
def length_of(end: End, given: Type) -> Type:
    """A number for a number; a real number for a vector; arrays of these for arrays. Raises ValueError for a matrix."""
    if given.square:
        raise ValueError(f"{end()} is a matrix, which has no length; give it a number or a vector")
    number = given.component
    if given.count > 1 and number.storage not in DECIMALS:
        number = TYPES["double"]
    return number.array_of() if given.array else number


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
