"""A wing is found by its declaration alone: nothing outside knows it, and everything else works without it."""

import ast
import subprocess
import sys
import tomllib

import pytest

from graph.base import plugins
from graph.node.registry import DEFAULT
from tests.support.places import PACKAGES, ROOT
from tests.support.without_wing import WINGS, environment, tree_without

DECLARED = {
    group: table
    for group, table in tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"].items()
    if group.startswith("tickgraph.")
}


def test_the_declarations_are_read_as_toml_reads_them():
    assert {group: {one.name: one.value for one in plugins.shipped(group).values()} for group in DECLARED} == DECLARED


def test_a_table_of_entry_points_says_the_same(tmp_path, monkeypatch):
    """As an installed wheel has it: there is no pyproject.toml beside the packages."""
    lines = (line for group, table in DECLARED.items() for line in (f"[{group}]", *map(" = ".join, table.items()), ""))
    info = tmp_path / "tickgraph-0.1.0.dist-info"
    info.mkdir()
    (info / "entry_points.txt").write_text("\n".join(["[console_scripts]", "graph = graph.cli:command", "", *lines]))
    (tmp_path / "graph").symlink_to(ROOT / "graph")
    code = (
        "from graph.base.plugins import shipped\n"
        f"print({{group: {{name: one.value for name, one in shipped(group).items()}} for group in {[*DECLARED]!r}}})"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment(tmp_path), capture_output=True)
    assert (done.stderr, ast.literal_eval(done.stdout.decode())) == (b"", DECLARED)


def test_every_wing_is_declared_and_every_declaration_loads():
    everything = [plugin for group in DECLARED for plugin in plugins.shipped(group).values()]
    modules = [plugin.module.split(".") for plugin in everything]
    assert {wing for package, wing, *_ in modules if package == "wings"} == set(WINGS)
    assert all(plugin.load() is not None and plugin.absence == "" for plugin in everything)


@pytest.mark.parametrize("package", [name for name in PACKAGES if name != "wings"])
def test_nothing_outside_names_a_wing(package):
    """In imports `tests/test_imports.py` sees to it; here in texts, by which a module could be imported."""
    named = [
        f"{path.relative_to(ROOT)}:{node.lineno}: {node.value}"
        for path in sorted((ROOT / package).rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
        if any(f"wings.{wing}" in node.value for wing in WINGS)
    ]
    assert named == []


def node(name):
    """A graph with a node, and what its check says of the node in front of the reason."""
    said = f'file.yaml:2:29: node "one": node type "{name}" cannot be used: it comes'
    return f"graphs: {{/World/G: {{nodes: {{one: {name}}}}}}}", ["check", "file.yaml"], said, "; --skip-unknown runs"


def prim(type_name):
    """A scene with a prim, and what its check says."""
    said = f"file.yaml:2:17: sensors of type {type_name} cannot be used: it comes"
    return f"scene: {{prims: {{/World/S: {{type: {type_name}}}}}}}", ["check", "file.yaml"], said, ""


NEEDS = {
    "acoustic": prim("OmniAcoustic"),
    "actuators": node("ArticulationActuators"),
    "campaign": ("", ["sweep", "file.yaml", "--out", "o"], "graph: the command sweep cannot be used: it comes", ""),
    "device": (
        "",
        ["run", "graphs/quickstart.yaml", "--device", "cuda"],
        "graph: the device cuda cannot be used: it comes",
        "",
    ),
    "exports": (
        "",
        ["export", "out", "--format", "ply", "--out", "clouds"],
        "graph: the export ply cannot be used: it comes",
        "",
    ),
    "hsb": node("HSBSend"),
    "mjcf": (
        "scene: {mjcf: model.xml}",
        ["check", "file.yaml"],
        "graph: the scene format mjcf cannot be used: it comes",
        "",
    ),
    "opengl": (
        "fidelity: {camera.backend: gl}",
        ["run", "file.yaml", "--updates", "1"],
        "graph: the camera backend gl cannot be used: it comes",
        "",
    ),
    "physx": prim("Lidar"),
    "physx_graph": node("OnTriggerCollider"),
    "portability": (
        "",
        ["check", "graphs/quickstart.yaml", "--target", "ovrtx"],
        "graph: the target ovrtx cannot be used: it comes",
        "",
    ),
    "replicator": node("SdOnNewFrame"),
    "robots": node("StanleyControlPID"),
    "services": node("OgnROS2ServiceClient"),
    "stand_ins": (
        "scene: {prims: {/World/G: {reference: /Isaac/Environments/Grid/grid.usd}}}",
        ["check", "file.yaml"],
        "file.yaml:2:28: /World/G: reference: the stand-in Isaac cannot be used: it comes",
        "",
    ),
    "trade": ("", ["trade", "file.yaml"], "graph: the command trade cannot be used: it comes", ""),
    "transports": (
        "",
        ["run", "file.yaml", "--live", "dds"],
        "graph: --live dds: the transport dds cannot be used: it comes",
        "",
    ),
    "ucx": node("UCXPublishClock"),
    "ui": node("OnNewFrame"),
    "view": ("", ["view", "out"], "graph: the command view cannot be used: it comes", ""),
}
"""By wing: a file, a command that needs the wing for it, and what is said before and after the reason."""

TRIED = """
import sys
from graph.cli.main import main
from graph.node.registry import DEFAULT
print(len(DEFAULT.all()))
assert main(["check", "graphs/quickstart.yaml"]) == 0
assert main(["run", "graphs/quickstart.yaml", "--updates", "2", "--out", "out"]) == 0
assert main(["schema"]) == 0
assert main(sys.argv[1:]) == 2
"""


@pytest.mark.parametrize("wing", WINGS)
def test_everything_else_works_without_the_wing(wing, tmp_path):
    """All other node types load, a graph is checked and run, the schema made; a file that needs it gets one line."""
    text, command, before, after = NEEDS[wing]
    tree = tree_without(wing, tmp_path)
    (tree / "file.yaml").write_text(f"tickgraph: 1\n{text}\n")
    (tree / "model.xml").write_text("<mujoco/>")
    run = [sys.executable, "-c", TRIED, *command]
    done = subprocess.run(run, cwd=tree, env=environment(tree), capture_output=True, text=True, check=False)
    reason = (
        f" with the wing wings.{wing}, which is not installed; reinstall tickgraph, or restore the folder wings/{wing}"
    )
    assert done.stderr.startswith(f"{before}{reason}{after}")
    assert done.stderr.count("\n") == 1
    shipped = [one for one in DEFAULT.all() if one.shipped]
    gone = [one for one in shipped if one.origin.startswith(f"wings.{wing}.")]
    assert int(done.stdout.split()[0]) == len(shipped) - len(gone)


NAMED = """
import graph.isaac
with graph.isaac.importable():
    from isaacsim.robot.wheeled_robots import DifferentialController
    from {module} import {name}
DifferentialController(wheel_radius=0.1, wheel_base=0.5)
try:
    {name}("/World/Sensor")
except NotImplementedError as error:
    print(error)
"""


@pytest.mark.parametrize(
    ("wing", "module", "name"),
    [
        ("robots", "isaacsim.robot.wheeled_robots", "HolonomicController"),
        ("robots", "isaacsim.robot.experimental.wheeled_robots.controllers", "AckermannController"),
        ("acoustic", "isaacsim.sensors.experimental.rtx", "AcousticSensor"),
    ],
)
def test_a_name_of_isaac_sim_says_which_wing_it_needs(wing, module, name, tmp_path):
    """It can be imported, as all names that refuse; the other names of its module work."""
    tree = tree_without(wing, tmp_path)
    code = NAMED.format(module=module, name=name)
    run = subprocess.run([sys.executable, "-c", code], cwd=tree, env=environment(tree), capture_output=True, text=True)
    reason = f"it comes with the wing wings.{wing}, which is not installed; reinstall tickgraph, or restore the folder"
    assert (run.stdout, run.stderr) == (f"{module}.{name}: {reason} wings/{wing}\n", "")
