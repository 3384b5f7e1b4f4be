"""Time spent on compiling is counted once, however compilations nest, and said in one line."""

import time

from sensors.compiled.compile_time import CompileTime


def test_nested_compilations_count_once_and_are_said_once(monkeypatch, capsys):
    """From 10 to 14 s with one inside, then from 20 to 21 s: 4 + 1 seconds of two outer compilations."""
    clock = iter([10.0, 14.0, 20.0, 21.0])
    monkeypatch.setattr(time, "perf_counter", lambda: next(clock))
    counted = CompileTime()
    for step in (counted.start, counted.start, counted.end, counted.end, counted.start, counted.end):
        step()
    assert (counted.seconds, counted.loops) == (5.0, 2)
    [line] = capsys.readouterr().err.splitlines()
    assert line.startswith("compiling the sensors' loops")
