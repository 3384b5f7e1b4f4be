"""Settings that agree in every knob that a run reads are that run, and it is made once."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from pathlib import Path

from graph.sim.fidelity import Fidelity
from wings.trade.errors import Horizon
from wings.trade.outcome import Outcome, Row
from wings.trade.rows import measure_rows
from wings.trade.study import Scene, Study
from wings.trade.trial import CLOCKS, Measured

MOTIONS, BINS = ("frozen", "update", "continuous"), (4, 8, 16)
PRESENT = Fidelity(physics_hz=Fraction(60), loop_hz=Fraction(60))


def reads(setting):
    """The bins of a turn are read by a lidar that moves within it."""
    return CLOCKS | {"lidar.motion"} | ({"lidar.bins"} if setting["lidar.motion"] == "continuous" else set())


class Runs:
    """A pool whose runs read what `reads` says and err by the number of the run."""

    def __init__(self):
        self.made = []

    def results(self, jobs, *, at_once):
        for number, job in enumerate(jobs):
            self.made.append(tuple(job.setting.values()))
            yield number, (Measured(read=reads(job.setting)), {"lidar.range_p99": float(len(self.made))})


def measured(known):
    settings = tuple({"lidar.motion": motion, "lidar.bins": bins} for motion, bins in product(MOTIONS, BINS))
    varied = {"lidar.motion": MOTIONS, "lidar.bins": BINS}
    study = Study(Scene(Path("a.yaml")), varied, settings, settings[-1], {}, repeat=3)
    outcome = Outcome(study, [Row(one) for one in settings], Horizon(1.0), {}, ())
    pool, counted = Runs(), []
    measure_rows(outcome, known, PRESENT, pool, Path("reference"), counted.append)
    assert sum(counted) == 9 + 3 * sum(len(row.also) for row in outcome.rows)  # what is merged is not timed either
    return outcome, pool.made


def test_of_nine_settings_five_are_runs_and_the_reference_has_run_already():
    """frozen and update read no bins: one run each for three settings; continuous has three, one is the reference."""
    reference = {"lidar.motion": "continuous", "lidar.bins": 16}
    known = Row(reference)
    known.take(Measured(read=reads(reference)), {"lidar.range_p99": 0.0})
    outcome, made = measured([known])
    assert made == [("frozen", 4), ("update", 4), ("continuous", 4), ("continuous", 8)]
    told = [([tuple(one.values()) for one in row.settings], row.errors["lidar.range_p99"]) for row in outcome.rows]
    assert told == [
        ([("frozen", 4), ("frozen", 8), ("frozen", 16)], 1.0),
        ([("update", 4), ("update", 8), ("update", 16)], 2.0),
        ([("continuous", 4)], 3.0),
        ([("continuous", 8)], 4.0),
        ([("continuous", 16)], 0.0),
    ]


def test_a_reference_that_is_finer_in_a_knob_that_is_not_varied_is_another_run_only_if_that_is_read():
    """--reference lidar.subrays=4, which the file has as 1: frozen/16 is the reference unless subrays are read."""
    reference = {"lidar.motion": "frozen", "lidar.bins": 16, "lidar.subrays": 4}
    for read, runs in ((CLOCKS | {"lidar.motion"}, 4), (CLOCKS | {"lidar.motion", "lidar.subrays"}, 5)):
        known = Row(reference)
        known.take(Measured(read=read), {"lidar.range_p99": 0.0})
        assert len(measured([known])[1]) == runs
