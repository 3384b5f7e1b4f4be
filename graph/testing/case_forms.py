"""The format of `*.test.yaml` files: tests of graphs and of single nodes, as data.

    tickgraph_tests: 1
    graph: quickstart.yaml            # default: the graph file beside it, quickstart.yaml for quickstart.test.yaml
    cases:
      the clock is published in every update:
        updates: 12
        expect:
          fired: {tick.tick: [0..11]}
          messages: {/clock: 12, /points: [5, 11]}
          warnings: []
      a countdown of ten, every third update:
        node: omni.graph.action.Countdown
        inputs: {duration: 10, period: 3}
        pulses: {execIn: [0]}         # execution inputs, and the updates in which they are triggered
        updates: 12
        expect:
          fired: {tick: [3, 6, 9], finished: [10]}
          outputs: {alpha: 1.0}       # after the last update
          values: {alpha: {0: 0.0, 3: 0.3, 11: 1.0}}
      a robot follows what it is sent:
        graph: robot.yaml
        play:                         # a file, as of graph run --play, or messages
          - {at: 0.5, topic: /cmd_vel, type: geometry_msgs/msg/Twist, message: {linear: {x: 0.2}}}
        updates: 60
        expect:
          fired: {command.execOut: [29]}
      a duration below zero is reported:
        node: Countdown
        inputs: {duration: -1}
        pulses: {execIn: [0]}
        expect:
          error: {message: duration, exit: 1, update: 0}

Keys beside `cases` apply to every case that does not set them; mappings such as `inputs` and `pulses` are joined entry
by entry. `graph` names a file below the test file's folder or is an inline graph (`nodes`, `connections`, ...).
References are `node.attribute` in a graph and `attribute` in the test of a node; lists of updates may hold ranges such
as `0..11`, ends included. Update 0 is the first.

A case runs in an App, without a window, if there is a scene, or with `world: true`; else on a plain clock of
`clock.loop_hz` (60 Hz). A case checks only what it expects, except that a case without `error` must run to its end.
Numbers are converted to the attribute's type and then compared within `tolerance` (default 1e-9), absolute up to 1 and
relative above; whole numbers, text and booleans are compared exactly.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

from graph.base.forms import Before, Field, Form, Wrap
from graph.files.file_forms import Clock, Graph, Knob, Scene, Setting, SettingPath, Variable

from .fields import (
    MOST_UPDATES,
    PATH_KEYS,
    Changes,
    CountOrUpdates,
    Play,
    Playing,
    Texts,
    Tolerance,
    Updates,
    Values,
    empty_if_null,
    name_or_graph,
    text_as,
    whole,
)
from .updates import UpdateList

VERSION = 1
KEY = "tickgraph_tests"
DEFAULT_TOLERANCE = 1e-9


class ExpectedWarning(Form):
    """A warning that must come: its stable code and, if given, further parts of it."""

    code: str = Field(min_length=1, description="Stable code, such as aux-level-too-low.")
    where: str | None = Field(default=None, description="The node or prim it is about.")
    message: str | None = Field(default=None, description="A piece of its message.")
    count: int | None = Field(default=None, ge=1, description="How often it was raised.")


class ExpectedError(Form):
    """The error that must end the run; the other expectations apply to the updates before it."""

    message: Texts | None = Field(default=None, description="A piece of its text, or a list of pieces, all of them.")
    exit: Literal[1, 2] | None = Field(
        default=None, description="Exit code of `graph run`: 1 the run failed, 2 the input is wrong."
    )
    update: int | None = Field(default=None, ge=0, description="The update in which it comes.")


WarningEntry = Annotated[ExpectedWarning, Before(text_as("code"), str | ExpectedWarning)]
ErrorEntry = Annotated[ExpectedError, Before(text_as("message"), str | list[str] | ExpectedError)]
if TYPE_CHECKING:
    GraphEntry = Graph | str
else:  # a union would put its members' names into the places of messages
    GraphEntry = Annotated[Graph, Wrap(name_or_graph, str | Graph)]


class Expect(Form):
    """What must have happened. Only what is named is checked, and errors."""

    fired: dict[str, CountOrUpdates] = Field(
        default_factory=dict,
        description="Execution outputs: exactly the updates in which each was followed (one entry each time), or how "
        "often.",
    )
    outputs: dict[str, Any] = Field(
        default_factory=dict, description="Values after the last update, of outputs or any other attribute."
    )
    values: dict[str, Values] = Field(
        default_factory=dict,
        description="Values by update: a list with the value after each update, or a mapping such as {0: 1, 3..5: 2}.",
    )
    computes: dict[str, Annotated[int, Field(ge=0)]] = Field(
        default_factory=dict, description="How often nodes computed; in the test of a node its name is `node`."
    )
    messages: dict[str, CountOrUpdates] = Field(
        default_factory=dict, description="Messages published, by topic: how many, or exactly in which updates."
    )
    frames: dict[str, CountOrUpdates] = Field(
        default_factory=dict, description="Frames rendered, by sensor prim: how many, or exactly in which updates."
    )
    warnings: list[WarningEntry] | None = Field(
        default=None, description="Exactly these warnings, in any order; [] allows none. Left out: not looked at."
    )
    error: ErrorEntry | None = Field(default=None, description="The error that must end the run.")


class Setup(Form):
    """What runs, and how. Keys beside `cases` apply to every case that does not set them."""

    graph: GraphEntry | None = Field(
        default=None,
        description="The graph file to test, below this file's folder, or a graph written out. Left out: the graph "
        "file beside this one.",
    )
    node: str | None = Field(default=None, min_length=1, description="The node type to test by itself.")
    scene: Scene | None = Field(
        default=None, description="The world of a node, or of a graph written out, as in a graph file."
    )
    clock: Clock | None = Field(default=None, description="Clocks, as in a graph file; rates beat the file's.")
    world: bool | None = Field(default=None, description="Whether to run in an App. Left out: if there is a scene.")
    updates: Annotated[int, Field(ge=0, le=MOST_UPDATES)] | None = Field(
        default=None, description="How many updates to run. Left out: the graph file's duration, else 1."
    )
    seed: int | None = Field(default=None, description="Seed of the world's random streams. Left out: 0.")
    inputs: dict[str, Any] = Field(
        default_factory=dict,
        description="Values of inputs and state attributes from the start; they beat the file's.",
    )
    changes: Changes = Field(
        default_factory=dict,
        description="Values that are set before an update and stay, such as {3: {wait.duration: 2}}.",
    )
    pulses: dict[str, Updates] = Field(
        default_factory=dict,
        description="Execution inputs and the updates in which they are triggered; an update that stands twice "
        "triggers twice.",
    )
    play: Play = Field(
        default_factory=list,
        description="What its subscribers receive: files as of `graph run --play`, below this file's folder, or "
        "messages such as {at: 0.5, topic: /cmd_vel, type: geometry_msgs/msg/Twist, message: {linear: {x: 0.2}}}.",
    )
    playing: Playing = Field(
        default=True,
        description="Whether the timeline plays, or the updates in which it does; it pauses in the others.",
    )
    stops: Updates = Field(
        default=UpdateList(),
        description="The updates before which the simulation is stopped: clocks at 0, all node state as at the start. "
        "It plays again in the same update, if it plays there.",
    )
    closes: bool = Field(
        default=False,
        description="Whether the App closes at the end, for OnClosing; what comes of that stands under the update "
        "after the last.",
    )
    settings: dict[SettingPath, Setting] = Field(
        default_factory=dict, description="Settings of the App; they beat the file's.", more=PATH_KEYS
    )
    fidelity: dict[str, Knob] = Field(default_factory=dict, description="Fidelity knobs; they beat the file's.")
    connect: dict[str, str] = Field(
        default_factory=dict,
        description="For a node: inputs that count as connected, with the types of their sources; their values still "
        "come from inputs and changes.",
    )
    variables: dict[str, Variable] = Field(default_factory=dict, description="For a node: variables of its graph.")
    tolerance: Tolerance = Field(
        default=None,
        description="How far numbers may be off, absolute up to 1 and relative above; or a mapping from attributes "
        "to that. Left out: 1e-9.",
    )


class Case(Setup):
    """One test: what runs, and what must have happened."""

    expect: Expect = Expect()


CaseEntry = Annotated[Case, Before(empty_if_null, Case | None)]


class CaseFile(Setup):
    """A TickGraph test file: tests of graphs and nodes as data, run by `graph test` and by pytest."""

    tickgraph_tests: Annotated[Literal[1], Before(whole)] = Field(description="Version of the format.")
    cases: dict[str, CaseEntry] = Field(min_length=1, description="The tests by name, in order.")
