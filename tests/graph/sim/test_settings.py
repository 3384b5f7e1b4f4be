"""The settings tree: paths, types, subscriptions."""

from __future__ import annotations

from fractions import Fraction

import pytest

from graph.base.errors import Mark, UserError
from graph.sim import settings as keys
from graph.sim.settings import Settings, from_mapping, parse_option, suggestion


@pytest.mark.parametrize(
    ("text", "path", "value"),
    [
        ("--/app/player/playSimulations=false", "/app/player/playSimulations", False),
        ("--/rtx/hydra/supportMultiTickRate=TRUE", "/rtx/hydra/supportMultiTickRate", True),
        ("--/a/b=3", "/a/b", 3),
        ("/a/b=-2.5", "/a/b", -2.5),
        ("--/a/b=1e3", "/a/b", 1000.0),
        ("--/a/b='3'", "/a/b", "3"),
        ('--/a/b="x=y"', "/a/b", "x=y"),
        ("--/a/b=60000/1001", "/a/b", "60000/1001"),
        ("--/a/b=", "/a/b", ""),
    ],
)
def test_options_are_typed(text, path, value):
    parsed = parse_option(text)
    assert parsed == (path, value)
    assert type(parsed[1]) is type(value)


def test_an_option_without_a_value_says_how_to_write_it():
    with pytest.raises(UserError, match="--/path/to/setting=value"):
        parse_option("--/a/b")


@pytest.mark.parametrize("path", ["", "/", "/a//b", "/a/ b"])
def test_what_is_not_a_path(path):
    with pytest.raises(UserError, match="not a path"):
        Settings().set(path, 1)


def test_defaults_of_the_documented_profile():
    settings = Settings()
    assert settings.get("/app/runLoops/main/rateLimitFrequency") == 60
    assert settings.get("/persistent/simulation/minFrameRate") == 0
    assert settings.get("/app/player/useFixedTimeStepping") is False
    assert settings.get("/rtx/hydra/supportMultiTickRate") is True


def test_unknown_settings_are_kept_as_they_are():
    settings = Settings({"/exts/my.tool/size": [1, 2]})
    assert settings.get("/exts/my.tool/size") == [1, 2]
    assert settings.get("exts/my.tool/size/") == [1, 2]
    assert settings.get("/exts/nothing", "fallback") == "fallback"


def test_a_branch_reads_as_a_tree_and_can_be_set_as_one():
    settings = Settings({"/exts/tool": {"a": 1, "b": {"c": 2}}})
    assert settings.get("/exts/tool/b/c") == 2
    assert settings.get("/exts/tool") == {"a": 1, "b": {"c": 2}}


def test_a_setting_is_a_leaf_or_a_branch():
    settings = Settings({"/exts/tool/a": 1})
    with pytest.raises(UserError, match="already holds a value"):
        settings.set("/exts/tool/a/b", 2)
    with pytest.raises(UserError, match="settings below it"):
        settings.set("/exts/tool", 2)


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (keys.PLAY_SIMULATIONS, "maybe", "neither true nor false"),
        (keys.RATE_LIMIT_FREQUENCY, 0, "greater than 0"),
        (keys.RATE_LIMIT_FREQUENCY, float("nan"), "not a number"),
        (keys.RATE_LIMIT_FREQUENCY, "fast", "60000/1001"),
        (keys.MIN_FRAME_RATE, -1, "0 or more"),
        (keys.RAY_THREADS, 1.5, "whole number"),
        (keys.TICKS_PER_FRAME, "many", "not a number"),
    ],
)
def test_known_settings_keep_their_type(path, value, message):
    with pytest.raises(UserError, match=message):
        Settings().set(path, value)


def test_known_switches_take_the_usual_words():
    settings = Settings({keys.MULTI_TICK: 0, keys.PLAY_SIMULATIONS: "no"})
    assert settings.get(keys.MULTI_TICK) is False
    assert settings.get(keys.PLAY_SIMULATIONS) is False


@pytest.mark.parametrize("path", keys.SWITCHES)
def test_switches_without_a_default_take_the_usual_words_too(path):
    """A text such as "off" is not empty, so that it would count as on."""
    assert Settings().get(path) is None
    assert Settings({path: "off"}).get(path) is False
    assert Settings({path: 1}).get(path) is True
    with pytest.raises(UserError, match="'7x' is neither true nor false"):
        Settings().set(path, "7x")


def test_rates_are_exact():
    settings = Settings({keys.RATE_LIMIT_FREQUENCY: "60000/1001", keys.TARGET_FRAMERATE: 29.97})
    assert settings.rate(keys.RATE_LIMIT_FREQUENCY) == Fraction(60000, 1001)
    assert settings.rate(keys.TARGET_FRAMERATE) == Fraction(2997, 100)


def test_all_bad_settings_are_reported_with_their_marks():
    marks = {path: Mark("g.yaml", line, 3) for line, path in enumerate((keys.MIN_FRAME_RATE, keys.MULTI_TICK), 7)}
    with pytest.raises(UserError) as caught:
        from_mapping({keys.MIN_FRAME_RATE: "x", keys.MULTI_TICK: "y", "/fine": 1}, marks.get)
    assert [str(problem.mark) for problem in caught.value.problems] == ["g.yaml:7:3", "g.yaml:8:3"]


def test_subscribers_hear_changes_only():
    settings, heard = Settings(), []
    end = settings.subscribe(keys.MIN_FRAME_RATE, heard.append)
    settings.set(keys.MIN_FRAME_RATE, 0)
    settings.set(keys.MIN_FRAME_RATE, 30)
    end()
    end()
    settings.set(keys.MIN_FRAME_RATE, 15)
    assert heard == [30]


def test_a_default_yields_to_what_the_user_set():
    settings = Settings({keys.RATE_LIMIT_FREQUENCY: 30})
    settings.set_default(keys.RATE_LIMIT_FREQUENCY, 120)
    settings.set_default(keys.TARGET_FRAMERATE, 120)
    assert settings.get(keys.RATE_LIMIT_FREQUENCY) == 30
    assert settings.get(keys.TARGET_FRAMERATE) == 120
    assert settings.is_authored(keys.RATE_LIMIT_FREQUENCY)
    assert not settings.is_authored(keys.TARGET_FRAMERATE)


def test_a_misspelt_known_setting_is_recognised():
    assert suggestion("/app/player/playSimulation") == "/app/player/playSimulations"
    assert suggestion("/app/player/playSimulations") is None
    assert suggestion("/exts/my.tool/size") is None
    assert suggestion("/app/player/useFixedStepping") == "/app/player/useFixedTimeStepping"  # far, but beside it
    assert suggestion("/app/runLoops/present/rateLimitFrequency") is None  # another loop's, of Kit
    assert suggestion("/tickgraph/threads") == "/tickgraph/rayThreads"
    assert suggestion("/rtx-transient/stableIds/enable") == "/rtx-transient/stableIds/enabled"


def test_misspelt_settings_are_reported_also_where_they_are_set_later():
    settings = Settings({"/app/player/playSimulation": False, "/exts/my.tool/size": 1})
    told = []
    settings.on_misspelt(lambda path, known: told.append((path, known)))
    assert told == [("/app/player/playSimulation", "/app/player/playSimulations")]
    for _ in range(2):
        settings.set("/app/player/useFastmode", True)
    assert told[1:] == [("/app/player/useFastmode", "/app/player/useFastMode")]
