"""The attribute types of OmniGraph: OGN names, storage, and the names of type groups.

Every concrete type is in one table, `TYPES`; `parse_type` also reads `any`, unions and groups. This module does not
need NumPy: values live in `graph.values.coercion`, conversions in `graph.values.conversion`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache

from graph.base.records import dataclass
from graph.base.suggest import did_you_mean

INTEGER_RANGES = {
    "uchar": (0, 2**8 - 1),
    "int": (-(2**31), 2**31 - 1),
    "uint": (0, 2**32 - 1),
    "int64": (-(2**63), 2**63 - 1),
    "uint64": (0, 2**64 - 1),
}
"""The smallest and largest value of each integer storage."""

DECIMALS = ("half", "float", "double")
"""Storages of real numbers, narrowest first."""

NUMBERS = (*INTEGER_RANGES, *DECIMALS)
"""Storages of numbers; bool is not one."""


@dataclass(frozen=True, eq=False, slots=True)
class Type:
    """One concrete type. Equal types are one object, so they can be compared with `is`.

    storage: what is kept (`double`, `token`, `target` ...); role: what it means (`point`, `quat`, `timecode` ...), or
    ""; count: numbers in a tuple or rows of a matrix, else 1; square: whether it is a matrix; array: whether it is an
    array of these.
    """

    name: str
    storage: str
    role: str = ""
    count: int = 1
    square: bool = False
    array: bool = False

    def __str__(self) -> str:
        return self.name

    def __reduce__(self) -> tuple[object, ...]:
        return concrete_type, (self.name,)

    @property
    def numeric(self) -> bool:
        """Whether its values are numbers: a scalar, a tuple, a matrix or an array of them."""
        return self.storage in NUMBERS

    @property
    def scalar(self) -> bool:
        """Whether it is a single value: not a tuple, matrix or array."""
        return self.count == 1 and not self.array

    @property
    def number(self) -> bool:
        """Whether it is a single number."""
        return self.numeric and self.scalar

    @property
    def text(self) -> bool:
        """Whether it is a single text: token, string or path."""
        return self.storage in ("token", "string") and self.scalar

    @property
    def shape(self) -> tuple[int, ...]:
        """The NumPy shape of one element: () for scalars, (n,) for tuples, (n, n) for matrices."""
        if self.count == 1:
            return ()
        return (self.count, self.count) if self.square else (self.count,)

    @property
    def element(self) -> Type:
        """The element type of an array; the type itself if it is not an array."""
        return TYPES[self.name.removesuffix("[]")]

    @property
    def component(self) -> Type:
        """The scalar type that a tuple, a matrix or an array consists of."""
        return TYPES[self.storage] if self.count > 1 else self.element

    def array_of(self) -> Type:
        """The array of this type. Raises ValueError if OGN has no such type."""
        return concrete_type(self.name + "[]")


@dataclass(frozen=True, slots=True)
class Extended:
    """A type that is still open:

    `any` (no members) or a union. Connections and values resolve it when the graph is compiled.
    """

    name: str
    members: tuple[Type, ...] = ()

    def __str__(self) -> str:
        return self.name

    def accepts(self, candidate: Type) -> bool:
        """Whether an attribute of this type can become `candidate`; `any` takes everything but execution."""
        return candidate in self.members if self.members else candidate.storage != "execution"


AnyType = Type | Extended


def _scalars() -> Iterator[Type]:
    for storage in ("bool", *NUMBERS, "token", "string", "target", "bundle", "execution"):
        yield Type(storage, storage)
    yield Type("path", "string", "path")
    yield Type("timecode", "double", "timecode")
    yield Type("objectId", "uint64", "objectId")


def _tuples() -> Iterator[Type]:
    for storage in ("int", *DECIMALS):
        for count in (2, 3, 4):
            yield Type(f"{storage}[{count}]", storage, "", count)
    counts = {"point": (3,), "vector": (3,), "normal": (3,), "color": (3, 4), "texcoord": (2, 3), "quat": (4,)}
    for role, allowed in counts.items():
        for storage in DECIMALS:
            for count in allowed:
                yield Type(f"{role}{storage[0]}[{count}]", storage, role, count)
    for count in (2, 3, 4):
        yield Type(f"matrixd[{count}]", "double", "matrix", count, square=True)
    yield Type("frame[4]", "double", "frame", 4, square=True)


def _table() -> dict[str, Type]:
    single = [*_scalars(), *_tuples()]
    arrayable = [one for one in single if one.numeric or one.name in ("bool", "token")]
    return {one.name: one for one in (*single, *(replace(e, name=e.name + "[]", array=True) for e in arrayable))}


TYPES: dict[str, Type] = _table()
"""Every concrete type by its OGN name."""

EXECUTION = TYPES["execution"]


def concrete_type(name: str) -> Type:
    """The concrete type with that OGN name. Raises ValueError with the nearest name for any other text."""
    try:
        return TYPES[name]
    except KeyError:
        raise ValueError(f'no attribute type "{name}"{did_you_mean(name, TYPES)}') from None


def _groups() -> dict[str, tuple[Type, ...]]:
    def group(storages: Iterable[str]) -> dict[str, tuple[Type, ...]]:
        elements = [
            one for one in TYPES.values() if one.storage in storages and not one.array and one.name != "objectId"
        ]
        scalars = tuple(one for one in elements if one.count == 1)
        tuples = tuple(one for one in elements if one.count > 1)
        arrays = tuple(one.array_of() for one in elements)
        return {"scalers": scalars, "tuples": tuples, "array_elements": scalars + tuples, "arrays": arrays}

    groups: dict[str, tuple[Type, ...]] = {}
    for kind, storages in (("integral", tuple(INTEGER_RANGES)), ("decimal", DECIMALS), ("numeric", NUMBERS)):
        parts = group(storages)
        groups |= {f"{kind}_{part}": members for part, members in parts.items()}
        groups[f"{kind}s"] = parts["array_elements"] + parts["arrays"]
    arrays = tuple(one for one in TYPES.values() if one.array)
    return groups | {
        "matrices": tuple(one for one in TYPES.values() if one.square),
        "bools": (TYPES["bool"], TYPES["bool[]"]),
        "strings": (TYPES["string"], TYPES["path"], TYPES["token"], TYPES["token[]"]),
        "array_elements": tuple(one.element for one in arrays),
        "arrays": arrays,
    }


GROUPS: dict[str, tuple[Type, ...]] = _groups()
"""Names of several types, used in a union; "scalers" is OGN's spelling."""


def parse_type(spec: str | Sequence[str]) -> AnyType:
    """The type that a declaration names: an OGN name, `any`, a group, or a sequence of names and groups (a union).

    Raises ValueError with the nearest name for anything else.
    """
    return _parse(spec if isinstance(spec, str) else tuple(spec))


@cache
def _parse(spec: str | tuple[str, ...]) -> AnyType:
    if isinstance(spec, str):
        if spec in TYPES:
            return TYPES[spec]
        if spec == "any":
            return Extended("any")
        spec = (spec,)
    if not spec:
        raise ValueError("a union needs at least one type")
    if "any" in spec:
        return Extended("any")
    members: dict[Type, None] = {}
    for name in spec:
        if name not in TYPES and name not in GROUPS:
            raise ValueError(f'no attribute type "{name}"{did_you_mean(name, (*TYPES, *GROUPS, "any"))}')
        members |= dict.fromkeys(GROUPS.get(name) or (TYPES[name],))
    return Extended(" | ".join(spec), tuple(members))
