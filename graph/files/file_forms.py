"""The format of graph files as forms; `graph schema` prints them and files are validated against them.

The forms know only the form of the file. Node types and their attributes are checked when the graph is compiled,
inline prims and fidelity values when the scene is built; those checks report the same places.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from typing import Annotated, Any, Literal

from graph.base import exact
from graph.base.forms import Before, Check, Field, Form, Refused
from graph.spec import distributions
from graph.values.types import parse_type

from .connections import PATTERN
from .prim_schema import PRIM
from .text import described, quoted

VERSION = 1
_ATTRIBUTE = re.compile(r"[^\s.\[\],>]+")
HIGHEST_RATE = 10**9
"""Largest rate [Hz]; stamps are whole nanoseconds."""
LEAST_SPAN = 1
"""Shortest part of a recording [s]."""
LONGEST_DURATION = 10**9
"""Longest duration [s], about 32 years."""


def _whole(value: Any) -> Any:
    if type(value) is not int:  # true and 1.0 equal 1 in Python, but are not versions
        raise Refused("must be a whole number")
    return value


def _rate(value: Any) -> Fraction:
    return _positive(value, exact.rate, HIGHEST_RATE, "a rate in Hz such as 60, 29.97 or 30000/1001")


def _duration(value: Any) -> Fraction:
    return _positive(value, exact.duration, LONGEST_DURATION, "a time in seconds such as 5, 0.5 or 1/240")


def _span(value: Any) -> Fraction:
    meaning = f"a time in seconds such as 60, {LEAST_SPAN} or more"
    span = _positive(value, exact.duration, LONGEST_DURATION, meaning)
    if span < LEAST_SPAN:
        raise Refused(f"must be {meaning}, found {described(value)}")
    return span


def _positive(value: Any, convert: Callable[[int | float | str], Fraction], limit: int, meaning: str) -> Fraction:
    """An exact number above 0 and at most `limit`; `meaning` describes it in messages."""
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise Refused(f"must be {meaning}, found {described(value)}")
    try:
        number = convert(value)
    except ValueError:
        raise Refused(f"must be {meaning}, found {described(value)}") from None
    if number <= 0:
        raise Refused(f"must be above 0, found {described(value)}; give {meaning}")
    if number > limit:
        raise Refused(f"must be at most {limit:,}, found {described(value)}; give {meaning}")
    return number


def _identifier(name: str) -> str:
    if not name.isidentifier():
        raise Refused(f"{quoted(name)} cannot be a name; use letters, digits and _, not starting with a digit")
    return name


def _attribute_name(name: str) -> str:
    prefix, _, rest = name.partition(":")
    if prefix not in ("inputs", "outputs", "state") or not rest or not _ATTRIBUTE.fullmatch(rest):
        raise Refused(f"{quoted(name)} cannot be an attribute; write inputs:name, outputs:name or state:name")
    return name


def _attribute_type(value: Any) -> str:
    if not isinstance(value, str):
        raise Refused(f"must be the name of a type such as double or float[3], found {described(value)}")
    try:
        parse_type(value)
    except ValueError as error:
        raise Refused(str(error)) from None
    return value


def _node_name(name: str) -> str:
    """A node name; for a node inside a compound, names joined by `/`."""
    for part in name.split("/"):
        _identifier(part)
    return name


def _prim_path(path: str) -> str:
    if not path.startswith("/"):
        raise Refused(f'{quoted(path)} is not a prim path; it starts with "/", such as /World/{_safe(path)}')
    for part in path[1:].split("/"):
        if not part.isidentifier():
            raise Refused(
                f"{quoted(path)} is not a prim path; {quoted(part)} cannot be a prim name: "
                "use letters, digits and _, not starting with a digit"
            )
    return path


def _safe(text: str) -> str:
    kept = "".join(c for c in text[:40] if c.isalnum() or c in "_/").strip("/")
    return kept or "Name"


def _setting_path(path: str) -> str:
    if not path.startswith("/") or path.endswith("/") or "//" in path or any(c.isspace() for c in path):
        raise Refused(f'{quoted(path)} is not a setting; settings are paths such as "/app/name"')
    return path


def _setting(value: Any) -> Any:
    if isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, list) and all(isinstance(item, (bool, int, float, str)) for item in value):
        return value
    raise Refused(f"must be a number, text, true, false or a list of these, found {described(value)}")


def _knob(value: Any) -> Any:
    if isinstance(value, (bool, int, float, str)):
        return value
    raise Refused(f"must be a number, text, true or false, found {described(value)}")


def _random_target(name: str) -> str:
    owner, _, attribute = name.rpartition(".")
    if not owner or not attribute:
        raise Refused(f"{quoted(name)} names nothing to draw; write /PRIM/PATH.ATTR, /PRIM/PATH.copies or NODE.ATTR")
    return name


def _random_value(value: Any) -> str:
    try:
        return distributions.parse(value).text
    except ValueError as error:
        raise Refused(str(error)) from None


def _empty_if_null(value: Any) -> Any:
    """An entry without a value (`/World/G:` with nothing below it) counts as an empty one."""
    return {} if value is None else value


def _type_or_mapping(value: Any) -> Any:
    if isinstance(value, str):
        return {"type": value}
    if isinstance(value, dict):
        return value
    raise Refused(f"must be a type id or a mapping with a type, found {described(value)}")


_SCALAR_SCHEMA = {"type": ["number", "string", "boolean"]}
_PATH_KEYS: dict[str, Any] = {"propertyNames": {"pattern": "^/"}}
_NUMBER_OR_FRACTION = {
    "anyOf": [{"type": "number", "exclusiveMinimum": 0}, {"type": "string", "pattern": r"^\s*[0-9.eE+]+(/[0-9]+)?\s*$"}]
}
Rate = Annotated[Fraction, Check(_rate, _NUMBER_OR_FRACTION)]
Duration = Annotated[Fraction, Check(_duration, _NUMBER_OR_FRACTION)]
Span = Annotated[Fraction, Check(_span, _NUMBER_OR_FRACTION)]
Identifier = Annotated[str, Check(_identifier, {"type": "string"})]
AttributeName = Annotated[str, Check(_attribute_name, {"type": "string", "pattern": "^(inputs|outputs|state):."})]
AttributeType = Annotated[str, Check(_attribute_type, {"type": "string"})]
NodeName = Annotated[str, Check(_node_name, {"type": "string"})]
PrimPath = Annotated[str, Check(_prim_path, {"type": "string"})]
SettingPath = Annotated[str, Check(_setting_path, {"type": "string"})]
Setting = Annotated[
    Any,
    Check(_setting, {"type": ["number", "string", "boolean", "array"], "items": _SCALAR_SCHEMA}),
]
Knob = Annotated[Any, Check(_knob, _SCALAR_SCHEMA)]
RandomTarget = Annotated[str, Check(_random_target, {"type": "string"})]
RandomValue = Annotated[
    str, Check(_random_value, {"type": "string", "pattern": rf"^\s*({'|'.join(distributions.KINDS)})\s*\(.*\)\s*$"})
]
Connection = Annotated[str, Field(more={"pattern": PATTERN})]


class Node(Form):
    """A node: its type, and the inputs that the file sets."""

    type: str = Field(
        min_length=1,
        description="Type id, such as omni.graph.action.Countdown, or its last part where that is unambiguous.",
    )
    inputs: dict[str, Any] = Field(
        default_factory=dict, description="Values of inputs by name. What is not set has the node type's default."
    )
    state: dict[str, Any] = Field(default_factory=dict, description="Values of state attributes by name.")
    attributes: dict[AttributeName, AttributeType] = Field(
        default_factory=dict,
        description="Attributes that this node has beside those of its type: inputs:x or outputs:x to their types.",
    )


class Variable(Form):
    """A variable of a graph, read and written by its nodes."""

    type: str = Field(min_length=1, description="Attribute type, such as double, int, token or float[3].")
    value: Any = Field(default=None, description="Value at the start; the type's zero if left out.")


InstanceEntry = Annotated[dict[str, Any], Before(_empty_if_null)]
NodeEntry = Annotated[
    Node,
    Before(_type_or_mapping, str | Node),
]


class Graph(Form):
    """A graph of nodes."""

    evaluator: Literal["execution", "push", "dirty_push"] = Field(
        default="execution",
        description="execution: starts at event nodes and follows execution connections. push: every node, every "
        "update. dirty_push: like push, but only what changed.",
    )
    pipeline_stage: Literal["simulation", "pre_render", "post_render", "on_demand"] = Field(
        default="simulation",
        description="When the graph is evaluated: after the physics of an update, before rendering, after a new frame "
        "of a render product, or when something asks for it.",
    )
    evaluation_mode: Literal["automatic", "standalone", "instanced"] = Field(
        default="automatic",
        description="standalone: the graph runs once. instanced: once for each prim of instances. automatic: for each "
        "prim if there are any, else once.",
    )
    lenient: bool = Field(
        default=False,
        description="For a graph from a saved scene; `graph convert` writes it. What cannot be compiled is left out "
        "with a warning, a node whose data is missing warns and does nothing, the rest runs.",
    )
    instances: dict[PrimPath, InstanceEntry] = Field(
        default_factory=dict,
        description="Prims that have this graph, each with the values of variables that are its own.",
        more=_PATH_KEYS,
    )
    variables: dict[Identifier, Variable] = Field(default_factory=dict, description="Variables of the graph by name.")
    nodes: dict[NodeName, NodeEntry] = Field(
        default_factory=dict,
        description="Nodes by name, in order. A name may be a path below the graph, as of a compound's inner nodes.",
    )
    connections: list[Connection] = Field(
        default_factory=list,
        description="Connections in order, such as tick.tick -> wait.execIn, or a.x -> [b.y, c.z].",
    )


GraphEntry = Annotated[Graph, Before(_empty_if_null, Graph | None)]
PrimEntry = Annotated[dict[str, Any], Before(_empty_if_null, {"anyOf": [PRIM, {"type": "null"}]})]


class Scene(Form):
    """The world: a file, prims added to it, or both."""

    usd: str | None = Field(
        default=None,
        description="USD file (.usd, .usda, .usdc, .usdz), relative to the graph file and below its folder.",
    )
    mjcf: str | None = Field(
        default=None, description="MJCF model (.xml), relative to the graph file and below its folder."
    )
    urdf: str | None = Field(
        default=None,
        description="URDF robot (.urdf), relative to the graph file and below its folder; packages by --asset-root.",
    )
    keyframe: str | int | None = Field(
        default=None, description="Keyframe of the MJCF model to start in, by name or number. Left out: none."
    )
    prims: dict[PrimPath, PrimEntry] = Field(
        default_factory=dict,
        description="Prims to author, by path, in order: a type, a transform (translate, orient or rotate, scale), "
        "sizes, physics, and for sensors a config.",
        more=_PATH_KEYS,
    )


class Clock(Form):
    """Rates and behaviour of the clocks."""

    physics_hz: Rate | None = Field(
        default=None, description="Physics steps per simulated second [Hz]; a fraction such as 1000/3 is exact."
    )
    loop_hz: Rate | None = Field(default=None, description="App updates per simulated second [Hz]. Left out: 60.")
    experience: Literal["base", "full", "zero_delay"] = Field(
        default="base",
        description="base: variable stepping. full: fixed time stepping. zero_delay: physics_hz equals loop_hz.",
    )
    parity: Literal["documented", "isaacsim-6.0.1"] = Field(
        default="documented",
        description="Whose behaviour the clocks follow where Isaac Sim and its documentation part ways.",
    )


class Record(Form):
    """What a run writes."""

    mcap: str = Field(default="run.mcap", description="Name of the recording, relative to the output folder.")
    split_size: int | None = Field(
        default=None, description="Bytes at which the recording goes on in the next part, run_0.mcap, run_1.mcap, ..."
    )
    split_seconds: Span | None = Field(
        default=None, description="Seconds of simulation in a part, run_0.mcap, run_1.mcap, ..."
    )
    topics: list[str] = Field(
        default_factory=list,
        description="Topics to record, * for any text, such as /camera/*. Left out: all. To record none: exclude all.",
    )
    exclude: list[str] = Field(default_factory=list, description="Topics to leave out, * for any text.")


class GraphFile(Form):
    """A TickGraph graph file: a scene, clocks, sensors and node graphs as data."""

    tickgraph: Annotated[Literal[1], Before(_whole)] = Field(description="Version of the file format.")
    scene: Scene = Scene()
    clock: Clock = Clock()
    duration: Duration | None = Field(
        default=None, description="Simulated seconds that `graph run` lasts unless told otherwise."
    )
    settings: dict[SettingPath, Setting] = Field(
        default_factory=dict,
        description="Values in the settings tree by path, such as /rtx/hydra/supportMultiTickRate.",
        more=_PATH_KEYS,
    )
    fidelity: dict[str, Knob] = Field(
        default_factory=dict,
        max_length=1000,
        description="What is approximated and how far, by knob, such as lidar.motion: frozen.",
    )
    randomize: dict[RandomTarget, RandomValue] = Field(
        default_factory=dict,
        description="What each seed draws: a prim's key or attribute, its number of copies, or a node's input, to a "
        "distribution, such as /World/Box.translate: uniform([-1, -1, 0], [1, 1, 0]).",
    )
    graphs: dict[PrimPath, GraphEntry] = Field(
        default_factory=dict,
        description="Graphs by their paths on the stage, in order.",
        more=_PATH_KEYS,
    )
    record: Record = Record()
