"""`float` and `half` attributes hold float32 and float16; expected numbers are roundings worked out by hand."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graph.testing import run_graph, run_node
from graph.values.precision import half, single

FLOAT_TENTH = 13421773 / 2**27
"""0.1 in float32: 24 bits, 0x3dcccccd."""


@given(st.floats(width=32))
def test_a_float32_stays_as_it_is(value):
    assert struct.pack("d", single(value)) == struct.pack("d", value) or math.isnan(value)


@given(st.floats(allow_nan=False))
def test_rounding_is_numpys(value):
    with np.errstate(all="ignore"):
        assert (single(value), half(value)) == (float(np.float32(value)), float(np.float16(value)))


def test_a_sum_of_floats_is_a_float():
    """16777216 = 2^24: the next float32 is 2 further, so 0.1 is lost."""
    trace = run_node("Add", inputs={"a": {"type": "float", "value": 0.1}, "b": {"type": "float", "value": 16777216}})
    assert trace.value("sum") == 16777216.0


def test_a_sum_of_halves_is_a_half():
    """2048 = 2^11: the next float16 is 2 further; 65504 is the largest, so twice that is infinite."""
    trace = run_node("Add", inputs={"a": {"type": "half", "value": 0.1}, "b": {"type": "half", "value": 2048}})
    assert trace.value("sum") == 2048.0
    trace = run_node("Add", inputs={"a": {"type": "half", "value": 65504}, "b": {"type": "half", "value": 65504}})
    assert trace.value("sum") == math.inf


@pytest.mark.parametrize("evaluator", ["push", "dirty_push"])
def test_a_double_that_passes_a_float_keeps_only_its_precision(evaluator, tmp_path):
    """0.1 through a float into a double array is 0.1's float32; 2^24 + 1 through a float into an int array is 2^24."""
    path = tmp_path / "floats.yaml"
    path.write_text(
        f"""
tickgraph: 1
graphs:
  /World/G:
    evaluator: {evaluator}
    nodes:
      tenth: {{type: ConstantFloat, inputs: {{value: 0.1}}}}
      large: {{type: ConstantDouble, inputs: {{value: 16777217}}}}
      narrow: ToFloat
      doubles: {{type: ConstructArray, inputs: {{arrayType: "double[]"}}}}
      wholes: {{type: ConstructArray, inputs: {{arrayType: "int[]"}}}}
    connections:
      - tenth.value -> doubles.input0
      - large.value -> narrow.value
      - narrow.converted -> wholes.input0
"""
    )
    trace = run_graph(path, updates=1)
    assert trace.value("doubles.array").tolist() == [FLOAT_TENTH]
    assert trace.value("wholes.array").tolist() == [16777216]
