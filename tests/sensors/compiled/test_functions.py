"""Loops that Numba compiles: when, for what, where the code is kept."""

import os
import subprocess
import sys
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import pytest

from sensors.compiled import compiled, inlined
from tests.support.places import ROOT

SAID = "compiling the sensors' loops, once on this machine; the first frames take up to a minute"


@inlined
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
def test_a_compiled_loop_takes_in_what_is_inlined_for_each_type(kind):
    out = np.empty(3, kind)
    halves(np.array([1.0, 3.0, 5.0], kind), out)
    assert out.tolist() == [0.5, 1.5, 2.5]


def test_what_is_inlined_runs_as_python_by_itself():
    assert half(Fraction(1, 2)) == Fraction(1, 4)


@compiled(makes_arrays=True)
def doubled(values):
    out = np.empty_like(values)
    for at in range(len(values)):
        out[at] = 2 * values[at]
    return out


def test_a_loop_may_make_arrays_if_it_says_so():
    assert doubled(np.array([1.0, 2.0])).tolist() == [2.0, 4.0]


def test_division_by_zero_is_numpys():
    assert quotient(1.0, 0.0) == np.inf
    assert np.isnan(quotient(0.0, 0.0))


class Pair(NamedTuple):
    first: float
    second: float


@compiled
def second(pair):
    return pair.second


def test_a_function_may_have_the_name_of_an_attribute_that_it_reads():
    assert second(Pair(1.0, 2.0)) == 2.0


def test_a_compiled_function_keeps_its_name_and_text():
    assert (halves.__name__, halves.__doc__) == ("halves", "Half of each.")


def run_with_a_loop(tmp_path, before, env, imports="", value="2 * value"):
    """Runs a process with a compiled function of its own; `before` is code that it runs first."""
    loop = tmp_path / "loop.py"
    if not loop.exists():
        start = f"from sensors.compiled import compiled\n{imports}\n@compiled\ndef twice(value):\n"
        loop.write_text(f"{start}    return {value}\n")
    code = f"{before}\nfrom loop import twice\nprint(twice(21))"
    env = {**os.environ, **env, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])}
    return subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=False)


def test_code_is_made_again_when_a_file_of_what_is_inlined_changes(tmp_path):
    before = "import sys; sys.dont_write_bytecode = True"
    part = "from sensors.compiled import inlined\n\n@inlined\ndef times(value):\n    return {} * value\n"
    said = []
    for factor in (2, 30):
        (tmp_path / "part.py").write_text(part.format(factor))
        said.append(run_with_a_loop(tmp_path, before, {}, "from part import times\n", "times(value)").stdout)
    assert said == ["42\n", "630\n"]


def test_code_is_made_again_when_the_order_of_a_tuples_fields_changes(tmp_path):
    """Compiled code reads fields by their number."""
    before = "import sys; sys.dont_write_bytecode = True"
    part = "from typing import NamedTuple\n\nclass Part(NamedTuple):\n    {}: float\n    {}: float\n{}"
    said = []
    for first, second, rest in (("low", "high", ""), ("high", "low", "\n")):
        (tmp_path / "part.py").write_text(part.format(first, second, rest))
        loop = "from part import Part\n\n@compiled\ndef low(part):\n    return part.low\n"
        more = f"{before}\nfrom loop import low, Part\nprint(low(Part(low=1.0, high=2.0)))"
        said.append(run_with_a_loop(tmp_path, more, {}, loop).stdout)
    assert said == ["1.0\n42\n", "1.0\n42\n"]


def kept_in(folder):
    return sorted(path.name.partition("-")[0] for path in (folder / "kernels").glob("*.bin"))


def test_code_is_kept_once_for_equal_sources_in_two_folders(tmp_path):
    """Two clones of a package: the second finds what the first compiled."""
    said = []
    for clone in ("one", "two"):
        (tmp_path / clone).mkdir()
        more = "import loop; loop.twice(1); print(len(loop.twice.kept.misses))"
        said.append(run_with_a_loop(tmp_path / clone, more, {"TICKGRAPH_CACHE": str(tmp_path / "cache")}).stdout)
    assert said == ["1\n42\n", "0\n42\n"]
    assert kept_in(tmp_path / "cache") == ["loop.twice"]


def test_code_that_comes_with_the_package_is_used_first_and_nothing_is_kept_twice(tmp_path):
    more = "import loop; loop.twice(1); print(len(loop.twice.kept.misses))"
    run_with_a_loop(tmp_path, more, {"TICKGRAPH_CACHE": str(tmp_path / "cache")})
    folder = str(tmp_path / "cache" / "kernels")
    shipped = f"from pathlib import Path\nfrom sensors.compiled import kept\nkept.SHIPPED = Path({folder!r})\n"
    done = run_with_a_loop(tmp_path, shipped + more, {"TICKGRAPH_CACHE": str(tmp_path / "other")})
    assert done.stdout == "0\n42\n"
    assert kept_in(tmp_path / "other") == []


def test_damaged_code_is_compiled_again(tmp_path):
    env = {"TICKGRAPH_CACHE": str(tmp_path / "cache")}
    run_with_a_loop(tmp_path, "", env)
    (file,) = (tmp_path / "cache" / "kernels").glob("*.bin")
    whole = file.read_bytes()
    for damaged in (b"", whole[:100], whole[:-1] + b"?"):
        file.write_bytes(damaged)
        assert run_with_a_loop(tmp_path, "", env).stdout == "42\n"
        assert file.read_bytes() == whole


@pytest.mark.skipif(sys.platform == "win32", reason="has no such modes")
def test_code_from_a_folder_that_others_may_write_into_is_not_run(tmp_path):
    """It is machine code: here, a file with the right name and digest would be run."""
    folder = tmp_path / "cache" / "kernels"
    folder.mkdir(parents=True)
    folder.chmod(0o777)
    more = "import loop; loop.twice(1); print(len(loop.twice.kept.misses))"
    done = run_with_a_loop(tmp_path, more, {"TICKGRAPH_CACHE": str(tmp_path / "cache")})
    assert (done.returncode, done.stdout) == (0, "1\n42\n")
    assert list(folder.iterdir()) == []


def test_the_folder_is_the_users_alone(tmp_path):
    run_with_a_loop(tmp_path, "", {"TICKGRAPH_CACHE": str(tmp_path / "cache")})
    assert (tmp_path / "cache" / "kernels").stat().st_mode & 0o777 == 0o700


def test_where_no_folder_can_be_written_it_is_compiled_all_the_same(tmp_path):
    (tmp_path / "home").write_text("a file, where a folder is needed")
    homes = {name: str(tmp_path / "home" / "x") for name in ("HOME", "XDG_CACHE_HOME", "LOCALAPPDATA")}
    done = run_with_a_loop(tmp_path, "", {**homes, "TICKGRAPH_CACHE": ""})
    assert (done.returncode, done.stdout) == (0, "42\n")
    assert done.stderr.splitlines() == [SAID]


@pytest.mark.skipif(sys.platform == "win32", reason="has no limits of file sizes")
def test_where_the_code_cannot_be_kept_it_is_compiled_all_the_same(tmp_path):
    no_large_files = "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
    no_large_files += "resource.setrlimit(resource.RLIMIT_FSIZE, (200, 200))"
    done = run_with_a_loop(tmp_path, no_large_files, {"PYTHONDONTWRITEBYTECODE": "1", "TICKGRAPH_CACHE": str(tmp_path)})
    assert (done.returncode, done.stdout) == (0, "42\n")
    assert done.stderr.splitlines() == [SAID]
    assert kept_in(tmp_path) == [] == list((tmp_path / "kernels").glob("*.part"))


def test_without_numba_a_line_says_so(tmp_path):
    done = run_with_a_loop(tmp_path, "import sys; sys.modules['numba'] = None", {})
    assert done.returncode == 1
    assert "Numba does not import" in done.stderr.splitlines()[-1]
    assert "Run `graph doctor`" in done.stderr.splitlines()[-1]
