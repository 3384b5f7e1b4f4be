"""Campaign files: every key does what it says, and every mistake has its file, line and column."""

from __future__ import annotations

import csv
import json

import pytest

from graph.base.errors import UserError
from graph.cli.main import main
from graph.files.kinds import kind_of
from wings.campaign.file import read_campaign
from wings.campaign.points import points_of

GOOD = """\
campaign: 1
files: [clock.yaml, more/clock.yaml]
vary:
  seed: 0..1
  speed.value: [1.5, 2]
  wait.duration: uniform(0, 1)
points: points.csv
fixed: {updates: 3, /a/b: true}
metrics:
  ticks: count(topic('clock'))
  one: 1
vary_seed: 4
"""


@pytest.fixture
def place(files, tmp_path, monkeypatch):
    """A folder with the two graph files and the table; the current folder."""
    text = (files / "clock.yaml").read_text().replace("      act: {type: example.Act, inputs: {what: nothing}}\n", "")
    text = text.replace("act.execIn, ", "")
    for end in (": ROS2", ".execIn", ".timeStamp"):
        text = text.replace(f"clock{end}", f"publish{end}")  # `clock.` is the file's section
    (tmp_path / "more").mkdir()
    for name in ("clock.yaml", "more/clock.yaml"):
        (tmp_path / name).write_text(text)
    (tmp_path / "points.csv").write_text("clock.loop_hz,duration\n10,1\n20,\n")
    (tmp_path / "campaign.yaml").write_text(GOOD)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_key_is_read(place):
    asked = read_campaign(place / "campaign.yaml")
    assert asked.files == (f"{place}/clock.yaml", f"{place}/more/clock.yaml")
    assert [(one.name, one.values, one.draw) for one in asked.varied] == [
        ("seed", ("0", "1"), ""),
        ("speed.value", ("1.5", "2"), ""),
        ("wait.duration", (), "uniform(0, 1)"),
    ]
    assert asked.rows == ({"clock.loop_hz": "10", "duration": "1"}, {"clock.loop_hz": "20"})
    assert asked.fixed == {"updates": "3", "/a/b": "true"}
    assert asked.metrics == {"ticks": "count(topic('clock'))", "one": "1"}
    assert asked.seed == 4
    assert [one.name for one in asked.read] == ["campaign.yaml", "points.csv"]
    points = points_of(asked.files, asked.varied, asked.rows, asked.fixed, asked.seed)
    assert len(points) == 2 * 2 * 2 * 2  # files, rows, seeds, speeds
    assert len({one["wait.duration"] for one in points}) == 16


def test_a_campaign_file_and_the_options_that_say_the_same_make_the_same_table(place):
    text = "campaign: 1\nfiles: [clock.yaml]\nvary: {seed: 0..1}\nfixed: {updates: 2, speed.value: 1}\n"
    (place / "campaign.yaml").write_text(text + "metrics: {ticks: count(topic('clock'))}\n")
    assert main(["sweep", "campaign.yaml", "--out", "a"]) == 0
    options = ["--vary", "seed=0..1", "--set", "speed.value=1", "--metric", "ticks=count(topic('clock'))"]
    assert main(["sweep", "clock.yaml", *options, "--updates", "2", "--out", "b"]) == 0
    with (place / "a/campaign.csv").open() as stream:
        assert [(row["seed"], row["ticks"], row["updates"]) for row in csv.DictReader(stream)] == [
            ("0", "2", "2"),
            ("1", "2", "2"),
        ]
    assert (place / "a/campaign.csv").read_bytes() == (place / "b/campaign.csv").read_bytes()


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("campaign: 1", "campaign: 2", "1:11: campaign must be 1, the version of the file format, found number 2"),
        ("files: [clock.yaml, more/clock.yaml]\n", "", '1:1: "files" is missing; add it'),
        ("[clock.yaml, more/clock.yaml]", "[]", "2:8: files is empty; name a graph file"),
        ("[clock.yaml, more/clock.yaml]", "clock.yaml", '2:8: files must be a list, found text "clock.yaml"'),
        ("more/clock.yaml", "moer.yaml", '2:21: files: there is no file "moer.yaml"'),
        ("more/clock.yaml", "../clock.yaml", '2:21: files: "../clock.yaml" is outside the graph file\'s folder'),
        ("vary:", "vray:", '3:1: unknown key "vray"; did you mean "vary"?'),
        ("seed: 0..1", "sed: 0..1", '4:3: vary.sed: "sed" is nothing that a run can set; did you mean "seed"?'),
        ("seed: 0..1", "file: clock.yaml", "4:3: vary.file: graph files are named under files"),
        ("seed: 0..1", "seed: 5..1", "4:9: vary: seed: 5..1 is not a range"),
        ("seed: 0..1", "seed: a,b", "4:9: vary: seed: a is not a whole number"),
        ("seed: 0..1", "lidar.motion: quick", '4:17: vary: lidar.motion: '),
        ("[1.5, 2]", "[]", "5:16: vary.speed.value must be values such as 1,2,5"),
        ("[1.5, 2]", "{a: 1}", "5:16: vary.speed.value must be values such as 1,2,5"),
        ("uniform(0, 1)", "uniform(0)", "6:18: vary: wait.duration: uniform has 1 arguments"),
        ("points: points.csv", "points: 5", "7:9: points must be text, found number 5"),
        ("points: points.csv", "points: pionts.csv", '7:9: points: there is no file "pionts.csv"'),
        ("seed: 0..1", "duration: 1,2", "7:9: points: its column duration is given under vary too"),
        ("updates: 3", "seed: 3", "8:15: fixed: seed is varied too"),
        ("updates: 3", "updates: x", "8:18: fixed: updates: x is not a whole number"),
        ("updates: 3", "updates: null", "8:18: fixed.updates must be values such as 1,2,5"),
        ("count(topic('clock'))", "count(", "10:10: metrics.ticks: this is not an expression"),
        ("one: 1", "run: 1", "11:8: metrics: run: the table has a column of this name; choose another"),
        ("one: 1", "duration: 1", "11:13: metrics: duration: the table has a column of this name"),
        ("one: 1", "one: [1]", "11:8: metrics.one must be an expression, found a list"),
        ("vary_seed: 4", "vary_seed: x", '12:12: vary_seed must be a whole number, found text "x"'),
        ("clock.yaml]", "clock.yaml", "2:8: the [ that opens here is not closed; add a ]"),
        ("vary_seed: 4", "files: []", '12:1: key "files" is repeated'),
    ],
)  # fmt: skip
def test_a_mistake_has_its_place(place, capsys, old, new, problem):
    (place / "campaign.yaml").write_text(GOOD.replace(old, new, 1))
    with pytest.raises(UserError) as caught:
        read_campaign(place / "campaign.yaml")
    assert f"campaign.yaml:{problem}" in str(caught.value)
    assert main(["check", "campaign.yaml"]) == 2
    assert f"campaign.yaml:{problem}" in capsys.readouterr().err


def test_every_mistake_is_told_at_once(place):
    (place / "campaign.yaml").write_text(GOOD.replace("0..1", "1..0").replace("uniform(0, 1)", "uniform(0)"))
    with pytest.raises(UserError) as caught:
        read_campaign(place / "campaign.yaml")
    assert [(one.mark.line, one.mark.column) for one in caught.value.problems] == [(4, 9), (6, 18)]


def test_a_table_of_a_campaign_file_names_no_files(place):
    (place / "points.csv").write_text("file\nclock.yaml\n")
    with pytest.raises(UserError, match=r"7:9: points: its column file is given under files too"):
        read_campaign(place / "campaign.yaml")


def test_files_elsewhere_are_allowed_by_option(place, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    (elsewhere / "c.yaml").write_text(f"campaign: 1\nfiles: [{place}/clock.yaml]\n")
    assert main(["check", str(elsewhere / "c.yaml")]) == 2
    assert main(["check", str(elsewhere / "c.yaml"), "--allow", str(place)]) == 0


def test_check_tells_the_number_of_runs_and_checks_the_graph_files(place, capsys):
    (place / "campaign.yaml").write_text(GOOD.replace("  wait.duration: uniform(0, 1)\n", ""))
    assert main(["check", "campaign.yaml"]) == 0
    assert capsys.readouterr().out == "campaign.yaml: ok, 16 runs\n"
    (place / "campaign.yaml").write_text("campaign: 1\nfiles: [clock.yaml]\nvary: {spede.value: 1}\n")
    assert main(["check", "campaign.yaml"]) == 2
    assert 'spede.value: no node has that name; did you mean "speed"?' in capsys.readouterr().err
    (place / "campaign.yaml").write_text("campaign: 1\nfiles: [clock.yaml]\n")
    (place / "clock.yaml").write_text("tickgraph: 1\ngraphs: 5\n")
    assert main(["check", "campaign.yaml"]) == 2
    assert "clock.yaml:2:9: " in capsys.readouterr().err


def test_a_campaign_file_is_known_by_its_key_and_is_not_run(place, capsys):
    assert kind_of(place / "campaign.yaml") == "campaign"
    assert kind_of(place / "clock.yaml") is None
    assert main(["run", "campaign.yaml"]) == 2
    assert "this is a campaign file, not a graph file; run it by graph sweep" in capsys.readouterr().err


def test_the_schema_takes_what_is_read_and_refuses_mistakes(place, capsys):
    jsonschema = pytest.importorskip("jsonschema")
    from ruamel.yaml import YAML

    assert main(["schema", "--campaign"]) == 0
    schema = json.loads(capsys.readouterr().out)
    validator = jsonschema.Draft202012Validator(schema)
    validator.check_schema(schema)
    good = YAML(typ="safe").load(GOOD)
    assert [one.message for one in validator.iter_errors(good)] == []
    assert validator.is_valid({"campaign": 1, "files": ["a.yaml"], "vary": None})
    for wrong in (
        {"campaign": 2}, {"files": "clock.yaml"}, {"vray": {}}, {"vary": {"seed": {}}}, {"vary": {"seed": None}},
        {"points": 5}, {"fixed": []}, {"metrics": {"a": [1]}}, {"vary_seed": "x"},
    ):  # fmt: skip
        assert not validator.is_valid({**good, **wrong}), wrong
