"""Tables of the commands at the width of a terminal: no word is broken."""

import pytest

from graph.cli.sensors import HEADINGS, described, row
from graph.cli.tables import TEXT, hanging, table_lines, wrapped_last
from graph.sim.fidelity import KNOBS
from sensors.configs.shipped import all_assets

WORDS = ("NAME", "N", "SAID")
ROWS = [("one", "1", "a text of some length that has to wrap"), ("a-long-name-of-thirty-letters-", "22", "short")]


def test_what_fits_is_one_line_a_row():
    head, body = table_lines(ROWS, WORDS, 80)
    assert head == ["NAME                            N   SAID"]
    assert body == [
        "one                             1   a text of some length that has to wrap",
        "a-long-name-of-thirty-letters-  22  short",
    ]


def test_text_wraps_at_spaces_below_itself():
    """60 columns less 30 + 2 and two gaps of 2 leave 24 for the text, the least that a text keeps."""
    _, body = table_lines(ROWS, WORDS, 60)
    assert TEXT == 24
    assert body[:2] == [
        "one                             1   a text of some length",
        "                                    that has to wrap",
    ]


def test_a_name_that_leaves_too_little_room_has_a_line_of_its_own():
    head, body = table_lines(ROWS, WORDS, 50)
    assert head == ["NAME", "  N   SAID"]
    assert body == [
        "one",
        "  1   a text of some length that has to wrap",
        "a-long-name-of-thirty-letters-",
        "  22  short",
    ]


def test_cells_that_fit_into_no_table_follow_their_headings():
    """Two texts of 24 and their gap need 50 of the 38 characters; an empty cell has no line."""
    rows = [("knob", "a text that needs a long line", "and another one that does"), ("other", "", "brief")]
    head, body = table_lines(rows, ("name", "first", "second"), 40)
    assert head == ["name"]
    assert body == [
        "knob",
        "  first: a text that needs a long line",
        "  second: and another one that does",
        "other",
        "  second: brief",
    ]


@pytest.mark.parametrize("width", [60, 80, 120])
def test_no_line_of_the_shipped_tables_is_longer_than_the_terminal_and_no_word_is_broken(width):
    sensors = [row(described(asset), short=True) for asset in all_assets()]
    knobs = [(name, knob.values, knob.cost, knob.error, knob.why) for name, knob in KNOBS.items()]
    for rows, headings in ((sensors, HEADINGS), (knobs, ("knob", "values", "cost", "error", "why"))):
        head, body = table_lines(rows, headings, width)
        assert max(map(len, [*head, *body])) <= width
        words = {word for line in body for word in line.split()}
        assert {word for row in rows for cell in row for word in cell.split()} <= words


def test_the_sensors_are_one_line_each_at_80_columns():
    rows = [row(described(asset), short=True) for asset in all_assets()]
    assert len(table_lines(rows, HEADINGS, 80)[1]) == len(rows)


def test_the_last_column_of_aligned_rows_wraps_below_itself():
    rows = [("in", "double", "what this input is for and more"), ("output", "a | very | long | union", "brief")]
    assert list(wrapped_last(rows, 45, 8)) == [
        "  in      double    what this input is for",
        "                    and more",
        "  output  a | very | long | union  brief",
    ]


def test_a_long_line_hangs():
    assert hanging("a line that is too long", 12) == ["a line that", "  is too", "  long"]
    assert hanging("", 12) == [""]
