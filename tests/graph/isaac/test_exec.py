"""`graph exec`: the life of a script."""

import json
import subprocess
import sys

import pytest

from graph.cli.main import main
from tests.support.places import ROOT

APP = "from isaacsim import SimulationApp\napp = SimulationApp({'headless': True})\n"


def test_a_script_runs_with_its_arguments_and_ends_at_close(run_script):
    loop = "for _ in range(3):\n    app.update()\napp.close()\nprint('never')\n"
    script = f"import sys\n{APP}print(sys.argv[1:], __name__)\n{loop}"
    code, out, err = run_script(script, arguments=("--test", "-x", "3"))
    assert code == 0
    assert out == "['--test', '-x', '3'] __main__\n"
    assert "3 updates" in err


def test_the_limit_of_updates_ends_a_loop_and_then_the_script(run_script):
    code, out, err = run_script(
        f"{APP}while app.is_running():\n    app.update()\nprint('end')\napp.close()\n", "--updates", 7
    )
    assert (code, out) == (0, "end\n")
    assert "7 updates" in err
    code, out, err = run_script(f"{APP}while True:\n    app.update()\n", "--updates", 7)
    assert (code, out) == (0, "")
    assert "12 updates" in err  # seven, and five to end by itself


def test_an_except_clause_does_not_catch_the_end(run_script):
    code, out, _ = run_script(f"{APP}try:\n    app.close()\nexcept Exception:\n    print('no')\n")
    assert (code, out) == (0, "")


def test_a_bare_except_around_the_loop_ends_with_its_report(tmp_path):
    file = tmp_path / "script.py"
    file.write_text(f"{APP}while True:\n    try:\n        app.update()\n    except:\n        pass\n")
    command = [sys.executable, "-m", "graph", "exec", "--updates", "3", "--out", tmp_path / "out", file]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert "caught its own end" in done.stderr
    assert json.loads((tmp_path / "out" / "report.json").read_text())["updates"] == 8


def test_an_error_names_the_scripts_line_and_no_traceback(run_script):
    code, _, err = run_script(f"{APP}def f():\n    raise RuntimeError('too hot')\n\nf()\n")
    assert code == 1
    line = err.strip().splitlines()[-1]
    assert line.endswith("script.py:4 (called from :6): RuntimeError: too hot")
    assert "Traceback" not in err


def test_a_syntax_error_is_wrong_input(run_script):
    code, _, err = run_script("def f(:\n")
    assert code == 2
    assert "script.py:1: not Python" in err


@pytest.mark.parametrize(
    ("last", "expected"),
    [("app.close(exit_code=4)", 4), ("import sys\nsys.exit(5)", 5), ("raise SystemExit", 0)],
)
def test_exit_codes_are_the_scripts(run_script, last, expected):
    assert run_script(f"{APP}{last}\n")[0] == expected


def test_errors_that_the_script_caught_are_listed_and_strict_fails(run_script):
    script = f"""{APP}import omni.graph.core as og
try:
    og.Controller.edit("/G", {{og.Controller.Keys.CREATE_NODES: [("x", "acme.Nope")]}})
except Exception as error:
    pass
app.close()
"""
    code, _, err = run_script(script)
    assert code == 0
    assert "caught by the script" in err
    assert "script.py:5" in err
    assert run_script(script, "--strict")[0] == 1


def test_a_snippet_has_an_application_and_may_await(run_script):
    script = """import omni.kit.app, omni.timeline, asyncio
async def later():
    for _ in range(4):
        await omni.kit.app.get_app().next_update_async()
    print("later")
asyncio.ensure_future(later())
print(omni.timeline.get_timeline_interface().is_playing())
await omni.kit.app.get_app().next_update_async()
print("here")
"""
    code, out, _ = run_script(script)
    assert (code, out.split()) == (0, ["False", "here", "later"])


def test_the_report_counts_what_the_script_did(run_script, tmp_path):
    play = "import omni.timeline\nomni.timeline.get_timeline_interface().play()\n"
    script = f"{APP}{play}for _ in range(60):\n    app.update()\napp.close()\n"
    code, out, _ = run_script(f"print('hello')\n{script}", "--json", "--out", tmp_path / "out")
    report = json.loads(out)
    assert code == 0
    assert (report["updates"], report["physics_steps"], report["simulation_time"]) == (60, 60, 1.0)
    assert json.loads((tmp_path / "out" / "report.json").read_text())["updates"] == 60


def test_a_second_application_is_refused(run_script):
    code, _, err = run_script(f"{APP}SimulationApp()\n")
    assert code == 1
    assert "there is a SimulationApp already" in err


def test_settings_come_from_extra_args_and_the_command_line(run_script):
    script = """from isaacsim import SimulationApp
app = SimulationApp({"extra_args": ["--/a/b=3", "--/a/c=true"]})
import carb
s = carb.settings.get_settings()
print(s.get("/a/b"), s.get("/a/c"), s.get("/a/d"), s.get("/a/none"), s.get_as_int("/a/none"))
"""
    assert run_script(script, "--/a/d=text")[1] == "3 True text None 0\n"


def test_nothing_is_left_behind(run_script):
    before = dict(sys.modules), list(sys.meta_path), list(sys.path), list(sys.argv)
    run_script(f"{APP}import omni.usd, carb\nimport pxr.PhysxSchema\napp.close()\n")
    assert not {name for name in sys.modules if name.partition(".")[0] in ("omni", "carb", "isaacsim", "usdrt")}
    assert (list(sys.meta_path), list(sys.path), list(sys.argv)) == before[1:]


def test_a_missing_script_is_wrong_input(capsys, tmp_path):
    assert main(["exec", str(tmp_path / "none.py")]) == 2
    assert "give the path of a Python script" in capsys.readouterr().err


def test_a_node_that_fails_is_reported_and_the_script_goes_on_as_in_kit(run_script):
    edit = (
        "import omni.graph.core as og, omni.timeline\n"
        "og.Controller.edit({'graph_path': '/G', 'evaluator_name': 'execution'}, {\n"
        "    'create_nodes': [('tick', 'OnPlaybackTick'), ('read', 'IsaacReadEffortSensor')],\n"
        "    'connect': [('tick.outputs:tick', 'read.inputs:execIn')]})\n"
        "omni.timeline.get_timeline_interface().play()\n"
        "for _ in range(3):\n    app.update()\nprint(og.Controller.get('/G/read.outputs:value'))\n"
    )
    code, out, err = run_script(f"{APP}{edit}app.close()\n")
    assert (code, out) == (0, "0.0\n")
    assert "warning compute-failed: /G/read: input prim names 0 prims; give it the path of one prim (3 times)" in err
    code, _, err = run_script(f"{APP}{edit}app.close()\n", "--strict")
    assert code == 1
    assert "strict: /G/read: input prim names 0 prims" in err
    code, _, err = run_script(f"{APP}{edit}app.close()\n", "--/tickgraph/nodeErrorsStop=true")
    assert code == 1
    assert "failed in update 0: input prim names 0 prims" in err
