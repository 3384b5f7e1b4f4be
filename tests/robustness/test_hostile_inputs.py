"""Inputs of nodes that fuzzing found: no hang, no memory beyond the limit, no value that its type cannot hold."""

import numpy as np
import pytest

from graph.base.errors import RunError
from graph.base.limits import raised
from graph.testing import run_node
from tests.support.without_wing import needs_wing


@pytest.mark.parametrize(
    ("values", "decimals", "rounded"),
    [
        ([1.5, 2.0], 2**31 - 1, [1.5, 2.0]),
        ([1.5, 1e300], -(2**31), [0.0, 0.0]),
        ([1e300, 2.5], 20, [1e300, 2.5]),  # 10^320 is more than a double holds
        ([np.inf, 123.0], -2, [np.inf, 100.0]),
    ],
)
def test_any_number_of_decimals_rounds_as_numbers_of_any_size_do(values, decimals, rounded):
    inputs = {"input": values, "decimals": decimals}
    assert run_node("omni.graph.nodes.Round", inputs=inputs).value("output").tolist() == rounded


@needs_wing("robots")
def test_a_path_of_more_samples_than_the_memory_holds_is_refused():
    """95 s at 1e-9 s, and two more samples: (95e9 + 2) x 128 bytes."""
    inputs = {"step": 1e-9, "targetPosition": [5.0, 0.0, 0.0]}
    with pytest.raises(RunError, match=r"would take 12,160,000,000,256 bytes.*--limit graph\.bytes=N"):
        run_node("QuinticPathPlanner", inputs=inputs, pulses={"execIn": [0]})


@needs_wing("replicator")
@pytest.mark.parametrize("name", ["IsaacGenerateRGBA", "IsaacGenerate32FC1"])
def test_an_image_beyond_the_memory_is_refused(name):
    """100 x 100 pixels of 4 bytes are 40,000."""
    size = {"width": 100, "height": 100}
    with raised({"graph.bytes": 40_000}):
        assert len(run_node(name, inputs=size).value("data")) == 40_000
    with raised({"graph.bytes": 39_999}), pytest.raises(RunError, match=r"--limit graph\.bytes=N"):
        run_node(name, inputs=size)


def test_seconds_that_an_int_cannot_hold_are_refused():
    with pytest.raises(RunError, match=r"time is 2147483648.0 s; output seconds holds less than 2\^31 s"):
        run_node("IsaacTimeSplitter", inputs={"time": 2.0**31})


def test_a_loop_that_leaves_the_range_of_int_is_refused():
    """256 is the first pass; the second value, 2147483903, is above 2147483647."""
    inputs = {"start": 256, "stop": 1000, "step": 2**31 - 1}
    with pytest.raises(RunError, match="lead to 2147483903, which an int cannot hold"):
        run_node("omni.graph.action.ForLoop", inputs=inputs, pulses={"execIn": [0]})
