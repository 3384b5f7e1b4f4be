"""Files meant to harm: refused with a line, or read; in any case soon."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graph.base import limits
from graph.base.errors import UserError
from graph.files import examine
from graph.session.partial_compile import compile_file
from tests.support.costs import within

SECONDS = 2
HEAD = "#usda 1.0\n"


def bomb(arc):
    lines = ['def "A0" {\n}\n']
    for i in range(1, 40):
        inner = "".join(f'def "{name}" ({arc} = </A{i - 1}>) {{\n}}\n' for name in "xy")
        lines.append(f'def "A{i}" {{\n{inner}}}\n')
    return HEAD + "".join(lines)


def rings_of_ports():
    """Twenty compounds, each port fed by both ports of the one before: a million ways from end to end."""
    nodes = []
    for i in range(20):
        before = max(i - 1, 0)
        feeds = f"[</G/c{before}.inputs:a>, </G/c{before}.inputs:b>]"
        nodes.append(
            f'def OmniGraphNode "c{i}" (\nprepend apiSchemas = ["OmniGraphCompoundNodeAPI"]\n) {{\n'
            f'token node:type = "omni.graph.nodes.CompoundSubgraph"\nuint inputs:a.connect = {feeds}\n'
            f'uint inputs:b.connect = {feeds}\ndef OmniGraph "S" {{\n}}\n}}\n'
        )
    reader = 'def OmniGraphNode "n" {\ntoken node:type = "omni.graph.action.Counter"\n'
    reader += "uint inputs:execIn.connect = </G/c19.inputs:a>\n}\n"
    return graph("".join(nodes) + reader)


def graph(nodes):
    return f'{HEAD}def OmniGraph "G" {{\n{nodes}}}\n'


def our_own_data(key, text):
    return f"{HEAD}(\ncustomLayerData = {{\ndictionary tickgraph = {{\n{key}'{text}'\n}}\n}}\n)\n"


HOSTILE = {
    "empty": ("", "1:1: the file is empty"),
    "no USD": ("tickgraph: 1\n", "1:1: this is not USD text; it must start with"),
    "not UTF-8": (HEAD.encode() + b'def "\xff" {\n}\n', "2:6: byte 0xFF is not UTF-8"),
    "deep prims": (HEAD + 'def "A" {\n' * 5000, "is nested deeper than 100 levels"),
    "deep lists": (HEAD + "[" * 60_000, "is nested deeper than 100 levels"),
    "deep metadata": (HEAD + "(" * 60_000, "is nested deeper than 100 levels"),
    "one level too many": (HEAD + "".join(f'def "a{i}" {{\n' for i in range(101)) + "}\n" * 101, "deeper than 100"),
    "no text of USD": (HEAD + ")]>\n", "x.usda:2:1: no USD text goes on like this: ')]>'"),
    "open comment": (HEAD + "/*" * 30_000, "2:"),
    "open texts": (HEAD + '"""a' * 15_000, "2:1:"),
    "references that multiply": (bomb("references"), "its references multiply into "),
    "inherits that multiply": (bomb("inherits"), "its references multiply into "),
    "a file from elsewhere": (HEAD + 'def "A" (references = @/etc/passwd@) {\n}\n', "/etc/passwd lies outside"),
    "a number of 60,000 digits": (HEAD + f'def "A" {{\nint a = 1{"0" * 60_000}\n}}\n', "USD cannot read this file"),
    "a newer USD": ("#usda 9.0\n", "1:1: Cannot parse layer version"),
    "a broken crate": (b"PXR-USDC" + b"\xff" * 1000, "USD cannot read this file"),
    "a prim that references itself": (HEAD + 'def "A" {\ndef "x" (references = </A>) {\n}\n}\n', None),
    "ports fed by ports": (rings_of_ports(), None),
    "a connection to itself": (
        graph(
            'def OmniGraphNode "n" {\ntoken node:type = "omni.graph.nodes.Add"\n'
            "token inputs:a.connect = </G/n.outputs:sum>\n}\n"
        ),
        None,
    ),
    "a path of 20,000 steps": (
        graph(f'def OmniGraphNode "n" {{\ntoken inputs:a.connect = </{"a/" * 20_000}a.outputs:x>\n}}\n'),
        None,
    ),
    "our own data, broken": (
        "#usda 1.0\n(\ncustomLayerData = {\ndictionary tickgraph = {\n"
        'string "scene:json" = "[[["\nstring clock = "x"\n}\n}\n)\n',
        "customLayerData.tickgraph: ",
    ),
    "our own data, nested deeply": (our_own_data('string "scene:json" = ', "[" * 30_000), "scene must be a mapping"),
    "our own comments, nested deeply": (our_own_data("string comments = ", "[" * 30_000), None),
    "our own data, nested 101 levels": (
        our_own_data('string "settings:json" = ', "[" * 101 + "]" * 101),
        "customLayerData.tickgraph: settings must be a mapping",
    ),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_hostile_files_end_soon_with_a_line(tmp_path, case):
    text, message = HOSTILE[case]
    path = tmp_path / "x.usda"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    examine(path)  # whatever is loaded at first use does not count
    with within(SECONDS):
        examined = examine(path)
    if message is None:
        assert examined.problems == ()
    else:
        assert message in str(examined.problems[0])


def test_text_is_read_up_to_the_limit_and_refused_beyond_before_it_is_parsed(tmp_path):
    path = tmp_path / "x.usda"
    path.write_text(HEAD + "#" * (2000 - len(HEAD)))
    with limits.raised({"usd.text": 2000}):
        assert examine(path).problems == ()
    with limits.raised({"usd.text": 1999}):
        [problem] = examine(path).problems
    assert str(problem).startswith(f"{path} is too much USD text; save it as .usdc; the limit is 1,999 bytes; raise it")


def test_prims_are_counted_before_they_are_parsed(tmp_path):
    path = tmp_path / "x.usda"
    path.write_text(HEAD + "".join(f'def "P{number}" {{\n}}\n' for number in range(100)))
    with limits.raised({"usd.prims": 100}):
        assert examine(path).problems == ()
    with limits.raised({"usd.prims": 99}):
        [problem] = examine(path).problems
    assert "has about 100 prims; the limit is 99 prims; raise it with --limit usd.prims=N" in str(problem)


PIECES = st.sampled_from(
    """def OmniGraph "G"
def OmniGraphNode "n"
def OmniGraphNode "c" (prepend apiSchemas = ["OmniGraphCompoundNodeAPI"])
over "n"
class "C"
def "x" (references = </G>)
{
}
(
)
token node:type = "omni.graph.nodes.Add"
token node:type = "omni.graph.action.OnPlaybackTick"
token node:type = "omni.graph.nodes.CompoundSubgraph"
token inputs:a.connect = </G/n.outputs:sum>
double inputs:a = 1
double[] inputs:b = [1, 2]
rel inputs:prim = [</G>, </x>]
quatd inputs:a = (1, 2, 3, 4)
token evaluator:type = "push"
token pipelineStage = "nonsense"
rel omniGraphs = </G>
custom int graph:variable:v = 3
delete uint inputs:execIn.connect = </G/n.outputs:tick>
variantSet "v" = {
"a" {
customData = {
dictionary tickgraph = {
string value = "{}"
string[] connections = ["a -> b"]
double inputs:a.timeSamples = { 0: 1, 1: 2 }
double inputs:a = None""".splitlines()
)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(PIECES, max_size=30), st.booleans())
def test_pieces_of_graphs_in_any_order_give_a_file_or_problems(tmp_path_factory, pieces, balanced):
    text, depth = [], []
    closing = {"{": "}", "(": ")"}
    for piece in pieces:
        if balanced and piece in closing.values() and (not depth or depth[-1] != piece):
            continue
        text.append(piece)
        if piece[-1] in closing:
            depth.append(closing[piece[-1]])
        elif piece in closing.values() and depth:
            depth.pop()
        if balanced and piece.startswith(("def", "over", "class")):
            text.append("{")
            depth.append("}")
    path = tmp_path_factory.mktemp("fuzz") / "x.usda"
    path.write_text(HEAD + "\n".join([*text, *reversed(depth)]) + "\n")
    with within(SECONDS):
        examined = examine(path)
        if examined.spec is not None:
            try:
                compile_file(examined.spec, skip_unknown=True)
            except UserError as error:
                assert error.problems  # noqa: PT017  (either way is fine, a traceback is not)
        else:
            assert examined.problems


def test_a_nul_is_refused_with_its_place(tmp_path):
    file = tmp_path / "a.usda"
    file.write_bytes(b'#usda 1.0\ndef "a\0b" {\n}\n')
    (problem,) = examine(file).problems
    assert str(problem) == f"{file}:2:7: U+0000 cannot stand in a text file; remove it"


def test_allowed_folders_hold_for_what_the_files_own_keys_name(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "m.xml").write_text("<mujoco/>")
    path = tmp_path / "in" / "g.usda"
    keys = 'customLayerData = {\ndictionary tickgraph = {\nstring "scene:json" = \'{"mjcf": "../out/m.xml"}\'\n}\n}\n'
    path.write_text(f"#usda 1.0\n(\n{keys})\n")
    assert "--allow" in str(examine(path).problems[0])
    assert examine(path, allow=[tmp_path / "out"]).problems == ()
