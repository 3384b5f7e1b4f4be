"""Which node types there are, by which names, and what declaring one checks."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import import_module

import pytest

from graph import Attribute, NodeType, UserError, declare, node_type
from graph.base.plugins import NODES, shipped
from graph.node.attribute_names import names_in_order
from graph.node.registry import DEFAULT, Registry, UnknownNodeTypeError
from tests.support.places import LIBRARY_FACTS, ROOT
from tests.support.without_wing import MISSING


def of(type_id, origin):
    return NodeType(type_id, origin=origin)


def test_a_type_is_found_by_id_and_by_last_part_with_or_without_ogn():
    registry = Registry()
    one, two = of("isaacsim.core.nodes.OgnScale", "nodes.a:1"), of("omni.graph.action.Branch", "nodes.b:1")
    registry.add(one)
    registry.add(two)
    assert [registry.get(name) for name in (one.id, "OgnScale", "Scale")] == [one] * 3
    assert [registry.get(name) for name in (two.id, "Branch", "OgnBranch")] == [two] * 3
    assert registry.all() == [one, two]
    assert "Branch" in registry
    assert "Brunch" not in registry


def test_an_unknown_name_suggests_the_nearest():
    registry = Registry()
    registry.add(of("omni.graph.action.Branch", "nodes.b:1"))
    with pytest.raises(UnknownNodeTypeError, match=r'^no node type "Brunch"; did you mean "Branch"\?$'):
        registry.get("Brunch")
    with pytest.raises(KeyError, match=r'did you mean "omni.graph.action.Branch"'):
        registry.get("omni.graph.actions.Branch")


def test_a_word_that_is_part_of_names_leads_to_their_list():
    registry = Registry()
    for name in ("OgnReadTheCameraInfo", "WhatCameraViews", "CameraLensOfAll", "SetCameraOnProduct"):
        registry.add(of(f"example.{name}", "example:1"))
    for word, said in (
        ("camera", "it is part of ReadTheCameraInfo, WhatCameraViews, CameraLensOfAll and 1 more (graph nodes camera)"),
        ("lens", "it is part of CameraLensOfAll (graph nodes lens)"),
    ):
        with pytest.raises(UnknownNodeTypeError) as caught:
            registry.get(word)
        assert str(caught.value) == f'no node type "{word}"; {said}'


def test_ids_are_not_near_for_sharing_a_namespace():
    registry = Registry()
    registry.add(of("omni.graph.nodes.ReadTime", "nodes.t:1"))
    with pytest.raises(UnknownNodeTypeError, match=r'^no node type "omni.graph.nodes.ReadPaint"$'):
        registry.get("omni.graph.nodes.ReadPaint")


def test_shipped_types_win_a_short_name_and_others_must_be_spelled_out():
    registry = Registry()
    shipped = of("omni.graph.action.Branch", "nodes.flow:1")
    for one in (of("mine.Branch", "mine:1"), shipped, of("mine.Odd", "mine:2"), of("yours.Odd", "yours:1")):
        registry.add(one)
    assert registry.get("Branch") is shipped
    with pytest.raises(UnknownNodeTypeError, match=r'"Odd" is ambiguous; write "mine.Odd" or "yours.Odd"'):
        registry.get("Odd")


def test_a_second_type_of_one_id_names_both_origins():
    registry = Registry()
    declare("a.B", "doc", registry=registry)
    with pytest.raises(UserError, match=r'"a.B" is registered twice: by .*test_registry:\d+ and by .*:\d+'):
        declare("a.B", "doc", registry=registry)


def test_the_index_of_the_library_names_every_type_where_it_is_registered():
    """What a module registers and no index names cannot be found: `nodes.TYPES`, or a wing's declarations."""
    import nodes

    for path in sorted(path for package in ("nodes", "wings") for path in (ROOT / package).rglob("*.py")):
        import_module(".".join(path.relative_to(ROOT).with_suffix("").parts))
    registered = {(one.id, one.origin.rpartition(":")[0]) for one in DEFAULT.all() if one.shipped}
    own = {(type_id, f"nodes.{module}") for module, ids in nodes.TYPES.items() for type_id in ids}
    wings = {(type_id, plugin.module) for type_id, plugin in shipped(NODES).items() if type_id not in MISSING}
    assert own | wings == registered


def test_a_type_costs_the_import_of_its_own_module_only():
    code = (
        "import sys\nfrom graph.node.registry import DEFAULT\nassert 'Countdown' in DEFAULT and 'Branch' in DEFAULT\n"
        "found = lambda: [name for name in sys.modules if name.count('.') == 2 and name.startswith('nodes.')]\n"
        "assert found() == [], found()\nassert DEFAULT.get('Countdown').id == 'omni.graph.action.Countdown'\n"
        "print(*found())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.stderr, done.stdout) == ("", "nodes.action.latent\n")


@pytest.mark.parametrize("first", ["", "DEFAULT.get('Branch')\n", "assert 'Branch' in DEFAULT\n"])
def test_an_id_of_the_library_is_taken_before_its_module_is_imported(first):
    code = (
        "from graph import declare\nfrom graph.node.registry import DEFAULT\n"
        f"{first}declare('omni.graph.action.Branch', 'mine')\nDEFAULT.get('Once')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert 'node type "omni.graph.action.Branch" is registered twice: by ' in done.stderr
    assert "nodes.action.flow:" in done.stderr
    assert "__main__:" in done.stderr


@pytest.fixture
def installed(tmp_path):
    """A function that runs the command beside a package whose entry point names the module `parts`, of that text."""

    def command(module, *arguments):
        (tmp_path / "parts.py").write_text(module)
        info = tmp_path / "acme-1.0.dist-info"
        info.mkdir(exist_ok=True)
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: acme\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text("[tickgraph.nodes]\nacme = parts\n")
        path = os.pathsep.join([str(tmp_path), str(ROOT)])
        return subprocess.run(
            [sys.executable, "-m", "graph", *arguments],
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "PYTHONPATH": path},
        )

    return command


TWICE = """\
from graph import Attribute, node_type
import nodes.action.flow
@node_type("acme.Twice", inputs={"x": Attribute("double", "x")}, outputs={"y": Attribute("double", "y")})
def compute(db):
    "Twice."
    db.outputs.y = 2 * db.inputs.x
"""


def test_a_package_is_imported_where_a_type_is_asked_for_that_the_library_has_not(installed):
    module = f"{TWICE}print('imported')\n"
    assert installed(module, "node", "acme.Twice").stdout.startswith("imported\nacme.Twice (version 1)\n")
    assert installed(module, "node", "Countdown").stdout.startswith("omni.graph.action.Countdown")


BROKEN = [
    ("import no_such_module", "ModuleNotFoundError: No module named 'no_such_module'"),
    ("raise RuntimeError('two\\nlines')", "RuntimeError: two lines"),
    ("raise SystemExit(3)", "SystemExit: 3"),
]


@pytest.mark.parametrize(("line", "reason"), BROKEN)
def test_a_package_that_cannot_be_imported_is_left_out_and_named_where_its_type_may_be_asked_for(
    installed, line, reason
):
    module = TWICE + line + "\n"
    shipped = installed(module, "node", "Countdown")
    assert (shipped.returncode, shipped.stderr) == (0, "")
    listed = installed(module, "nodes", "Branch")
    assert listed.stdout.startswith("omni.graph.action.Branch\t")
    warning = f"warning node-package: acme (parts): {reason}; the package is left out, repair or uninstall it\n"
    assert (listed.returncode, listed.stderr) == (0, warning)
    asked = installed(module, "node", "acme.Twice")
    assert asked.returncode == 2
    assert asked.stderr == warning + (
        f'graph: no node type "acme.Twice"; it may be of the node package "acme" (parts), which is left out: {reason}\n'
    )


def test_a_package_that_takes_an_id_of_the_library_is_left_out(installed):
    done = installed(TWICE.replace("acme.Twice", "omni.graph.action.Branch"), "nodes", "Branch")
    assert done.returncode == 0
    assert '(parts): node type "omni.graph.action.Branch" is registered twice: by nodes.action.flow:' in done.stderr


def test_the_decorator_keeps_the_function_and_its_docstring():
    registry = Registry()

    @node_type("a.B", version=3, inputs={"x": Attribute("int", "doc", default=2)}, event=True, registry=registry)
    def compute(db):
        """What it does.

        In more words.
        """

    made = registry.get("a.B")
    assert made.compute is compute
    assert (made.version, made.doc, made.event) == (3, "What it does.\n\nIn more words.", 0)
    assert made.origin.rpartition(":")[0].endswith("test_registry")


@pytest.mark.parametrize(
    ("attribute", "message"),
    [
        (Attribute("doubel", "x"), r'inputs x: no attribute type "doubel"; did you mean "double"'),
        (Attribute("int", "x", default="a"), r"inputs x: expected a whole number \(int\), got 'a'"),
        (Attribute(("numerics", "nothing"), "x"), 'inputs x: no attribute type "nothing"'),
    ],
)
def test_a_wrong_declaration_is_refused_where_it_is_made(attribute, message):
    with pytest.raises(ValueError, match=rf"^a.B \(.*\): {message}"):
        declare("a.B", "doc", inputs={"x": attribute}, registry=Registry())


def test_dynamic_names_follow_their_template():
    outputs = {"output{n}": Attribute("execution", "one of many")}
    made = declare("a.B", "doc", outputs={}, registry=Registry())
    made = NodeType("a.C", dynamic_outputs=outputs, dynamic_inputs={"branch{x}": Attribute("token", "case")})
    assert made.find("outputs", "output10") is outputs["output{n}"]
    assert [made.find("outputs", name) for name in ("output", "output01", "outputx", "input1")] == [None] * 4
    assert made.find("inputs", "branchLeft") is not None
    assert made.has_execution


def test_numbered_names_are_in_numeric_order():
    assert names_in_order(["output10", "output9", "output0"]) == ["output0", "output9", "output10"]
    assert names_in_order(["b", "a10", "a9"]) == ["b", "a10", "a9"]


def test_importing_graph_loads_nothing_heavy():
    code = (
        "import sys, graph\n"
        "names = 'numpy', 'mujoco', 'open3d', 'pxr', 'networkx', 'pydantic', 'nodes'\n"
        "heavy = [name for name in names if name in sys.modules]\n"
        "assert not heavy, heavy\n"
        "from graph import Attribute, node_type\n"
        "import graph.node.registry, graph.plan\n"
        "assert callable(node_type)\n"
        "from graph import node_type as again\n"
        "assert again is node_type\n"
        "assert 'numpy' not in sys.modules\n"
        "try:\n    graph.nonsense\nexcept AttributeError as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.stdout.strip() == "module 'graph' has no attribute 'nonsense'"


def test_a_type_is_there_or_known_to_be_absent_but_never_both():
    from nodes.catalog.absent import ABSENT

    assert not [name for name in ABSENT if name in DEFAULT]


def test_every_type_of_the_facts_table_is_there_or_says_why_not():
    import json

    from nodes.catalog.absent import ABSENT

    facts = json.loads((LIBRARY_FACTS / "node_attributes.json").read_text())
    # Compounds are flattened into their graph when it is read.
    assert [name for name in facts if name not in DEFAULT and name not in ABSENT and name not in MISSING] == [
        "omni.graph.nodes.CompoundSubgraph"
    ]
