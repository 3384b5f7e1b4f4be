import math
import sys

import pytest

from graph.base.errors import UserError
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
            "a.yaml:1:4: the [ that opens here is not closed; add a ]",
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
            "a.yaml:1:6: \\q is no escape in double quotes; write \\\\q, or take single quotes",
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


FILE = """\
tickgraph: 1
scene:
  prims:
    /World/Ground: {type: Plane}
    /World/Ball:
      type: Sphere
      radius: 0.25
clock: {physics_hz: 240, loop_hz: 60}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      log: {type: PrintText, inputs: {text: hello}}
    connections:
      - tick.tick -> log.execIn
      - tick.tick -> log.execIn
"""


@pytest.mark.parametrize(
    ("right", "wrong", "line"),
    [
        ("    nodes:", "\tnodes:", "11:1: a tab cannot indent YAML; use spaces"),
        ("type: Sphere", "type:\tSphere", "6:12: a tab stands between words; use a space"),
        ("scene:", "scene", '2:1: a colon is missing; write "scene:"'),
        ("type: Sphere", "type Sphere", '6:7: a colon is missing; write "type: Sphere"'),
        ("radius: 0.25", "radius = 0.25", '7:7: a colon is missing; write "radius: 0.25"'),
        ("radius: 0.25", "radius:0.25", '7:7: a space is missing after the colon; write "radius: 0.25"'),
        ("{type: Plane}", "{type:Plane}", '4:21: a space is missing after the first colon of "type:Plane"'),
        (
            "      radius",
            "        radius",
            '7:9: this line is indented by 8 spaces, deeper than "type: Sphere" above it, which has its value already; '
            "indent both by 6",
        ),
        (
            "      radius",
            "     radius",
            "7:6: no line above is indented by 5 spaces as this one is; indent it by 4 (as line 5) or 6 (as line 6)",
        ),
        (
            "clock:",
            " clock:",
            "8:2: no line above is indented by 1 space as this one is; indent it by 0 (as line 2) or 2 (as line 3)",
        ),
        ("text: hello", 'text: "hello', '13:45: the quote " that opens here is not closed; add a "'),
        ("text: hello", "text: 'hello", "13:45: the quote ' that opens here is not closed; add a '"),
        ("{type: Plane}", "{type: Plane", "4:20: the { that opens here is not closed; add a }"),
        ("radius: 0.25", "scale: [1, 2, 3", "7:14: the [ that opens here is not closed; add a ]"),
        ("{type: Plane}", "{type: Plane]", "4:32: this ] closes the { of line 4; write }"),
        ("{type: Plane}", "{type: Plane}}", "4:33: this } closes nothing; remove it"),
        ("240, loop", "240 loop", '8:25: a comma is missing before "loop_hz"'),
        ("radius: 0.25", "type: Cube", '7:7: key "type" is repeated; it is already in line 6'),
        (
            "      - tick.tick -> log.execIn\n      -",
            "  - tick.tick -> log.execIn\n  -",
            '15:3: indent the items of "connections" at least as far as its line, by 4 spaces',
        ),
        (
            "In\n      - tick",
            "In\n    - tick",
            "16:5: this item of a list is indented by 4 spaces, the one in line 15 by 6; indent both alike",
        ),
        (
            "In\n      - tick",
            "In\n        - tick",
            '16:9: this "- " is indented deeper than the item above, so that it belongs to its text; indent both alike',
        ),
        (
            "      log:",
            "      - log:",
            '13:7: a list item ("- ") stands among keys; remove the "- ", or write all of them as items',
        ),
        ("type: Sphere", "type: a: b", '6:14: a value with a colon in it needs quotes; write type: "a: b"'),
        ("radius: 0.25", "radius: @x", "7:15: a value cannot begin with @; put it in quotes"),
        (
            "radius: 0.25",
            'color: "a" b',
            "7:18: text follows a value that has ended; put quotes around it all",
        ),
    ],
)
def test_a_slip_of_the_keyboard_is_told_in_plain_words(right, wrong, line):
    assert FILE.count(right) == 1
    problems = []
    try:
        problems = tree(FILE.replace(right, wrong))[1]
    except UserError as error:
        problems = [str(one) for one in error.problems]
    assert problems == [f"a.yaml:{line}"]


def test_a_quote_that_another_line_closes_is_told_where_it_opens():
    text = FILE.replace("radius: 0.25", 'color: "red').replace("text: hello", 'text: "hello"')
    with pytest.raises(UserError, match=r"a\.yaml:7:14: the quote \" that opens here is not closed in its line; add a"):
        tree(text)
