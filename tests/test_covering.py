"""`make test-of FILE=...`: the tests of a file."""

import coverage
import pytest

from tests.support.covering import covering, main, ran_by
from tests.support.places import ROOT

LATENT = ROOT / "nodes" / "action" / "latent.py"


def test_without_coverage_a_file_has_the_tests_that_import_it_or_have_its_name(tmp_path):
    assert "tests/nodes/action/test_latent.py" in covering(LATENT, tmp_path / "none")
    assert covering(ROOT / "graph" / "base" / "exact.py", tmp_path / "none") != []


def test_a_file_that_no_test_imports_has_those_of_the_modules_that_import_it(tmp_path):
    """`causes` is used by the compiled graph alone."""
    found = covering(ROOT / "graph" / "evaluate" / "causes.py", tmp_path / "none")
    assert "tests/graph/evaluate/test_execution.py" in found


def test_with_coverage_a_file_has_the_ran_by_its_lines(tmp_path):
    data = coverage.CoverageData(str(tmp_path / "coverage"))
    data.set_context("tests/test_run.py::test_one[a-b]|run")
    data.add_lines({str(LATENT): [10, 11]})
    data.set_context("tests/test_run.py::test_other|run")
    data.add_lines({str(ROOT / "nodes" / "action" / "flow.py"): [3]})
    data.set_context("tests/test_gone.py::test_it|run")
    data.add_lines({str(LATENT): [12]})
    data.write()
    assert ran_by(LATENT, tmp_path / "coverage") == ["tests/test_run.py::test_one"]


@pytest.mark.parametrize("file", ["nowhere.py", "/etc/passwd"])
def test_a_file_that_is_not_of_the_project_is_refused(file, capsys):
    assert main([file]) == 2
    assert "give files of this project" in capsys.readouterr().out
