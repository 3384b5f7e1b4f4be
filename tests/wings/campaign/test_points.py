"""The points of a campaign: combinations, ranges, drawn values, tables, and the command line of each."""

from __future__ import annotations

import pytest

from graph.base.errors import UserError
from graph.base.limits import OverLimit
from graph.session.varied import Varied, drawn_at, read_varied
from wings.campaign.points import arguments_of, check_key, check_value, points_of, read_table


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("1,2,5", ("1", "2", "5")),
        ("0..3", ("0", "1", "2", "3")),
        ("0..10..5,7", ("0", "5", "10", "7")),
        ("[0, 0, 1],[0, 0, 2]", ("[0, 0, 1]", "[0, 0, 2]")),
        ("1,1", ("1",)),
        ("-2..-1", ("-2", "-1")),
    ],
)
def test_values_of_a_key(text, values):
    assert read_varied("x", text).values == values


@pytest.mark.parametrize("text", ["", ",", "5..1", "0..5..0", "0..999999999", "uniform(0, 1)*0", "uniform(1)*3"])
def test_values_that_cannot_be_are_refused(text):
    with pytest.raises(ValueError, match=r"."):
        read_varied("x", text)


def test_drawn_values_depend_on_seed_key_and_place_alone():
    twenty = read_varied("x", "uniform(0, 1)*20", 4).values
    assert len(set(twenty)) == 20
    assert read_varied("x", "uniform(0, 1)*5", 4).values == twenty[:5]
    assert read_varied("y", "uniform(0, 1)*20", 4).values != twenty
    assert read_varied("x", "uniform(0, 1)*20", 5).values != twenty


def test_every_combination_is_a_point_and_the_last_key_is_the_fastest():
    varied = [Varied("a", ("1", "2")), Varied("b", ("x", "y"))]
    assert [(one["file"], one["a"], one["b"]) for one in points_of(["f", "g"], varied, [], {}, 0)] == [
        (file, a, b) for file in "fg" for a in "12" for b in "xy"
    ]


def test_a_distribution_without_a_number_draws_for_each_point_and_others_do_not_shift_it():
    each = Varied("x", (), "uniform(0, 1)")
    alone = points_of(["f"], [Varied("seed", ("0", "1", "2")), each], [], {}, 7)
    more = points_of(["f"], [Varied("seed", ("0", "1", "2")), Varied("y", (), "normal(0, 1)"), each], [], {}, 7)
    assert [one["x"] for one in alone] == [drawn_at(each, 7, number) for number in range(3)]
    assert [one["x"] for one in more] == [one["x"] for one in alone]


def test_rows_of_a_table_are_points_and_an_empty_cell_sets_nothing(tmp_path):
    table = tmp_path / "p.csv"
    table.write_text('seed,/World/Box.translate\n1,"[0, 0, 1]"\n2,\n')
    rows = read_table(table)
    assert rows == [{"seed": "1", "/World/Box.translate": "[0, 0, 1]"}, {"seed": "2"}]
    points = points_of(["f"], [Varied("updates", ("3", "4"))], rows, {"seed": "9", "duration": "1"}, 0)
    assert [(one["seed"], one["updates"]) for one in points] == [("1", "3"), ("1", "4"), ("2", "3"), ("2", "4")]
    assert all(one["duration"] == "1" for one in points)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("seeed\n1\n", ':1:1: column 1: "seeed" is nothing that a run can set; did you mean "seed"?'),
        ("seed,seed\n1,2\n", ':1:2: the key "seed" is there twice'),
        ("seed\n1,2\n", ":2:1: 2 cells, but there are 1 keys in the first line"),
        ("seed\n", ":1:1: there is no point"),
    ],
)
def test_mistakes_of_a_table_have_their_place(tmp_path, text, problem):
    (tmp_path / "p.csv").write_text(text)
    with pytest.raises(UserError) as caught:
        read_table(tmp_path / "p.csv")
    assert str(caught.value).startswith(f"{tmp_path / 'p.csv'}{problem}")


def test_too_many_points_are_refused():
    wide = [Varied(name, tuple(map(str, range(1000)))) for name in ("a", "b")]
    with pytest.raises(OverLimit, match=r"a campaign of 1,000,000 runs; the limit is 100,000"):
        points_of(["f"], wide, [], {}, 0)


def test_a_point_is_a_command_line():
    point = {
        "file": "yard.yaml",
        "seed": "17",
        "lidar.motion": "update",
        "/World/Box.mass+/World/Ball.mass": "2",
        "wait.duration": "5",
        "/rtx/x": "true",
        "--/exts/isaacsim.core/y": "1",
        "clock.parity": "documented",
    }
    assert arguments_of(point, ["--updates", "3"]) == [
        *("run", "yard.yaml", "--updates", "3", "--seed", "17", "--fidelity", "lidar.motion=update"),
        *("--set", "/World/Box.mass=2", "--set", "/World/Ball.mass=2", "--set", "wait.duration=5"),
        *("--/rtx/x=true", "--/exts/isaacsim.core/y=1", "--set", "clock.parity=documented"),
    ]


def test_a_key_that_no_run_can_set_is_refused_with_the_nearest():
    with pytest.raises(ValueError, match=r'did you mean "lidar\.motion"'):
        check_key("lidar_motion")


def test_rows_that_name_their_file_are_points_of_it_alone(tmp_path):
    (tmp_path / "p.csv").write_text("file,seed\na.yaml,1\nb.yaml,\n")
    rows = read_table(tmp_path / "p.csv")
    assert points_of(["a.yaml", "b.yaml"], [Varied("x", ("1", "2"))], rows, {}, 0) == [
        *({"file": "a.yaml", "seed": "1", "x": x} for x in "12"),
        *({"file": "b.yaml", "x": x} for x in "12"),
    ]
    (tmp_path / "p.csv").write_text("file,seed\na.yaml,1\n,2\n")
    with pytest.raises(UserError, match=r"p\.csv:3:1: the cell of file is empty"):
        read_table(tmp_path / "p.csv")


@pytest.mark.parametrize(("key", "value"), [("seed", "x"), ("updates", "1.5"), ("lidar.motion", "quick")])
def test_values_that_a_key_cannot_have_are_refused(key, value):
    with pytest.raises(ValueError, match=value):
        check_value(key, value)
    check_value("/World/Box.mass", value)
