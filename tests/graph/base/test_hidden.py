"""Scripts with a `graph.py`, `nodes/` or `sensors/` of their own beside them."""

import subprocess
import sys

import pytest

from tests.support.places import ROOT


@pytest.fixture
def last_line(tmp_path):
    """Runs a script in a folder that holds these other files; gives the last line of stderr."""

    def run(script, *files):
        for file in files:
            (tmp_path / file).parent.mkdir(exist_ok=True)
            (tmp_path / file).write_text("")
        (tmp_path / "script.py").write_text(f"import sys; sys.path.append({str(ROOT)!r})\n{script}\n")
        done = subprocess.run(
            [sys.executable, str(tmp_path / "script.py")], capture_output=True, text=True, check=False
        )
        return (done.stderr.splitlines() or [""])[-1]

    return run


@pytest.mark.parametrize("file", ["sensors.py", "sensors/__init__.py", "nodes.py", "nodes/__init__.py"])
@pytest.mark.parametrize("script", ["from graph import load_graph", "from graph.sim import App; import sensors"])
def test_a_module_that_hides_a_package_is_named(file, script, last_line, tmp_path):
    name = file.partition("/")[0].removesuffix(".py")
    expected = f'{tmp_path}/{file} hides the package "{name}" of TickGraph; rename it'
    assert last_line(script, file).endswith(f"HiddenPackageError: {expected}")


def test_a_module_that_hides_the_engine_is_named_by_the_sensors(last_line, tmp_path):
    expected = f'ImportError: {tmp_path}/graph.py hides the package "graph" of TickGraph; rename it'
    assert last_line("import sensors", "graph.py") == expected


def test_a_folder_without_init_hides_nothing(last_line):
    assert last_line("from graph import load_graph\nfrom sensors import Lidar", "sensors/data.txt", "nodes/a.py") == ""


def test_the_command_says_it_in_one_line(tmp_path):
    (tmp_path / "nodes.py").write_text("")
    program = f"import sys; sys.path[:0] = [{str(tmp_path)!r}, {str(ROOT)!r}]; from graph.cli.main import main; main()"
    done = subprocess.run([sys.executable, "-c", program, "nodes"], capture_output=True, text=True, check=False)
    assert done.stderr == f'graph: {tmp_path}/nodes.py hides the package "nodes" of TickGraph; rename it\n'
