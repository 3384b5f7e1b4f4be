"""Loops that Numba compiles: when, for what, where the code is kept."""

import os
import subprocess
import sys

import numpy as np
import pytest

from sensors.compiled import compiled
from tests.support.places import ROOT


@compiled
def half(value):
    return value / 2


@compiled
def halves(values, out):
    """Half of each."""
    for at in range(len(values)):
        out[at] = half(values[at])


@compiled
def quotient(one, two):
    return one / two


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_a_compiled_loop_calls_another_of_its_file_for_each_type(kind):
    out = np.empty(3, kind)
    halves(np.array([1.0, 3.0, 5.0], kind), out)
    assert out.tolist() == [0.5, 1.5, 2.5]


def test_division_by_zero_is_numpys():
    assert quotient(1.0, 0.0) == np.inf
    assert np.isnan(quotient(0.0, 0.0))


def test_a_compiled_function_keeps_its_name_and_text():
    assert (halves.__name__, halves.__doc__) == ("halves", "Half of each.")


def test_where_no_folder_can_be_written_it_is_compiled_all_the_same(tmp_path):
    code = "from loop import twice\nprint(twice(21))"
    (tmp_path / "loop.py").write_text(
        "from sensors.compiled import compiled\n\n@compiled\ndef twice(value):\n    return 2 * value\n"
    )
    (tmp_path / "__pycache__").write_text("a file, where a folder is needed")
    (tmp_path / "home").write_text("another")
    kept_out = {name: str(tmp_path / "home" / "x") for name in ("HOME", "XDG_CACHE_HOME", "LOCALAPPDATA")}
    env = {**os.environ, **kept_out, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])}
    done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "42\n", "")
