"""Records are dataclasses, as the standard ones behave."""

import copy
import dataclasses
import inspect
import pickle
from functools import cached_property
from typing import ClassVar, Generic, TypeVar

import pytest

from graph.base import records

T = TypeVar("T")
BOTH = pytest.mark.parametrize("module", [records, dataclasses], ids=["ours", "standard"])


@records.dataclass(frozen=True, slots=True)
class Point:
    """A place."""

    x: int
    y: int = 2
    tags: list[str] = records.field(default_factory=list, compare=False, repr=False)


def classes(module):
    @module.dataclass(frozen=True, slots=True)
    class Base(Generic[T]):
        kind: ClassVar[str] = "base"
        first: int
        second: tuple[int, ...] = (1, 2)
        hidden: int = module.field(default=5, repr=False, compare=False)

        def __post_init__(self):
            if self.first < 0:
                raise ValueError("negative")

        @property
        def double(self):
            return 2 * self.first

    @module.dataclass(frozen=True, slots=True)
    class Derived(Base[int]):
        third: str = module.field(default="c", kw_only=True)

    @module.dataclass(slots=True)
    class Open:
        values: list[int] = module.field(default_factory=list)
        count: int = module.field(default=0, init=False)

    @module.dataclass(frozen=True)
    class Cached:
        number: int

        @cached_property
        def square(self):
            return self.number**2

    @module.dataclass(eq=False)
    class Unequal:
        number: int = 1

    @module.dataclass(slots=True)
    class Own:
        number: int

        def __repr__(self):
            return "own"

        def __hash__(self):
            return 7

    return Base, Derived, Open, Cached, Unequal, Own


@BOTH
def test_values_defaults_and_what_is_derived(module):
    base, derived, opened, cached, unequal, own = classes(module)
    one = derived(1, third="d")
    assert (one.first, one.second, one.hidden, one.third, one.double, one.kind) == (1, (1, 2), 5, "d", 2, "base")
    assert repr(one).endswith("Derived(first=1, second=(1, 2), third='d')")
    assert (one == derived(1, third="d", hidden=9), one == derived(2), one == base(1)) == (True, False, False)
    assert hash(one) == hash(derived(1, third="d"))
    assert not hasattr(one, "__dict__")
    assert opened().values is not opened().values
    assert opened([1]).count == 0
    with pytest.raises(TypeError, match="unhashable"):
        hash(opened())
    assert cached(3).square == 9
    assert unequal() != unequal()
    assert len({unequal(), unequal()}) == 2
    assert (repr(own(1)), hash(own(1)), own(1) == own(1)) == ("own", 7, True)
    assert base.__match_args__ == ("first", "second", "hidden")


@BOTH
def test_what_is_refused(module):
    base, derived, _, cached, *_ = classes(module)
    for make in (base, derived):
        with pytest.raises(TypeError, match="missing 1 required positional argument: 'first'"):
            make()
        with pytest.raises(TypeError, match="unexpected keyword argument 'forth'"):
            make(1, forth=1)
    for instance in (base(1), derived(1), cached(1)):
        with pytest.raises(dataclasses.FrozenInstanceError, match="cannot assign to field"):
            instance.first = 2
        with pytest.raises(dataclasses.FrozenInstanceError, match="cannot delete field"):
            del instance.first
    with pytest.raises(ValueError, match="negative"):
        base(-1)
    with pytest.raises(ValueError, match="mutable default"):

        @module.dataclass
        class Shared:
            values: list[int] = []  # noqa: RUF012


@BOTH
def test_the_functions_of_the_standard_module_work_on_it(module):
    base, derived, opened, *_ = classes(module)
    assert [one.name for one in dataclasses.fields(derived)] == ["first", "second", "hidden", "third"]
    assert dataclasses.replace(derived(1), first=4) == derived(4)
    assert dataclasses.asdict(opened([1, 2])) == {"values": [1, 2], "count": 0}
    assert dataclasses.is_dataclass(base)
    assert str(inspect.signature(opened)).startswith("(values")
    assert copy.copy(derived(3)) == derived(3)

    @dataclasses.dataclass(frozen=True)
    class Standard(base):
        more: int = 0

    assert Standard(1, more=2) == Standard(1, (1, 2), 5, 2)


def test_it_is_pickled_and_copied_with_all_its_values():
    point = Point(1, tags=["a"])
    for made in (pickle.loads(pickle.dumps(point)), copy.deepcopy(point)):
        assert made == point
        assert made.tags == ["a"]
        assert made.tags is not point.tags
