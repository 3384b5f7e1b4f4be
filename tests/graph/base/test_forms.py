"""Forms: what data they take, where errors are, and that the JSON Schema says the same."""

from typing import Annotated, Any, Literal

import jsonschema  # type: ignore[import-untyped]
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graph.base.forms import KEY, Before, Check, Error, Field, Form, FormError, Refused, Wrap


def _even(value):
    if type(value) is not int or value % 2:
        raise Refused("must be even")
    return value


Even = Annotated[int, Check(_even, {"type": "integer", "multipleOf": 2})]


def _named(value):
    return {"name": value} if isinstance(value, str) else value


class Leaf(Form):
    """A leaf."""

    name: str = Field(min_length=1, description="What it is called.")
    size: float | None = None
    kind: Literal["flat", "round"] = "flat"


class Tree(Form):
    """A tree."""

    leaves: dict[str, Annotated[Leaf, Before(_named, str | Leaf)]] = Field(default_factory=dict)
    ages: list[Even] = Field(default_factory=list)
    either: str | int | None = None
    count: Annotated[int, Field(ge=0, le=9)] | None = None
    branch: Annotated[Any, Wrap(lambda value, inner: value, Any)] = None


def errors_of(data):
    with pytest.raises(FormError) as raised:
        Tree.read(data)
    return raised.value.errors


def test_a_form_gives_values_defaults_and_what_was_given():
    tree = Tree.read({"leaves": {"a": "oak", "b": {"name": "elm", "size": 2, "kind": "round"}}, "count": None})
    assert (tree.leaves["a"].name, tree.leaves["a"].size, tree.leaves["b"].size) == ("oak", None, 2)
    assert (tree.ages, tree.either, tree.count, tree.given) == ([], None, None, {"leaves"})
    assert tree.leaves["b"].plain() == {"name": "elm", "size": 2, "kind": "round"}
    assert (tree.replaced(either=3).either, tree.replaced(either=3).given) == (3, {"leaves"})
    with pytest.raises(AttributeError, match="read only"):
        tree.count = 3


def test_every_error_is_collected_with_its_place():
    data = {
        "leaves": {"a": {"size": True, "kind": "flat"}, "b": 5, "c": {"name": "", "kind": "square"}},
        "ages": [2, 3],
        "either": 1.5,
        "count": 10,
        "other": 1,
    }
    assert errors_of(data) == [
        Error("number", ("leaves", "a", "size")),
        Error("missing", ("leaves", "a", "name")),
        Error("mapping", ("leaves", "b")),
        Error("limit", ("leaves", "c", "name"), ("min_length", 1)),
        Error("choice", ("leaves", "c", "kind"), ("flat", "round")),
        Error("refused", ("ages", 1), "must be even"),
        Error("text or whole", ("either",)),
        Error("limit", ("count",), ("le", 9)),
        Error("unknown", ("other",)),
    ]


def test_an_error_of_a_key_says_that_it_is_the_key():
    class Names(Form):
        """Names."""

        by_number: dict[Even, int] = Field(default_factory=dict)

    with pytest.raises(FormError) as raised:
        Names.read({"by_number": {3: 1}})
    assert raised.value.errors == [Error("refused", ("by_number", 3, KEY), "must be even")]


PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 12) | st.floats(0, 2) | st.sampled_from(["", "flat", "oak"]),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["leaves", "ages", "either", "name", "size", "kind"]), inner, max_size=4)
    ),
    max_leaves=8,
)


@given(st.dictionaries(st.sampled_from(["leaves", "ages", "either", "count", "branch", "x"]), PLAIN, max_size=4))
def test_a_form_takes_what_its_schema_takes(data):
    """An integer such as 2.0 is one for JSON Schema and none for a strict form; there the schema may take more."""
    valid = jsonschema.Draft202012Validator(Tree.schema()).is_valid(data)
    try:
        Tree.read(data)
    except FormError:
        assert not valid or "." in repr(data)
    else:
        assert valid
