"""A package with `.ogn` files, installed by putting its folder on the path."""

import json
import os
import re
import subprocess
import sys

import pytest

from graph import ComputeError, UserError
from graph.node import finders
from graph.node.registry import Registry
from graph.testing import run_node
from tests.support.places import ROOT

SCALE = {
    "Scale": {
        "version": 2,
        "description": ["Scale a number.", "And count how often."],
        "language": "python",
        "uiName": "Scale It",
        "tokens": ["times"],
        "inputs": {
            "execIn": {"type": "execution", "description": "scales"},
            "factor": {"type": "double", "description": "the factor", "default": 2.0, "minimum": 0},
            "value": {"type": ["numerics"], "description": "the number"},
            "mode": {"type": "token", "description": "how", "default": "up", "metadata": {"allowedTokens": "up,down"}},
            "$comment": "left out",
        },
        "outputs": {
            "execOut": {"type": "execution", "description": "follows"},
            "result": {"type": "double", "description": "the product"},
            "count": {"type": "int", "description": "computes so far"},
        },
    }
}
SCALE_PY = """\
class OgnScale:
    @staticmethod
    def internal_state():
        return type("State", (), {"count": 0})()

    @staticmethod
    def compute(db):
        state = db.per_instance_state
        state.count += 1
        db.outputs.count = state.count
        if db.inputs.factor == 0:
            db.log_warning(f"nothing to {db.tokens.times}")
            return False
        db.outputs.result = db.inputs.value * db.inputs.factor
        db.outputs.execOut = 1
        return True
"""
PULSE = {
    "acme.events.Pulse": {
        "description": "Fire each time.",
        "outputs": {"out": {"type": "execution", "description": "x"}},
    }
}
PULSE_PY = "def compute(db):\n    db.outputs.out = True\n"


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """A function that installs files as the package acme_nodes and gives the registry that finds it."""

    def install(files):
        for name in [name for name in sys.modules if name.split(".")[0] == "acme_nodes"]:
            monkeypatch.delitem(sys.modules, name)
        info = tmp_path / "acme-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: acme\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text("[tickgraph.ogn]\nacme.maths = acme_nodes\n")
        package = tmp_path / "acme_nodes"
        package.mkdir()
        (package / "__init__.py").touch()
        for name, content in files.items():
            (package / name).parent.mkdir(exist_ok=True)
            (package / name).write_text(content if isinstance(content, str) else json.dumps(content, indent=2))
        monkeypatch.syspath_prepend(tmp_path)
        return Registry(finders.ALL)

    return install


def command(folder, *arguments):
    """Runs the command in this folder, which is on its path."""
    path = os.pathsep.join([str(folder), str(ROOT)])
    return subprocess.run(
        [sys.executable, "-m", "graph", *arguments],
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path},
    )


GOOD = {"OgnScale.ogn": SCALE, "OgnScale.py": SCALE_PY, "events/OgnPulse.ogn": PULSE, "events/OgnPulse.py": PULSE_PY}


def test_declarations_become_node_types(installed):
    registry = installed(GOOD)
    scale = registry.get("acme.maths.Scale")
    assert registry.get("Scale") is scale
    assert (scale.version, scale.doc, scale.origin) == (
        2,
        "Scale a number.\nAnd count how often.",
        "acme_nodes/OgnScale.ogn:2",
    )
    assert list(scale.inputs) == ["execIn", "factor", "value", "mode"]
    assert (scale.inputs["factor"].default, scale.inputs["factor"].minimum) == (2.0, 0)
    assert scale.inputs["mode"].allowed_tokens == ("up", "down")
    assert registry.get("acme.events.Pulse").event == 0


def test_their_python_computes(installed):
    scale = installed(GOOD).get("Scale")
    inputs = {"value": {"type": "int", "value": 4}, "factor": lambda update: [3.0, 0.0, 2.5][update]}
    trace = run_node(scale, inputs=inputs, pulses={"execIn": [0, 1, 2]}, updates=3)
    assert trace.values("result") == [12.0, 12.0, 10.0]
    assert trace.values("count") == [1, 2, 3]
    assert trace.fired("execOut") == [0, 2]
    assert [(one.code, one.message) for one in trace.warnings] == [("node-warning", "nothing to times")]


def test_a_type_without_execution_inputs_begins_walks(installed):
    pulse = installed(GOOD).get("Pulse")
    assert run_node(pulse, updates=3).fired("out") == [0, 1, 2]


def test_an_output_of_another_type_fails_the_node(installed):
    python = "def compute(db):\n    db.outputs.result = 'text'\n"
    scale = installed({"OgnScale.ogn": SCALE, "OgnScale.py": python}).get("Scale")
    with pytest.raises(ComputeError, match=r"output result: expected a number \(double\), got 'text'"):
        run_node(scale, inputs={"value": {"type": "int", "value": 4}}, pulses={"execIn": [0]})


def test_a_class_that_keeps_nothing_says_how_to(installed):
    python = "def compute(db):\n    db.per_instance_state.count = 1\n"
    scale = installed({"OgnScale.ogn": SCALE, "OgnScale.py": python}).get("Scale")
    with pytest.raises(ComputeError, match="its class keeps no state; give it a static internal_state"):
        run_node(scale, inputs={"value": {"type": "int", "value": 4}}, pulses={"execIn": [0]})


HEADER = """\
import omni.graph.core
import omni.graph.core as og
from omni.graph.core import Controller
"""


def test_its_module_may_import_og_which_is_gone_afterwards(installed):
    body = "def compute(db):\n    db.outputs.out = og.ExecutionAttributeState.ENABLED\n"
    check = "assert omni.graph.core is og and Controller is og.Controller\n"
    pulse = installed({"OgnPulse.ogn": PULSE, "OgnPulse.py": HEADER + check + body}).get("Pulse")
    assert run_node(pulse, updates=2).fired("out") == [0, 1]
    assert not [name for name in sys.modules if name.partition(".")[0] == "omni"]


def test_its_module_finds_the_stage_through_omni_usd(installed):
    from graph.sim import App

    body = "import omni.usd\ndef compute(db):\n    stage = omni.usd.get_context().get_stage()\n"
    body += "    stage.GetPrimAtPath('/World').SetDocumentation('seen')\n"
    with App() as app:
        app.stage.DefinePrim("/World")
        run_node(installed({"OgnPulse.ogn": PULSE, "OgnPulse.py": body}).get("Pulse"), app=app)
        assert app.stage.GetPrimAtPath("/World").GetDocumentation() == "seen"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("import omni.anim", "No module named 'omni.anim'; TickGraph does not have that module of Kit: do without it"),
        ("og.Nodde", "TickGraph has no omni.graph.core.Nodde; did you mean"),
    ],
)
def test_what_of_kit_is_not_there_is_named(installed, line, message):
    registry = installed({"OgnPulse.ogn": PULSE, "OgnPulse.py": f"{HEADER}{line}\n{PULSE_PY}"})
    with pytest.raises(UserError, match=re.escape(message)):
        registry.get("Pulse")


def test_its_compute_may_import_modules_of_kit(installed):
    python = "def compute(db):\n    import carb, omni.timeline\n    import omni.graph.core as og\n    og.Controller\n"
    run_node(installed({"OgnPulse.ogn": PULSE, "OgnPulse.py": python}).get("Pulse"))


def test_what_its_compute_cannot_import_is_reported_with_what_to_do(installed):
    python = "def compute(db):\n    import omni.anim\n"
    with pytest.raises(ComputeError, match="TickGraph does not have that module of Kit"):
        run_node(installed({"OgnPulse.ogn": PULSE, "OgnPulse.py": python}).get("Pulse"))


SIZED = {
    "acme.Sized": {
        "description": "Fill arrays.",
        "inputs": {"size": {"type": "int", "description": "how long"}},
        "outputs": {
            "points": {"type": "pointf[3][]", "description": "filled in place"},
            "names": {"type": "token[]", "description": "of that size"},
            "plain": {"type": "int", "description": "no array"},
            "read": {"type": "int", "description": "the size as it is read"},
        },
    }
}
SIZED_PY = """\
def compute(db):
    n = db.inputs.size
    db.outputs.points_size = n
    db.outputs.points[-1] = (1, 2, n)
    db.outputs.names_size = n
    db.outputs.read = db.outputs.points_size
"""


def test_an_array_output_is_sized_then_filled_in_place(installed):
    """The second compute keeps the element of the first and must not change what the first gave away."""
    sized = installed({"OgnSized.ogn": SIZED, "OgnSized.py": SIZED_PY}).get("Sized")
    trace = run_node(sized, inputs={"size": lambda update: update + 1}, updates=2)
    assert [array.tolist() for array in trace.values("points")] == [[[1, 2, 1]], [[1, 2, 1], [1, 2, 2]]]
    assert trace.value("points").dtype == "float32"
    assert trace.values("names") == [[""], ["", ""]]
    assert trace.values("read") == [1, 2]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("db.outputs.points_size = -1", "output points_size: expected a whole number from 0, got -1"),
        ("db.outputs.plain_size = 1", 'the node has no output "plain_size"'),
        ("db.outputs.points_size = 10**12", "its result would take 12,000,000,000,000 bytes"),
        ("db.outputs.points = [[1, 2, 3]]; db.outputs.points[0] = 0", "read-only"),
    ],
)
def test_a_size_that_cannot_be_is_refused(installed, line, message):
    """10^12 points of 12 bytes are 11,444,091.8 MiB."""
    sized = installed({"OgnSized.ogn": SIZED, "OgnSized.py": f"def compute(db):\n    {line}\n"}).get("Sized")
    with pytest.raises(ComputeError, match=message):
        run_node(sized)


def test_the_command_lists_them_with_their_origin(installed, tmp_path):
    installed(GOOD)
    done = command(tmp_path, "nodes", "acme")
    assert done.stdout == (
        "acme.events.Pulse\t1\tFire each time.\tacme_nodes/events/OgnPulse.ogn:2\n"
        "acme.maths.Scale\t2\tScale a number.\tacme_nodes/OgnScale.ogn:2\n"
    )
    assert done.returncode == 0


@pytest.mark.parametrize(
    ("files", "message"),
    [
        (
            {"OgnScale.ogn": SCALE},
            r"OgnScale\.ogn: there is no OgnScale\.py beside it with its Python",
        ),
        ({"OgnScale.ogn": SCALE, "OgnScale.py": "x = 1"}, "has neither a class OgnScale with compute"),
        ({"OgnScale.ogn": SCALE, "OgnScale.py": "1/0"}, "cannot be imported: division by zero"),
        ({"OgnScale.ogn": SCALE, "OgnScale.py": "import no_such"}, "cannot be imported: No module named 'no_such'"),
        ({"OgnScale.ogn": "{"}, r"acme_nodes/OgnScale\.ogn:1:2: "),
    ],
)
def test_a_broken_declaration_is_a_warning_and_an_error_only_where_it_is_used(installed, caplog, files, message):
    registry = installed({**files, "OgnPulse.ogn": PULSE, "OgnPulse.py": PULSE_PY})
    assert registry.get("Pulse").id == "acme.events.Pulse"
    (warning,) = [record.getMessage() for record in caplog.records]
    assert warning.startswith("warning node-package: acme.maths (acme_nodes): acme_nodes/OgnScale.ogn")
    assert re.search(message, warning)
    for name in ("acme.maths.Scale", "Scale", "OgnScale"):
        with pytest.raises(UserError, match=message) as caught:
            registry.get(name)
        assert str(caught.value).startswith(f'node type "{name}" cannot be used: acme_nodes/OgnScale.ogn')


def test_each_broken_file_has_a_warning(installed, caplog):
    installed({"OgnScale.ogn": "[]", "OgnOther.ogn": "{}"}).all()
    assert [record.getMessage().split(":")[2].strip() for record in caplog.records] == [
        "acme_nodes/OgnOther.ogn",
        "acme_nodes/OgnScale.ogn",
    ]


def test_a_graph_runs_beside_a_broken_package_which_is_reported_where_a_type_of_a_package_is_asked_for(
    installed, tmp_path
):
    installed({"OgnScale.ogn": "[[[", "OgnPulse.ogn": PULSE, "OgnPulse.py": PULSE_PY})
    (tmp_path / "g.yaml").write_text("tickgraph: 1\ngraphs: {/G: {nodes: {c: OnTick}}}\n")
    done = command(tmp_path, "check", "g.yaml")
    assert (done.returncode, done.stderr) == (0, "")
    (tmp_path / "g.yaml").write_text("tickgraph: 1\ngraphs: {/G: {nodes: {p: acme.events.Pulse}}}\n")
    done = command(tmp_path, "check", "g.yaml")
    assert done.returncode == 0
    assert done.stderr.startswith("warning node-package: acme.maths (acme_nodes): acme_nodes/OgnScale.ogn:1:4: ")
    assert done.stderr.count("\n") == 1
