"""graph convert: whatever a file says, it says in every format, there and back, in the same order."""

from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from graph.cli.convert import convert
from graph.files import examine
from graph.files.document import parsed, simple
from graph.files.writing import yaml_document
from graph.values.equality import same

NAMES = st.sampled_from(["a", "b", "c", "tick", "Node_1", "größe"])
NODE_NAMES = st.one_of(NAMES, st.sampled_from(["sub/b", "sub/a", "a/b", "tick/deep/c"]))
TEXTS = st.one_of(
    st.text(max_size=12),
    st.sampled_from(["on", "1e3", "null", "~", "/World/Box", "a: b", "#x", "'", '"', "0x1F", "é\u2028", "- a", "@x@"]),
)
NUMBERS = st.one_of(
    st.integers(-(2**70), 2**70),
    st.integers(-5, 5),
    st.floats(),
    st.sampled_from([0.1, 1e300, 3.4e38, 1e-45, 123456789.125, 2**64 - 1, 2**63]),
)
SCALARS = st.one_of(st.booleans(), NUMBERS, TEXTS)
VALUES = st.recursive(
    st.one_of(st.none(), SCALARS),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(TEXTS, inner, max_size=3)),
    max_leaves=6,
)
TYPED = st.builds(
    lambda kind, value: {"type": kind, "value": value},
    st.sampled_from(
        [
            *("double", "float[3]", "token", "int[]", "quatd[4]", "matrixd[4]", "nonsense"),
            *("timecode", "timecode[]", "uint64", "uint64[]", "objectId"),
        ]
    ),
    st.one_of(VALUES, st.lists(st.integers(-9, 9), min_size=3, max_size=4)),
)
NODES = {
    "omni.graph.action.OnPlaybackTick": ["tick", "time"],
    "Countdown": ["execIn", "duration", "period", "tick"],
    "omni.graph.nodes.Add": ["a", "b", "sum", "input2"],
    "omni.graph.nodes.ConstantDouble": ["value"],
    "omni.graph.nodes.ConstantTimecode": ["value"],
    "IsaacCreateRenderProduct": ["cameraPrim", "width", "renderProductPath"],
    "my.own.Thing": ["x", "y:z", "state:memory"],
}
KEYS = st.one_of(
    st.sampled_from([name for names in NODES.values() for name in names]),
    st.sampled_from(["state:count", "inputs2", "odd name", "größe"]),
)


@st.composite
def nodes(draw):
    node = {"type": draw(st.sampled_from([*NODES]))}
    inputs = draw(st.dictionaries(KEYS, st.one_of(VALUES, TYPED), max_size=4))
    if inputs:
        node["inputs"] = inputs
    attributes = draw(
        st.dictionaries(
            st.sampled_from(["inputs:extra", "outputs:extra", "inputs:deep:er"]),
            st.sampled_from(["double", "token[]", "execution", "any", "path", "target"]),
            max_size=2,
        )
    )
    if attributes:
        node["attributes"] = attributes
    return node


@st.composite
def graphs(draw):
    made = draw(st.dictionaries(NODE_NAMES, nodes(), max_size=4))
    graph = {"nodes": made}
    graph["evaluator"] = draw(st.sampled_from(["execution", "push", "dirty_push"]))
    graph["pipeline_stage"] = draw(st.sampled_from(["simulation", "pre_render", "post_render", "on_demand"]))
    graph["evaluation_mode"] = draw(st.sampled_from(["automatic", "standalone", "instanced"]))
    graph["instances"] = draw(
        st.dictionaries(
            st.sampled_from(["/World/Box", "/Robot", "/Robot/arm"]),
            st.dictionaries(NAMES, VALUES, max_size=2),
            max_size=2,
        )
    )
    graph["variables"] = draw(
        st.dictionaries(
            NAMES,
            st.builds(
                lambda kind, value: {"type": kind, "value": value},
                st.sampled_from(
                    [
                        *("double", "path", "objectId", "frame[4]", "vectord[3]", "token[]", "doubel", "half"),
                        *("timecode", "timecode[]", "uint64"),
                    ]
                ),
                VALUES,
            ),
            max_size=3,
        )
    )
    ends = [
        f"{name}.{attribute}"
        for name, node in made.items()
        for attribute in NODES[node["type"]]
        if " " not in attribute
    ]
    ends += ["nobody.x", "/World/G.a.outputs:tick", "/World/H/tick.outputs:time", "a.outputs:sum", "b.inputs:value"]
    pairs = draw(st.lists(st.tuples(st.sampled_from(ends), st.sampled_from(ends)), max_size=6, unique=True))
    graph["connections"] = [f"{source} -> {target}" for source, target in pairs]
    return graph


PRIMS = st.dictionaries(
    st.sampled_from(["type", "rigid_body", "attributes", "size"]),
    st.one_of(st.sampled_from(["Cube", True, 2.5]), st.dictionaries(st.sampled_from("cba"), NUMBERS, max_size=3)),
    max_size=4,
)
"""Such as USD dictionaries hold, but for their order."""

ADD = {"type": "omni.graph.nodes.Add"}
SCENE = {"scene": {"prims": {"/World/Thing": {"type": "Cube", "rigid_body": True}, "/World/A": {"type": "Cube"}}}}


def in_graph(**parts):
    """A document of one graph."""
    return {"tickgraph": 1, "graphs": {"/World/G": parts}}


DOCUMENTS = st.fixed_dictionaries(
    {
        "tickgraph": st.just(1),
        "graphs": st.dictionaries(
            st.sampled_from(["/World/G", "/World/H", "/A", "/Robot/deep/G"]), graphs(), max_size=3
        ),
    },
    optional={
        "clock": st.fixed_dictionaries(
            {}, optional={"physics_hz": st.sampled_from([60, 240, "1000/3", 29.97]), "loop_hz": st.integers(1, 500)}
        ),
        "duration": st.sampled_from([5, 0.5, "1/3"]),
        "settings": st.dictionaries(
            st.sampled_from(["/a/b", "/app/x:y", "/rtx/on"]),
            st.one_of(SCALARS, st.lists(SCALARS, max_size=3)),
            max_size=3,
        ),
        "fidelity": st.dictionaries(st.sampled_from(["lidar.motion", "x"]), SCALARS, max_size=2),
        "record": st.just({"mcap": "other.mcap"}),
        "scene": st.fixed_dictionaries(
            {
                "prims": st.dictionaries(
                    st.sampled_from(["/World/Box", "/World/L", "/A/B"]),
                    st.one_of(PRIMS, st.dictionaries(TEXTS, VALUES, max_size=3)),
                    max_size=3,
                )
            }
        ),
    },
)


def said(path):
    """What a file says, as comparable data without places."""
    examined = examine(path)
    assert not examined.problems, examined.problems
    spec = examined.spec
    graphs = [
        {
            "path": graph.path,
            "evaluator": graph.evaluator,
            "stage": graph.pipeline_stage,
            "mode": graph.evaluation_mode,
            "instances": {prim: dict(values) for prim, values in graph.instances.items()},
            "variables": {name: [one.type, one.value] for name, one in graph.variables.items()},
            "nodes": [[n.name, n.type, *inputs_and_state(n.inputs), dict(n.attributes)] for n in graph.nodes],
            "connections": [f"{one.source} -> {one.target}" for one in graph.connections],
        }
        for graph in spec.graphs
    ]
    other = {
        "clock": [str(spec.clock.physics_hz), str(spec.clock.loop_hz), spec.clock.experience],
        "duration": str(spec.duration),
        "settings": dict(spec.settings),
        "fidelity": dict(spec.fidelity),
        "record": spec.record.mcap,
        "prims": {path: dict(prim) for path, prim in spec.scene.prims.items()},
    }
    return {"graphs": graphs, **other}


def inputs_and_state(given):
    """What stands below the two keys of a node, each in order; not between the two."""
    state = {key: value for key, value in given.items() if key.startswith("state:")}
    return {key: value for key, value in given.items() if key not in state}, state


def keys_in_order(path):
    """The keys of a YAML or JSON file and, of the file's other keys than its graphs, all that stands below them."""
    document = simple(parsed(path, path.name)[0])
    return [(key, None if key == "graphs" else value) for key, value in document.items()]


@settings(
    max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
)
@given(DOCUMENTS)
@example(in_graph(nodes={"a": ADD | {"inputs": {"b": 2**64 - 1, "a": {"type": "uint64", "value": 2**64 - 1}}}}))
@example(in_graph(variables={"t": {"type": "timecode", "value": 123456789.125}, "a": {"type": "int", "value": 1}}))
@example(in_graph(nodes={"a": {"type": "omni.graph.nodes.ConstantTimecode", "inputs": {"value": 1 / 3}}}))
@example(in_graph(nodes=dict.fromkeys(("sub/b", "a", "sub/a", "sub"), ADD)))
@example(SCENE | in_graph())
def test_yaml_to_usd_to_json_to_yaml_says_the_same(tmp_path_factory, document):
    folder = tmp_path_factory.mktemp("convert")
    (folder / "a.yaml").write_text(yaml_document(document), encoding="utf8")
    if examine(folder / "a.yaml").problems:
        return  # not a file that says anything
    first, keys = said(folder / "a.yaml"), keys_in_order(folder / "a.yaml")
    for source, target in (("a.yaml", "b.usda"), ("b.usda", "c.json"), ("c.json", "d.usdc"), ("d.usdc", "e.yaml")):
        convert(str(folder / source), str(folder / target))
        assert same(said(folder / target), first), target
    assert same(keys_in_order(folder / "e.yaml"), keys)
