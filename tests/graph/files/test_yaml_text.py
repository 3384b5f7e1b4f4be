import math
import sys

import pytest

from graph.files import parse_value
from graph.files.yaml_text import parse
from tests.support.parsed_texts import reading

tree, only_problem = reading(parse, "a.yaml")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e3", 1000.0),
        ("1E-3", 0.001),
        (".5", 0.5),
        ("5.", 5.0),
        ("-12", -12),
        ("+12", 12),
        ("0o17", 15),
        ("0x1F", 31),
        ("010", 10),
        ("on", "on"),
        ("off", "off"),
        ("yes", "yes"),
        ("No", "No"),
        ("y", "y"),
        ("true", True),
        ("False", False),
        ("TRUE", True),
        ("null", None),
        ("~", None),
        ("1_000", "1_000"),
        ("12:30:00", "12:30:00"),
        ("2001-01-01", "2001-01-01"),
        ("1/240", "1/240"),
        ("0b11", "0b11"),
        (".", "."),
        ("e3", "e3"),
        ("'1'", "1"),
        ('"true"', "true"),
        (".inf", math.inf),
        ("-.Inf", -math.inf),
        ("!!str 5", "5"),
        ("!!float 5", 5.0),
        ("! 5", "5"),
        ("[1, 2.5, on]", [1, 2.5, "on"]),
        ("{a: 1, on: 2, 3: x, ~: y, true: z}", {"a": 1, "on": 2, "3": "x", "~": "y", "true": "z"}),
        ("", ""),
    ],
)
def test_scalars_follow_the_core_schema_of_yaml_1_2(text, value):
    found = parse_value(text)
    assert found == value
    assert type(found) is type(value) or isinstance(value, (list, dict))


def test_not_a_number_is_read_as_one():
    assert math.isnan(parse_value(".nan"))


def test_whole_float_stays_a_float():
    assert isinstance(parse_value("5.0"), float)


def test_a_repeated_key_is_a_problem_at_its_second_place_and_the_first_stands():
    root, problems = tree("a: 1\nb: 2\na: 3\n")
    assert root == {"a": 1, "b": 2}
    assert problems == ['a.yaml:3:1: key "a" is repeated; it is already in line 1']


def test_a_key_written_in_two_ways_is_repeated():
    assert tree("'on': 1\non: 2\n")[1] == ['a.yaml:2:1: key "on" is repeated; it is already in line 1']


def test_aliases_share_the_value_of_their_anchor():
    root, problems = tree("base: &b {x: 1}\nother: *b\nlist: [*b, *b]\n")
    assert root == {"base": {"x": 1}, "other": {"x": 1}, "list": [{"x": 1}, {"x": 1}]}
    assert problems == []


def test_an_anchor_may_be_set_again():
    assert tree("a: &x 1\nb: *x\nc: &x 2\nd: *x\n")[0] == {"a": 1, "b": 1, "c": 2, "d": 2}


def test_an_alias_without_anchor_is_named():
    assert only_problem("a: *gone\n") == "a.yaml:1:4: alias *gone has no anchor &gone above it"


def test_an_alias_inside_its_own_anchor_is_refused():
    assert only_problem("a: &x [1, *x]\n") == "a.yaml:1:11: alias *x stands inside its own anchor"


def test_an_alias_bomb_is_refused_at_the_alias_that_goes_too_far():
    bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n"
    for level in range(1, 9):
        bomb += f"a{level}: &a{level} [{', '.join([f'*a{level - 1}'] * 10)}]\n"
    assert "the aliases of this file stand for more than 100,000 values" in only_problem(bomb)


def test_merge_keys_are_refused_with_the_reason():
    assert tree("a: &a {x: 1}\nb:\n  <<: *a\n")[1] == [
        "a.yaml:3:3: YAML 1.2 has no merge keys (<<); write the keys out"
    ]


@pytest.mark.parametrize("tag", ["!!python/object:os.system", "!mine", "!!set", "!!binary", "!!timestamp"])
def test_foreign_tags_are_refused(tag):
    _, problems = tree(f"a: {tag} x\n")
    shown = tag.replace("!!", "tag:yaml.org,2002:")
    assert problems == [f'a.yaml:1:4: tag "{shown}" is not read; graph files are plain data. Remove the tag']


def test_a_tag_that_does_not_fit_its_value_is_a_problem():
    assert tree("a: !!int x\n")[1] == ['a.yaml:1:4: "x" does not fit the tag int']


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("a:\n\tb: 1\n", "a.yaml:2:1: a tab cannot indent YAML; use spaces"),
        ("#usda 1.0\n( a: b: c )\n", "a.yaml:1:1: this is USD text; give it a name that ends in .usda"),
        (
            "a: [1, 2\nb: 3\n",
            "a.yaml:2:2: this is not YAML: while parsing a flow sequence from line 1 on, "
            "expected ',' or ']', but got ':'",
        ),
        ("a: 1\n---\nb: 2\n", "a.yaml:2:1: a second document starts here; a graph file holds one"),
        ("%YAML 1.1\n---\na: 1\n", "a.yaml:2:1: graph files are YAML 1.2, not 1.1; remove the directive"),
        (
            "? [a, b]\n: 1\n",
            "a.yaml:1:3: a key must be text, not a list or a mapping; quote it if it is meant as text",
        ),
        ("x: &a [1]\n*a : 2\n", "a.yaml:2:1: a key must be text; this alias stands for something else"),
        (
            'a: "\\q"\n',
            "a.yaml:1:6: this is not YAML: while scanning a double-quoted scalar, found unknown escape character 'q'",
        ),
        ("# nothing\n", 'a.yaml:1:1: the file is empty; a graph file starts with "tickgraph: 1"'),
        ("[" * 101 + "]" * 101, "a.yaml:1:101: nested deeper than 100"),
    ],
)
def test_text_that_cannot_be_read_is_one_line_with_its_place(text, line):
    assert only_problem(text) == line


def test_block_nesting_is_limited_as_well():
    assert only_problem("- " * 101 + "x\n") == "a.yaml:1:201: nested deeper than 100"
    tree("- " * 100 + "x\n")


@pytest.mark.parametrize("number", ["9" * 401, "9" * 309, "-1" + "0" * 309, "0x1" + "0" * 256, "1e999"])
def test_numbers_beyond_a_double_are_problems(number):
    _, [problem] = tree(f"a: {number}\n")
    assert problem.startswith("a.yaml:1:4: ")
    assert "too long" in problem or "larger than any double" in problem


def test_the_largest_double_is_read_as_an_integer_too():
    largest = int(sys.float_info.max)
    root, problems = tree(f"a: {largest}\n")
    assert (root["a"], problems) == (largest, [])


def test_a_value_of_no_characters_is_at_its_key():
    root, _ = tree("a:\n\n  # nothing\nb: ''\nc: {d: , e: 1}\n")
    assert root.places["a"] == (0, 0)
    assert root.places["b"] == (16, 19)
    assert root["c"].places["d"] == (26, 26)


def test_places_of_keys_values_and_items():
    root, _ = tree("a:\n  - x\n  - {k: v}\n")
    assert root.places["a"] == (0, 5)
    assert root["a"].item_at == [7, 13]
    assert root["a"][1].places["k"] == (14, 17)
