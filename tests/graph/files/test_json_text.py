import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graph.base.errors import UserError
from graph.files.json_text import parse
from tests.support.parsed_texts import reading

tree, only_problem = reading(parse, "a.json")


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=20,
)


@settings(max_examples=200, deadline=None)
@given(value=json_values, indent=st.sampled_from([None, 0, 3, "\t"]), ascii_only=st.booleans())
def test_every_text_the_standard_library_writes_is_read_back(value, indent, ascii_only):
    root, problems = tree(json.dumps(value, indent=indent, ensure_ascii=ascii_only))
    assert problems == []
    assert json.dumps(root) == json.dumps(value)


@settings(max_examples=300, deadline=None)
@given(text=st.text(alphabet='{}[]:,"\\ \n1.5eE+-truefalsnNIity', max_size=30))
def test_a_text_is_refused_exactly_where_the_standard_library_refuses_it(text):
    def both(read):
        try:
            return read(text)
        except (ValueError, UserError):
            return "refused"

    ours = both(lambda text: tree(text)[0])
    theirs = both(json.loads)
    if math.inf not in _numbers(theirs):
        assert json.dumps(ours) == json.dumps(theirs) or _repeats_a_key(text)


def _numbers(value):
    if isinstance(value, (int, float)):
        return [abs(value)]
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return [number for part in parts for number in _numbers(part)]


def _repeats_a_key(text):
    return bool(tree(text)[1])


def test_a_repeated_key_is_a_problem_at_its_second_place_and_the_first_stands():
    root, problems = tree('{\n "a": 1,\n "b": {"x": 1, "x": 2},\n "a": 3}')
    assert root == {"a": 1, "b": {"x": 1}}
    assert problems == [
        'a.json:3:16: key "x" is repeated; it is already in line 3',
        'a.json:4:2: key "a" is repeated; it is already in line 2',
    ]


def test_escapes_in_keys_count_as_what_they_mean():
    assert tree('{"a": 1, "\\u0061": 2}')[1] == ['a.json:1:10: key "a" is repeated; it is already in line 1']


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('{"a": 1,}', 'a.json:1:8: this is not JSON: remove the comma before "}"'),
        ("[1, 2,\n]", 'a.json:1:6: this is not JSON: remove the comma before "]"'),
        ('{"a" 1}', 'a.json:1:6: this is not JSON: expected ":" after key "a"'),
        ('{"a": 1 "b": 2}', 'a.json:1:9: this is not JSON: expected "," or "}"'),
        ("{a: 1}", "a.json:1:2: this is not JSON: expected a key in double quotes"),
        ('{"a": tru}', "a.json:1:7: this is not JSON: expected a value"),
        ('{"a": "x', "a.json:1:7: this is not JSON: unterminated string"),
        ('{"a": "\\q"}', "a.json:1:8: this is not JSON: invalid \\escape"),
        ('{"a": "x\ny"}', "a.json:1:9: this is not JSON: invalid control character"),
        ('{"a": ', "a.json:1:7: this is not JSON: the text ends too early"),
        ('{"a": 1', 'a.json:1:8: this is not JSON: expected "," or "}"'),
        ('{"a": 1} x', "a.json:1:10: this is not JSON: more text after the end of the document"),
        ("[" * 101 + "]" * 101, "a.json:1:101: this is not JSON: nested deeper than 100"),
        ('{"a": // x\n1}', "a.json:1:7: this is not JSON: expected a value"),
    ],
)
def test_broken_text_is_one_line_with_its_place(text, line):
    assert only_problem(text) == line


def test_nesting_of_a_hundred_is_read():
    root, problems = tree("[" * 100 + "]" * 100)
    depth = 0
    while root is not None:
        root, depth = (root[0] if root else None), depth + 1
    assert (depth, problems) == (100, [])


def test_numbers_beyond_a_double_are_problems():
    assert tree('{"a": 1e999}')[1] == ["a.json:1:7: 1e999 is larger than any double"]
    assert tree(f'{{"a": 1{"0" * 309}}}')[1] == ["a.json:1:7: a number of 310 digits is larger than any double"]


def test_nan_and_infinity_are_values():
    root, _ = tree("[NaN, Infinity, -Infinity]")
    assert math.isnan(root[0])
    assert root[1:] == [math.inf, -math.inf]


def test_places_of_keys_values_and_items():
    root, _ = tree('{"a" : ["x", {"k": 5}]}')
    assert root.places["a"] == (1, 7)
    assert root["a"].item_at == [8, 13]
    assert root["a"][1].places["k"] == (14, 19)
