"""The stage and the graph say the same after any edit of either."""

from contextlib import contextmanager
from importlib import import_module

import hypothesis.strategies as st
from hypothesis import HealthCheck, example, given, settings

import graph.isaac
from graph.isaac.run import RUN, Run
from graph.isaac.session import begin
from graph.sim import App

GRAPH = "/World/G"
CONSTANT, CONTROLLER = "omni.graph.nodes.ConstantDouble", "isaacsim.robot.wheeled_robots.DifferentialController"
CONSTANTS, CONTROLLERS = ("a", "b", "c"), ("k", "l")
INPUTS = ("linearVelocity", "angularVelocity")

numbers = st.floats(-10, 10, allow_nan=False, width=32)
edits = st.one_of(
    st.tuples(st.just("create"), st.sampled_from(CONSTANTS + CONTROLLERS)),
    st.tuples(st.just("delete"), st.sampled_from(CONSTANTS + CONTROLLERS)),
    st.tuples(st.just("set"), st.sampled_from(CONSTANTS), numbers),
    st.tuples(st.just("connect"), st.sampled_from(CONSTANTS), st.sampled_from(CONTROLLERS), st.sampled_from(INPUTS)),
    st.tuples(st.just("cut"), st.sampled_from(CONSTANTS), st.sampled_from(CONTROLLERS), st.sampled_from(INPUTS)),
)


@contextmanager
def script():
    """An App with an empty graph, as a script has it; gives omni.graph.core and the stage."""
    run = Run(lambda **options: App(**options))
    token = RUN.set(run)
    try:
        with graph.isaac.importable():
            app = begin(run)
            og = import_module("omni.graph.core")
            stage = og.GraphPipelineStage.GRAPH_PIPELINE_STAGE_ONDEMAND  # nothing computes
            og.Controller.edit({"graph_path": GRAPH, "evaluator_name": "push", "pipeline_stage": stage}, {})
            yield og, app
            run.close()
    finally:
        RUN.reset(token)


class Model:
    """What the graph must be: values of constants, and the constant at each input of a controller."""

    def __init__(self):
        self.nodes, self.links = {}, {}

    def allows(self, edit):
        kind, name, *rest = edit
        if kind == "create":
            return name not in self.nodes
        if kind in ("connect", "cut"):
            controller, entry = rest
            fed = self.links.get((controller, entry))
            both = name in self.nodes and controller in self.nodes
            return both and (fed is None if kind == "connect" else fed == name)
        return name in self.nodes

    def apply(self, edit):
        kind, name, *rest = edit
        if kind == "create":
            self.nodes[name] = 0.0
        elif kind == "delete":
            del self.nodes[name]
            self.links = {end: one for end, one in self.links.items() if name not in (one, end[0])}
        elif kind == "set":
            self.nodes[name] = rest[0]
        elif kind == "connect":
            self.links[tuple(rest)] = name
        else:
            del self.links[tuple(rest)]


def by_controller(og, edit):
    kind, name, *rest = edit
    keys = og.Controller.Keys
    commands = {
        "create": lambda: {keys.CREATE_NODES: [(name, CONSTANT if name in CONSTANTS else CONTROLLER)]},
        "delete": lambda: {keys.DELETE_NODES: [name]},
        "set": lambda: {keys.SET_VALUES: [(f"{name}.inputs:value", rest[0])]},
        "connect": lambda: {keys.CONNECT: [(f"{name}.inputs:value", f"{rest[0]}.inputs:{rest[1]}")]},
        "cut": lambda: {keys.DISCONNECT: [(f"{name}.inputs:value", f"{rest[0]}.inputs:{rest[1]}")]},
    }
    og.Controller.edit(GRAPH, commands[kind]())


def by_stage(stage, edit):
    types = import_module("graph.sim.usd").Sdf.ValueTypeNames
    kind, name, *rest = edit
    path = f"{GRAPH}/{name}"
    if kind == "create":
        prim = stage.DefinePrim(path, "OmniGraphNode")
        prim.CreateAttribute("node:type", types.Token).Set(CONSTANT if name in CONSTANTS else CONTROLLER)
        prim.CreateAttribute("node:typeVersion", types.Int).Set(1)
        for entry in ("value",) if name in CONSTANTS else INPUTS:
            prim.CreateAttribute(f"inputs:{entry}", types.Double).Set(0.0)
    elif kind == "delete":
        stage.RemovePrim(path)
        for controller in CONTROLLERS:
            for entry in INPUTS:
                end = stage.GetAttributeAtPath(f"{GRAPH}/{controller}.inputs:{entry}")
                if end:
                    end.SetConnections([one for one in end.GetConnections() if str(one.GetPrimPath()) != path])
    elif kind == "set":
        stage.GetAttributeAtPath(f"{path}.inputs:value").Set(rest[0])
    else:
        end = stage.GetAttributeAtPath(f"{GRAPH}/{rest[0]}.inputs:{rest[1]}")
        source = f"{path}.inputs:value"
        (end.AddConnection if kind == "connect" else end.RemoveConnection)(source)


def said_by_the_graph(og):
    nodes = {one.get_prim_path().rpartition("/")[2]: one for one in og.Controller.graph(GRAPH).get_nodes()}
    values = {name: og.Controller.get(f"{GRAPH}/{name}.inputs:value") for name in nodes if name in CONSTANTS}
    links = {}
    for name in nodes.keys() & set(CONTROLLERS):
        for entry in INPUTS:
            for source in nodes[name].get_attribute(f"inputs:{entry}").get_upstream_connections():
                links[name, entry] = source.get_node().get_prim_path().rpartition("/")[2]
    return set(nodes), values, links


def said_by_the_stage(stage):
    prims = {one.GetName(): one for one in stage.GetPrimAtPath(GRAPH).GetChildren()}
    values = {name: prims[name].GetAttribute("inputs:value").Get() or 0.0 for name in prims if name in CONSTANTS}
    links = {}
    for name in prims.keys() & set(CONTROLLERS):
        for entry in INPUTS:
            for source in prims[name].GetAttribute(f"inputs:{entry}").GetConnections():
                links[name, entry] = source.GetPrimPath().name
    return set(prims), values, links


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@example([(True, ("create", "a")), (False, ("delete", "a"))])
@given(st.lists(st.tuples(st.booleans(), edits), min_size=1, max_size=12))
def test_stage_and_graph_agree_after_each_edit_of_either(steps):
    with script() as (og, app):
        model, stage = Model(), app.stage
        for on_stage, edit in steps:
            if not model.allows(edit):
                continue
            by_stage(stage, edit) if on_stage else by_controller(og, edit)
            model.apply(edit)
            wanted = (set(model.nodes), {one: model.nodes[one] for one in model.nodes if one in CONSTANTS}, model.links)
            assert said_by_the_graph(og) == wanted
            assert said_by_the_stage(stage) == wanted
        app.update()
        assert [one for one in app.warnings if one.code == "stage-edit-refused"] == []
