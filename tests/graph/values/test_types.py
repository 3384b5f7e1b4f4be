"""Type names, values of types, and which types may meet."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graph.values.coercion import coerce, dtype_of, zero
from graph.values.conversion import converter, convertible, settle, way_between
from graph.values.types import GROUPS, INTEGER_RANGES, TYPES, Extended, concrete_type, parse_type
from graph.values.untyped import natural_type, typed_value


def test_every_name_reads_back_as_itself():
    assert all(parse_type(name).name == name and parse_type(name) is TYPES[name] for name in TYPES)


@pytest.mark.parametrize(
    ("name", "storage", "role", "shape"),
    [
        ("double[3]", "double", "", (3,)),
        ("pointf[3]", "float", "point", (3,)),
        ("colorh[4]", "half", "color", (4,)),
        ("texcoordd[2]", "double", "texcoord", (2,)),
        ("quatd[4]", "double", "quat", (4,)),
        ("matrixd[4]", "double", "matrix", (4, 4)),
        ("frame[4]", "double", "frame", (4, 4)),
        ("timecode", "double", "timecode", ()),
        ("objectId", "uint64", "objectId", ()),
        ("path", "string", "path", ()),
    ],
)
def test_what_a_name_stands_for(name, storage, role, shape):
    type_ = TYPES[name]
    assert (type_.storage, type_.role, type_.shape) == (storage, role, shape)


def test_an_unknown_name_suggests_the_nearest():
    with pytest.raises(ValueError, match=r'no attribute type "doubel\[3\]"; did you mean "double\[3\]"\?'):
        concrete_type("doubel[3]")


@pytest.mark.parametrize(
    "name", ["string[]", "target[]", "execution[]", "uint[3]", "double[5]", "pointd[4]", "matrixf[4]"]
)
def test_types_that_ogn_does_not_have_are_refused(name):
    with pytest.raises(ValueError, match=r"no attribute type"):
        parse_type(name)


def test_groups_hold_what_their_names_say():
    assert [one.name for one in GROUPS["integral_scalers"]] == ["uchar", "int", "uint", "int64", "uint64"]
    assert [one.name for one in GROUPS["decimal_scalers"]] == ["half", "float", "double", "timecode"]
    assert set(GROUPS["numerics"]) == {*GROUPS["numeric_scalers"], *GROUPS["numeric_tuples"], *GROUPS["numeric_arrays"]}
    assert TYPES["bool"] not in GROUPS["numerics"]
    assert TYPES["token[]"] in GROUPS["arrays"]
    assert {one.name for one in GROUPS["matrices"]} == {
        *(f"matrixd[{n}]{tail}" for n in (2, 3, 4) for tail in ("", "[]")),
        "frame[4]",
        "frame[4][]",
    }


def test_a_union_accepts_its_members_and_any_all_but_execution():
    union = parse_type(("numeric_scalers", "token"))
    assert isinstance(union, Extended)
    assert union.accepts(TYPES["half"])
    assert union.accepts(TYPES["token"])
    assert not union.accepts(TYPES["double[3]"])
    assert parse_type("any").accepts(TYPES["bundle"])
    assert not parse_type("any").accepts(TYPES["execution"])


def test_zeros():
    assert [zero(TYPES[name]) for name in ("bool", "int", "double", "token", "target", "bundle")] == [
        False,
        0,
        0.0,
        "",
        [],
        {},
    ]
    assert zero(TYPES["quatd[4]"]).tolist() == [0, 0, 0, 1]
    assert zero(TYPES["matrixd[3]"]).tolist() == np.eye(3).tolist()
    assert zero(TYPES["pointf[3][]"]).shape == (0, 3)
    assert zero(TYPES["pointf[3][]"]).dtype == np.float32
    assert zero(parse_type("any")) is None


@pytest.mark.parametrize(
    ("name", "written", "value"),
    [
        ("int", 3.0, 3),
        ("uchar", 255, 255),
        ("uint64", 2**64 - 1, 2**64 - 1),
        ("double", 2, 2.0),
        ("half", math.inf, math.inf),
        ("bool", True, True),
        ("token", "", ""),
        ("target", "/World/A", ["/World/A"]),
        ("target", ["/A", "/B"], ["/A", "/B"]),
        ("token[]", ["a", "b"], ["a", "b"]),
        ("timecode", 1.5, 1.5),
    ],
)
def test_values_that_fit(name, written, value):
    coerced = coerce(TYPES[name], written)
    assert coerced == value
    assert type(coerced) is type(value)


@pytest.mark.parametrize(
    ("name", "written", "value"),
    [
        ("double[3]", [1, 2, 3], [1.0, 2.0, 3.0]),
        ("int[]", [], []),
        ("int[]", [1.0, -2], [1, -2]),
        ("uint64[]", [2**64 - 1, 1], [2**64 - 1, 1]),
        ("bool[]", [True, False], [True, False]),
        ("float[2][]", [[1, 2], [3, 4]], [[1, 2], [3, 4]]),
        ("matrixd[2]", [1, 2, 3, 4], [[1, 2], [3, 4]]),
        ("matrixd[2][]", [[1, 2, 3, 4]], [[[1, 2], [3, 4]]]),
        ("quatf[4]", [0, 0, 0, 1], [0, 0, 0, 1]),
    ],
)
def test_arrays_that_fit_have_the_types_own_dtype_and_are_read_only(name, written, value):
    coerced = coerce(TYPES[name], written)
    assert coerced.tolist() == value
    assert coerced.dtype == dtype_of(TYPES[name])
    assert not coerced.flags.writeable


def test_nan_is_a_number_for_reals_alone():
    assert math.isnan(coerce(TYPES["double"], math.nan))
    assert np.isnan(coerce(TYPES["float[]"], [math.nan])).all()
    with pytest.raises(ValueError, match=r"expected a whole number"):
        coerce(TYPES["int"], math.nan)
    with pytest.raises(ValueError, match=r"expected a whole number"):
        coerce(TYPES["int[]"], [math.nan])


@pytest.mark.parametrize(
    ("name", "written", "message"),
    [
        ("int", 1.5, "expected a whole number (int), got 1.5"),
        ("int", "5", "expected a whole number (int), got '5'"),
        ("int", True, "expected a whole number (int), got True"),
        ("int", 2**31, "2147483648 does not fit int (-2147483648 to 2147483647)"),
        ("uchar", -1, "-1 does not fit uchar (0 to 255)"),
        ("half", 65505, "65505 does not fit half"),
        ("float", 1e39, "1e+39 does not fit float"),
        ("double", 10**400, "does not fit double"),
        pytest.param("double", 10**5000, "a number of thousands of digits does not fit double", id="huge real"),
        pytest.param("int", 10**5000, "a number of thousands of digits does not fit int", id="huge integer"),
        ("double", "fast", "expected a number (double), got 'fast'"),
        ("bool", 1, "expected true or false, got 1"),
        ("token", 5, "expected text, got 5; put it in quotes"),
        ("target", 5, "expected a prim path or a list of prim paths, got 5"),
        ("token[]", "a", "expected a list of texts (token[]), got 'a'"),
        ("double[3]", [1, 2], "expected 3 numbers (double[3]), got [1, 2]"),
        ("double[3]", 1, "expected 3 numbers (double[3]), got 1"),
        ("double[]", [1, [2]], "expected a list of numbers (double[]), got [1, [2]]"),
        ("double[]", [1, "2"], "expected a list of numbers (double[]), got [1, '2']"),
        ("double[]", [1.5, True], "expected a list of numbers (double[]), got [1.5, True]"),
        ("float[3][]", [[1, 2]], "expected a list of elements of 3 numbers (float[3][]), got [[1, 2]]"),
        ("matrixd[2]", [[1, 2, 3]], "expected 2 x 2 numbers (matrixd[2])"),
        ("uchar[]", [256], "[256] does not fit uchar[] (0 to 255 each)"),
        ("float[]", [1e39], "does not fit float[]"),
        ("bool[]", [1, 0], "expected a list of true and false (bool[]), got [1, 0]"),
        ("execution", True, "hold no value that can be set; connect it instead"),
    ],
)
def test_values_that_do_not_fit_are_refused_in_one_line(name, written, message):
    with pytest.raises(ValueError, match=re.escape(message)) as caught:
        coerce(TYPES[name], written)
    assert "\n" not in str(caught.value)


ALLOWED = [
    ("double", "float"),
    ("float", "double"),
    ("int", "float"),
    ("double", "timecode"),
    ("double", "int"),
    ("uint64", "objectId"),
    ("double[3]", "vectord[3]"),
    ("quatd[4]", "double[4]"),
    ("matrixd[4]", "frame[4]"),
    ("pointf[3][]", "float[3][]"),
    ("string", "token"),
    ("token", "path"),
]
REFUSED = [
    ("double[3]", "double"),
    ("double", "double[3]"),
    ("double", "double[]"),
    ("double[]", "double"),
    ("float[3]", "double[3]"),
    ("float[]", "double[]"),
    ("matrixd[2]", "double[4]"),
    ("bool", "int"),
    ("int", "bool"),
    ("execution", "bool"),
    ("target", "path"),
    ("bundle", "double"),
    ("token", "token[]"),
    ("string", "double"),
]


@pytest.mark.parametrize(("source", "target"), ALLOWED)
def test_conversions_that_omnigraph_allows(source, target):
    assert convertible(TYPES[source], TYPES[target])


@pytest.mark.parametrize(("source", "target"), REFUSED)
def test_conversions_that_omnigraph_does_not_allow(source, target):
    assert not convertible(TYPES[source], TYPES[target])
    with pytest.raises(TypeError, match=r"cannot feed"):
        converter(TYPES[source], TYPES[target])


@pytest.mark.parametrize(
    ("source", "target", "way"),
    [
        ("double[3]", "arrays", "make an array with ConstructArray"),
        ("double", "numeric_tuples", "make a tuple with MakeVector2, MakeVector3 or MakeVector4"),
        ("double[3]", "decimal_scalers", "take a component with BreakVector3"),
        ("token[]", ("token", "bool"), "take an element with ArrayIndex"),
        ("bool", "numerics", "convert it with ToDouble"),
        ("int[2]", "strings", "convert it with ToString"),
        ("string", "numerics", "give it a number, a matrix, a tuple of numbers or an array of numbers"),
        ("token", "bools", "give it bool or bool[]"),
        ("string", "arrays", "give it an array of numbers or a token[] or bool[]"),
    ],
)
def test_a_union_that_refuses_a_type_says_the_way_or_what_it_takes(source, target, way):
    assert way_between(TYPES[source], parse_type(target)) == f"; {way}"


@pytest.mark.parametrize(("source", "target"), [("execution", "numerics"), ("int", "numerics"), ("int", "any")])
def test_no_way_is_reported_to_a_union_that_takes_it_or_into_execution(source, target):
    assert way_between(TYPES[source], parse_type(target)) == ""


def test_numbers_are_converted_towards_zero_and_never_wrap():
    to_int = converter(TYPES["double"], TYPES["int"])
    assert [to_int(one) for one in (2.9, -2.9, 0.0)] == [2, -2, 0]
    for value in (math.nan, math.inf, 2.0**31):
        with pytest.raises(ValueError, match=r"does not fit int"):
            to_int(value)
    assert converter(TYPES["int"], TYPES["int64"]) is None
    assert converter(TYPES["int"], TYPES["double"])(3) == 3.0
    with pytest.raises(ValueError, match=r"-1 does not fit uint \(0 to 4294967295\)"):
        converter(TYPES["int"], TYPES["uint"])(-1)


def test_readers_of_arrays_always_get_arrays_of_their_type():
    convert = converter(TYPES["double[3]"], TYPES["vectord[3]"])
    array = np.array([1.0, 2.0, 3.0])
    assert convert(array) is array
    assert convert((1, 2, 3)).dtype == np.float64
    assert converter(TYPES["float[]"], TYPES["float[]"])([1.0]).dtype == np.float32
    assert converter(TYPES["pointf[3][]"], TYPES["pointf[3][]"])([]).shape == (0, 3)
    with pytest.raises(ValueError, match=r"expected vectord\[3\], got an array of shape \(2,\)"):
        convert([1, 2])


def test_an_open_type_takes_the_sources_type_or_the_nearest_it_converts_to():
    assert settle(TYPES["half"], parse_type("any")) is TYPES["half"]
    assert settle(TYPES["int"], parse_type(("numerics",))) is TYPES["int"]
    assert settle(TYPES["int64"], parse_type(("uchar", "double"))) is TYPES["double"]
    assert settle(TYPES["token"], parse_type(("numerics",))) is None


def test_untyped_values_are_taken_for_the_likeliest_type():
    assert natural_type(1)[0].name == "int"
    assert natural_type(1.0)[0].name == "double"
    assert natural_type("a")[0].name == "token"
    assert natural_type([1.0, 2, 3])[0].name == "double[3]"
    assert natural_type([1.0] * 5)[0].name == "double[]"
    assert natural_type([[1.0, 2]] * 3)[0].name == "double[2][]"
    assert natural_type(np.zeros(7, np.float32))[0].name == "float[]"
    assert natural_type({}) == []


def test_a_value_may_carry_its_type():
    type_, value = typed_value({"type": "float[3]", "value": [1, 2, 3]})
    assert type_ is TYPES["float[3]"]
    assert value.dtype == np.float32
    assert typed_value({"value": 1}) is None
    with pytest.raises(ValueError, match=r"no attribute type"):
        typed_value({"type": "flaot", "value": 1})


@given(st.sampled_from(sorted(INTEGER_RANGES)), st.integers(-(2**70), 2**70))
@settings(max_examples=200, deadline=None)
def test_integers_are_kept_exactly_or_refused(storage, value):
    low, high = INTEGER_RANGES[storage]
    if low <= value <= high:
        assert coerce(TYPES[storage], value) == value
        assert coerce(TYPES[f"{storage}[]"], [value]).tolist() == [value]
    else:
        for name, written in ((storage, value), (f"{storage}[]", [value])):
            with pytest.raises(ValueError, match=r"does not fit"):
                coerce(TYPES[name], written)


@given(
    st.sampled_from(sorted(TYPES)),
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
        lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
        max_leaves=8,
    ),
)
@settings(max_examples=300, deadline=None)
def test_any_value_is_taken_or_refused_with_one_line_and_taken_values_are_stable(name, value):
    try:
        coerced = coerce(TYPES[name], value)
    except ValueError as error:
        refused = str(error)
    else:
        refused = "refused"
        np.testing.assert_array_equal(coerce(TYPES[name], coerced), coerced)
    assert len(refused.splitlines()) == 1


@given(st.sampled_from(sorted(TYPES)), st.sampled_from(sorted(TYPES)))
@settings(max_examples=300, deadline=None)
def test_every_allowed_conversion_gives_a_value_of_the_target_from_the_sources_zero(source, target):
    if convertible(TYPES[source], TYPES[target]) and TYPES[source].storage not in ("execution", "bundle"):
        convert = converter(TYPES[source], TYPES[target])
        value = zero(TYPES[source])
        converted = coerce(TYPES[target], value if convert is None else convert(value))
        np.testing.assert_array_equal(coerce(TYPES[target], converted), converted)
