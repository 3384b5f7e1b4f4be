import json

import pytest

from graph import ComputeError
from graph.cli.main import main
from graph.testing import run_node

COUNTING = """\
def setup(db):
    db.internal_state.count = 10

def compute(db):
    db.internal_state.count += 1
    db.outputs.count = db.internal_state.count
    return True
"""


def run_script(script, *, allow_scripts=True, pulses=(0,), **options):
    inputs = {"script": script, **options.pop("inputs", {})}
    return run_node("ScriptNode", inputs=inputs, pulses={"execIn": pulses}, allow_scripts=allow_scripts, **options)


def test_nothing_of_a_script_runs_unless_the_user_allows_it(tmp_path):
    trace = tmp_path / "ran"
    with pytest.raises(ComputeError, match="it runs Python code that the graph file brings; if you trust the file"):
        run_script(f"open({str(trace)!r}, 'w')", allow_scripts=False)
    assert not trace.exists()


def test_setup_runs_once_and_compute_each_time():
    trace = run_script(COUNTING, pulses=(0, 2), updates=3, outputs=["count"])
    assert trace.values("count") == [11, 11, 12]
    assert trace.fired("execOut") == [0, 2]


def test_a_compute_that_returns_false_is_not_followed():
    trace = run_script("def compute(db):\n    return db.inputs.go", inputs={"go": {"type": "bool", "value": False}})
    assert trace.fired("execOut") == []


def test_a_script_without_functions_runs_as_a_whole():
    trace = run_script(
        "db.outputs.twice = db.inputs.x * 2", inputs={"x": {"type": "double", "value": 4}}, outputs=["twice"]
    )
    assert (trace.value("twice"), trace.fired("execOut")) == (8, [0])


def test_an_execution_state_enables_an_output():
    script = "def compute(db):\n    db.outputs.execOut = og.ExecutionAttributeState.ENABLED"
    assert run_script(script).fired("execOut") == [0]


def test_a_script_may_import_og():
    script = (
        "import omni.graph.core as og\ndef compute(db):\n    db.outputs.execOut = og.ExecutionAttributeState.ENABLED"
    )
    assert run_script(script).fired("execOut") == [0]
    whole = "import omni.graph.core as og\ndb.outputs.n = int(og.ExecutionAttributeState.ENABLED)"
    assert run_script(whole, pulses=(0, 1), updates=2, outputs=["n"]).values("n") == [1, 1]


def test_a_script_finds_the_stage_through_omni_usd(stage, world):
    script = (
        "import omni.usd\ndef compute(db):\n    prim = omni.usd.get_context().get_stage().GetPrimAtPath('/World')\n"
    )
    script += "    db.outputs.type = str(prim.GetTypeName())\n"
    stage.DefinePrim("/World", "Xform")
    assert run_script(script, outputs=["type"], app=world()).value("type") == "Xform"


def test_a_changed_script_is_cleaned_up_and_set_up_again():
    scripts = [
        "\n".join(f"def {name}(db): print('{name} {number}')" for name in ("setup", "compute", "cleanup"))
        for number in (0, 1)
    ]
    said = []
    import logging

    handler = logging.Handler()
    handler.emit = lambda record: said.append(record.getMessage())
    logger = logging.getLogger("tickgraph")
    logger.addHandler(handler)
    level = logger.level
    logger.setLevel(logging.INFO)
    try:
        run_node(
            "ScriptNode",
            inputs={"script": lambda update: scripts[update]},
            pulses={"execIn": [0, 1]},
            updates=2,
            allow_scripts=True,
        ).graph.close()
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
    assert said == ["setup 0", "compute 0", "cleanup 0", "setup 1", "compute 1", "cleanup 1"]


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("def compute(db):\n    x = 1\n    return x / 0", "line 3 of its script: ZeroDivisionError: division by zero"),
        ("def compute(db)\n    pass", r"line 1 of its script: SyntaxError: expected ':'"),
        ("import no_such_module\ndef compute(db): pass", "line 1 of its script: ModuleNotFoundError"),
        (
            "def compute(db):\n    import omni.anim",
            "line 2 of its script: .* TickGraph does not have that module of Kit: ",
        ),
        ("import omni.usd\nomni.usd.get_url()", "line 2 .* has no omni.usd.get_url"),
        (
            "def compute(db):\n    db.outputs.nothing = 1",
            'line 2 of its script: AttributeError: the node has no output "nothing"',
        ),
        ("def compute(db):\n    db.fail('too hot')", "too hot"),
    ],
)
def test_an_error_names_the_line_of_the_script(script, message):
    with pytest.raises(ComputeError, match=message):
        run_script(script)


def test_warnings_of_a_script_are_collected():
    trace = run_script("def compute(db):\n    db.log_warning('careful')", pulses=(0, 1), updates=2)
    assert [(one.code, one.message, one.count) for one in trace.warnings] == [("node-warning", "careful", 2)]


FILE = """\
tickgraph: 1
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      half:
        type: ScriptNode
        attributes: {{"inputs:x": double, "outputs:y": double, "outputs:done": execution}}
        inputs: {{{inputs}, x: 5}}
      wait: {{type: Counter}}
    connections:
      - tick.tick -> half.execIn
      - half.done -> wait.execIn
"""
HALVE = r'script: "def compute(db):\n    db.outputs.y = db.inputs.x / 2\n    db.outputs.done = 1"'


@pytest.fixture
def graph_file(tmp_path):
    def write(inputs=HALVE):
        path = tmp_path / "script.yaml"
        path.write_text(FILE.format(inputs=inputs))
        return str(path)

    return write


def test_a_file_with_a_script_is_refused_with_its_place_and_the_flag(graph_file, capsys):
    path = graph_file()
    assert main(["run", path, "--updates", "2"]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert line.startswith(f'{path}:6:7: node "half" (ScriptNode) runs Python code that the graph file brings')
    assert "--allow-scripts" in line
    assert main(["check", path]) == 0


def test_an_allowed_file_runs_its_script(graph_file, capsys):
    assert main(["run", graph_file(), "--updates", "3", "--allow-scripts", "--json"]) == 0
    nodes = json.loads(capsys.readouterr().out)["nodes"]
    assert nodes["/World/Graph/wait"]["computes"] == 3


def test_an_output_is_held_against_its_type(graph_file, capsys):
    path = graph_file(r'script: "def compute(db):\n    db.outputs.y = \"text\""')
    assert main(["run", path, "--updates", "1", "--allow-scripts"]) == 1
    assert (
        "line 2 of its script: ValueError: output y: expected a number (double), got 'text'" in capsys.readouterr().err
    )


def test_a_script_may_lie_in_a_file_of_the_graph_files_folder(graph_file, tmp_path, capsys):
    (tmp_path / "halve.py").write_text("def compute(db):\n    db.outputs.done = 1\n")
    assert (
        main(["run", graph_file("usePath: true, scriptPath: halve.py"), "--updates", "1", "--allow-scripts", "--json"])
        == 0
    )
    assert json.loads(capsys.readouterr().out)["nodes"]["/World/Graph/wait"]["computes"] == 1


def test_a_script_outside_the_folder_is_not_read(graph_file, tmp_path, capsys):
    path = graph_file("usePath: true, scriptPath: ../outside.py")
    assert main(["run", path, "--updates", "1", "--allow-scripts"]) == 1
    assert "outside.py, which lies outside" in capsys.readouterr().err
    path = graph_file("usePath: true, scriptPath: none.py")
    assert main(["run", path, "--updates", "1", "--allow-scripts"]) == 1
    assert "none.py cannot be read: No such file or directory" in capsys.readouterr().err


SCENE = """\
#usda 1.0
def Xform "World" {
    def OmniGraph "Graph" {
        token evaluator:type = "execution"
        token pipelineStage = "pipelineStageSimulation"
        def OmniGraphNode "tick" {
            token node:type = "omni.graph.action.OnPlaybackTick"
            int node:typeVersion = 2
            custom uint outputs:tick (customData = { bool isExecution = 1 })
        }
        def OmniGraphNode "script" {
            token node:type = "omni.graph.scriptnode.ScriptNode"
            int node:typeVersion = 2
            custom string inputs:script = "raise SystemExit"
            custom uint inputs:execIn
            prepend uint inputs:execIn.connect = </World/Graph/tick.outputs:tick>
        }
    }
}
"""


def test_a_script_of_a_saved_scene_does_nothing_with_a_warning(tmp_path, capsys):
    (tmp_path / "scene.usda").write_text(SCENE)
    assert main(["run", str(tmp_path / "scene.usda"), "--updates", "2", "--json"]) == 0
    warnings = json.loads(capsys.readouterr().out)["warnings"]
    assert "scripts-not-allowed" in [one["code"] for one in warnings]
