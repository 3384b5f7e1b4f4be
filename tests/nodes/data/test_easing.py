"""Values between two others."""

import math

import numpy as np
import pytest

from graph import ComputeError
from graph.testing import run_node
from tests.support.typed_values import of


def test_a_step_towards_a_target_covers_the_documented_share_of_the_way():
    """Speed 1 for a tenth of a second, exponent 2: 1 - 0.9^2 = 0.19 of the way."""
    trace = run_node(
        "InterpolateTo", inputs={"current": of("float", 0), "target": of("float", 10), "deltaSeconds": 0.1}
    )
    assert trace.value("result") == pytest.approx(1.9)
    assert trace.node.types["outputs:result"].name == "float"
    vectors = {"current": of("double[3]", [0, 1, 2]), "target": of("double[3]", [10, 11, 12])}
    assert np.allclose(
        run_node("InterpolateTo", inputs={**vectors, "deltaSeconds": 0.1}).value("result"), [1.9, 2.9, 3.9]
    )


def test_a_step_ends_at_the_target_and_never_behind_it():
    inputs = {"current": of("double", 2), "target": of("double", 5), "deltaSeconds": 1.0, "speed": 7.0}
    assert run_node("InterpolateTo", inputs=inputs).value("result") == 5


def test_quaternions_go_along_the_arc():
    """Half of the way to 90 degrees about z, though the target is given with the other sign, is 45 degrees."""
    c, s = math.cos(math.pi / 4), math.sin(math.pi / 4)
    inputs = {
        "current": of("quatd[4]", [0, 0, 0, 1]),
        "target": of("quatd[4]", [0, 0, -s, -c]),
        "deltaSeconds": 0.5,
        "exponent": 1.0,
    }
    result = run_node("InterpolateTo", inputs=inputs).value("result")
    assert np.allclose(result, [0, 0, math.sin(math.pi / 8), math.cos(math.pi / 8)])


@pytest.mark.parametrize(
    ("function", "quarter"),
    [
        ("Linear", 0.25),
        ("EaseIn", 0.0625),
        ("EaseOut", 0.4375),
        ("EaseInOut", 0.125),
        ("SinIn", 1 - math.cos(math.pi / 8)),
        ("SinOut", math.sin(math.pi / 8)),
        ("SinInOut", (1 - math.cos(math.pi / 4)) / 2),
    ],
)
def test_easing_goes_from_start_to_end(function, quarter):
    def at(alpha):
        inputs = {"start": of("double", 10), "end": of("double", 20), "alpha": of("float", alpha), "easeFunc": function}
        return run_node("Ease", inputs=inputs).value("result")

    assert [at(alpha) for alpha in (-1, 0, 1, 2)] == pytest.approx([10, 10, 20, 20])
    assert at(0.25) == pytest.approx(10 + 10 * quarter)


def test_easing_takes_an_array_of_times_and_vectors():
    inputs = {
        "start": of("double[2]", [0, 0]),
        "end": of("double[2]", [4, 8]),
        "alpha": of("float[]", [0, 0.5, 1]),
        "easeFunc": "Linear",
    }
    trace = run_node("Ease", inputs=inputs)
    assert trace.value("result").tolist() == [[0, 0], [2, 4], [4, 8]]
    assert trace.node.types["outputs:result"].name == "double[2][]"


def test_samples_are_looked_up_on_the_line_between_them():
    def at(param):
        return run_node("Interpolator", inputs={"knots": [0, 1, 3], "values": [0, 10, 30], "param": param}).value(
            "value"
        )

    assert [at(-1), at(0.5), at(2), at(9)] == [0, 5, 20, 30]
    with pytest.raises(ComputeError, match="2 knots and 1 values"):
        run_node("Interpolator", inputs={"knots": [0, 1], "values": [0]})
    with pytest.raises(ComputeError, match="knots does not rise"):
        run_node("Interpolator", inputs={"knots": [1, 0], "values": [0, 1]})


@pytest.mark.parametrize(
    ("base", "value", "result", "type_name"),
    [
        (10.0, of("double", 1000), 3, "double"),
        (2.0, of("int[]", [8, 1]), [3, 0], "double[]"),
        (math.e, of("float", 1), 0, "float"),
        (0.5, of("double", 8), -3, "double"),
    ],
)
def test_a_logarithm_is_the_power_of_its_base(base, value, result, type_name):
    trace = run_node("Logarithm", inputs={"base": base, "value": value})
    assert np.allclose(trace.value("result"), result, atol=1e-12)
    assert trace.node.types["outputs:result"].name == type_name


@pytest.mark.parametrize(("base", "value"), [(1.0, 5), (0.0, 5), (10.0, 0), (10.0, -1)])
def test_what_has_no_logarithm_fails(base, value):
    with pytest.raises(ComputeError, match=r"must be above 0 and not 1|has no logarithm"):
        run_node("Logarithm", inputs={"base": base, "value": of("double", value)})


def test_a_power_below_zero_fails():
    ends = {"start": of("double", 0), "end": of("double", 1)}
    with pytest.raises(ComputeError, match="input blendExponent is -1; give it 0 or more"):
        run_node("Ease", inputs={**ends, "alpha": of("float", 0), "blendExponent": -1})
    with pytest.raises(ComputeError, match=r"input exponent is -1.0; give it 0 or more"):
        run_node("InterpolateTo", inputs={"current": of("double", 0), "target": of("double", 1), "exponent": -1.0})


def test_a_quaternion_meets_numbers_and_arrays():
    inputs = {"current": of("quatd[4]", [0, 0, 0, 1]), "deltaSeconds": 1.0, "speed": 1.0}
    turned = run_node("InterpolateTo", inputs={**inputs, "target": of("quatd[4][]", [[0, 0, 1, 0], [0, 1, 0, 0]])})
    assert turned.values("result")[0] == pytest.approx(np.array([[0, 0, 1, 0], [0, 1, 0, 0]]))
    turned = run_node("InterpolateTo", inputs={**inputs, "target": of("double[]", [0.5, 1.0])})
    assert turned.values("result")[0] == pytest.approx(np.full((2, 4), 0.5))
