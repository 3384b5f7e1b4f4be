"""The pytest plugin: what it collects, what it gives, and that it leaves other projects alone."""

import os
import shutil
import subprocess
import sys
from types import SimpleNamespace

import pytest

from tests.support.countdown_tests import PASSES
from tests.support.places import ROOT

FAILS = """\
  it finishes late:
    expect: {fired: {finished: [3]}}
"""
TESTS = PASSES + FAILS


@pytest.fixture
def project(tmp_path):
    """Another project's folder with the plugin installed beside it; running pytest there gives code and output."""
    site, folder = tmp_path / "site", tmp_path / "project"
    site.mkdir()
    folder.mkdir()
    shutil.copy(ROOT / "graph" / "testing" / "pytest_plugin.py", site / "tickgraph_pytest.py")
    (folder / "pytest.ini").write_text("[pytest]\n")

    def run(*arguments, path=(ROOT,)):
        paths = "".join(f"sys.path.append({str(one)!r}); " for one in (site, *path))
        code = f"import sys; {paths}import pytest; sys.exit(pytest.main(sys.argv[1:]))"
        command = [sys.executable, "-c", code, "-p", "tickgraph_pytest", "-p", "no:cacheprovider", *arguments]
        # Without the other plugins that happen to be installed here.
        environment = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        return SimpleNamespace(code=done.returncode, out=done.stdout + done.stderr)

    return SimpleNamespace(folder=folder, run=run)


def test_each_case_is_an_item_and_a_failure_is_reported_by_its_line(project):
    (project.folder / "small.test.yaml").write_text(TESTS)
    done = project.run("-v")
    assert done.code == 1
    assert "small.test.yaml::it finishes PASSED" in done.out
    assert "small.test.yaml::it finishes late FAILED" in done.out
    assert "small.test.yaml:10:22: fired finished: expected [3], got [2]" in done.out
    assert "1 failed, 1 passed" in done.out
    assert "Traceback" not in done.out
    assert "1 passed, 1 deselected" in project.run("-k", "finishes and not late").out


def test_mistakes_of_a_file_are_reported_when_it_is_collected(project):
    (project.folder / "small.test.yaml").write_text(TESTS.replace("fired", "fird"))
    done = project.run()
    assert done.code == 2
    assert 'small.test.yaml:8:14: case "it finishes": unknown key "fird" in expect; did you mean "fired"?' in done.out
    assert "Traceback" not in done.out


def test_wrong_names_fail_their_case(project):
    (project.folder / "small.test.yaml").write_text(TESTS.replace("{finished: [2]", "{finishd: [2]"))
    done = project.run()
    assert 'has no attribute "finishd"; did you mean "finished"?' in done.out
    assert "2 failed" in done.out


def test_other_tools_files_are_left_alone(project):
    (project.folder / "docker.test.yaml").write_text("services: {db: {image: postgres}}\n")
    (project.folder / "graph.yaml").write_text("tickgraph: 1\n")
    (project.folder / "odd.test.yaml").write_bytes(b"\xff\x00\x80")
    assert "no tests ran" in project.run().out
    assert project.run("docker.test.yaml").code == 4  # pytest's own: nothing collects that file


def test_a_project_with_a_package_called_graph_keeps_its_own(project):
    package = project.folder / "graph"
    package.mkdir()
    (package / "__init__.py").write_text("OWN = True\n")
    (project.folder / "test_own.py").write_text("import graph\n\ndef test_own():\n    assert graph.OWN\n")
    assert "1 passed" in project.run().out


def test_a_run_that_uses_nothing_loads_nothing(project):
    (project.folder / "test_light.py").write_text(
        "import sys\n\ndef test_light():\n"
        "    ours = {'graph', 'nodes', 'sensors', 'numpy', 'pydantic', 'pxr', 'mujoco', 'open3d'}\n"
        "    assert not ours & set(sys.modules)\n"
    )
    assert "1 passed" in project.run().out


def test_the_fixtures_run_nodes_graphs_and_apps(project):
    (project.folder / "small.yaml").write_text(
        "tickgraph: 1\nscene: {prims: {/World/Box: {type: Cube}}}\ngraphs: {/G: {nodes: {tick: OnPlaybackTick}}}\n"
    )
    (project.folder / "test_small.py").write_text(
        "def test_node(run_node):\n"
        "    trace = run_node('Countdown', inputs={'duration': 2}, pulses={'execIn': [0]}, updates=4)\n"
        "    assert trace.fired('finished') == [2]\n\n"
        "def test_graph(run_graph):\n"
        "    assert run_graph('small.yaml', updates=3).fired('tick.tick') == [0, 1, 2]\n\n"
        "kept = []\n\n"
        "def test_app(make_app):\n"
        "    app, bare = make_app('small.yaml'), make_app(physics_hz=100)\n"
        "    assert app.stage.GetPrimAtPath('/World/Box') and '/G' in app.graphs and not bare.graphs\n"
        "    app.play()\n"
        "    app.update(steps=3)\n"
        "    kept.append(app)\n\n"
        "def test_closed():\n"
        "    assert kept[0].timeline.is_stopped()\n"
    )
    assert "4 passed" in project.run().out


def test_the_project_installs_the_plugin_as_a_module_of_its_own():
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf8"))
    assert project["project"]["entry-points"]["pytest11"] == {"tickgraph": "tickgraph_pytest"}
    included = project["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    assert included == {"graph/testing/pytest_plugin.py": "tickgraph_pytest.py", "graphs": "tickgraph_examples"}
