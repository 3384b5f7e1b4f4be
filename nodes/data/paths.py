"""Paths of prims, and targets: joined, compared, searched. These nodes do not read the stage."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

from graph.node import Attribute, Database, KnownTypes, node_type
from graph.sim.scene.prim_paths import is_path
from graph.values.types import TYPES

from .like_inputs import same_type

PATHS = ("token", "token[]")
TARGETS = Attribute("target", "the prims")
CHANGED = Attribute("target", "the prims that come of it")


def _each(db: Database, value: Any, function: Callable[[Any], Any]) -> Any:
    """function(path) for one path, or for each of an array. Fails the node if one is not an absolute path."""
    from graph.sim.usd import Sdf

    def of(text: str) -> str:
        if not is_path(text) or not text.startswith("/"):
            db.fail(f'"{text}" is not an absolute path; begin it with /')
        return str(function(Sdf.Path(text)))

    return of(value) if isinstance(value, str) else [of(one) for one in value]


@node_type(
    "omni.graph.nodes.GetParentPath",
    version=1,
    inputs={"path": Attribute(PATHS, "a path, or an array of them")},
    outputs={"parentPath": Attribute(PATHS, "the paths one level up: of /World/Cube it is /World")},
    resolve=same_type("path", "parentPath"),
)
def get_parent_path(db: Database) -> None:
    """Give the path of a prim's parent, or of the prim that has a property."""
    db.outputs.parentPath = _each(db, db.inputs.path, lambda path: path.GetParentPath())


@node_type(
    "omni.graph.nodes.AppendPath",
    version=1,
    inputs={
        "path": Attribute(PATHS, "a path, or an array of them"),
        "suffix": Attribute("token", "what follows it, such as Cube or Cube.size", default=""),
    },
    outputs={"path": Attribute(PATHS, "both together, such as /World/Cube")},
    resolve=same_type("path", "path"),
)
def append_path(db: Database) -> None:
    """Append a relative path to a path; an empty one leaves it unchanged."""

    suffix = db.inputs.suffix
    if suffix and (not is_path(suffix) or suffix.startswith("/")):
        db.fail(f'input suffix is "{suffix}"; give it a path that does not begin with /, such as Cube')
    db.outputs.path = _each(db, db.inputs.path, lambda path: path.AppendPath(suffix) if suffix else path)


@node_type(
    "omni.graph.nodes.GetRelativePath",
    version=1,
    inputs={
        "anchor": Attribute("token", "the path to start from", default=""),
        "path": Attribute(PATHS, "the path to get to, or an array of them"),
    },
    outputs={"relativePath": Attribute(PATHS, "the way there: from /World to /World/Cube it is Cube")},
    resolve=same_type("path", "relativePath"),
)
def get_relative_path(db: Database) -> None:
    """Give the relative path from one path to another; from a path to itself it is a dot."""
    anchors: list[Any] = []
    _each(db, db.inputs.anchor, anchors.append)
    db.outputs.relativePath = _each(db, db.inputs.path, lambda path: path.MakeRelativePath(anchors[0]))


@node_type(
    "omni.graph.nodes.GetParentPrims",
    version=1,
    inputs={"prims": TARGETS},
    outputs={"parentPrims": Attribute("target", "what each of them is in")},
)
def get_parent_prims(db: Database) -> None:
    """Give the parents of prims, one for each."""
    db.outputs.parentPrims = _each(db, db.inputs.prims, lambda path: path.GetParentPath())


@node_type(
    "omni.graph.nodes.AppendTargets",
    version=1,
    inputs={
        "allowDuplicates": Attribute("bool", "whether a prim may come twice", default=False),
        "input0": TARGETS,
        "input1": TARGETS,
    },
    outputs={"targets": CHANGED},
    dynamic_inputs={"input{n}": TARGETS},
)
def append_targets(db: Database) -> None:
    """Join targets into one."""
    joined = itertools.chain.from_iterable(db.dynamic_inputs("input"))
    db.outputs.targets = list(joined if db.inputs.allowDuplicates else dict.fromkeys(joined))


@node_type(
    "omni.graph.nodes.AppendTargetPaths",
    version=1,
    inputs={
        "input0": Attribute(PATHS, "a relative path, such as Xform/Cube; of an array one for each target"),
        "rootTargets": Attribute("target", "the prims that it goes behind; none means the root of the stage"),
    },
    outputs={"targets": CHANGED},
    dynamic_inputs={"input{n}": Attribute(PATHS, "one more relative path, behind those before")},
)
def append_target_paths(db: Database) -> None:
    """Append relative paths to the paths of prims."""

    rows = [db.inputs.rootTargets or ["/"], *db.dynamic_inputs("input")]
    lists = [[row] if isinstance(row, str) else list(row) for row in rows]
    lengths = {len(one) for one in lists} - {1}
    if len(lengths) > 1:
        db.fail(
            f"there are {' and '.join(map(str, sorted(lengths)))} paths to put together; give it one of each, or "
            "as many"
        )
    [length] = lengths or {1}
    for suffix in itertools.chain.from_iterable(lists[1:]):
        if not is_path(suffix) or suffix.startswith("/"):
            db.fail(f'"{suffix}" is not a relative path; give it one such as Cube')
    stretched = [one * length if len(one) == 1 else one for one in lists]
    db.outputs.targets = ["/".join([row[0].rstrip("/"), *row[1:]]) for row in zip(*stretched, strict=True)]


def _compared(known: KnownTypes) -> Any:
    return {"outputs:result": TYPES["bool[]" if known.value("compareEach") else "bool"]}


@node_type(
    "omni.graph.nodes.CompareTargets",
    version=1,
    inputs={
        "a": TARGETS,
        "b": TARGETS,
        "compareEach": Attribute("bool", "whether to compare them one by one instead of all at once", default=False),
        "operation": Attribute("token", "how to compare", default="==", allowed_tokens=("==", "!=")),
    },
    outputs={"result": Attribute(("bool", "bool[]"), "whether it holds")},
    resolve=_compared,
)
def compare_targets(db: Database) -> None:
    """Give whether targets name the same prims in the same order, or compare them one by one.

    One by one, both must have the same length, or one of them length 1.
    """
    a, b, operation = list(db.inputs.a), list(db.inputs.b), db.inputs.operation
    if operation not in ("==", "!="):
        db.fail(f"input operation is {operation!r}; it must be == or !=")
    wanted = operation == "=="
    if not db.inputs.compareEach:
        db.outputs.result = (a == b) is wanted
        return
    length = max(len(a), len(b))
    a, b = (one * length if len(one) == 1 else one for one in (a, b))
    if len(a) != len(b):
        db.fail(f"inputs a and b name {len(a)} and {len(b)} prims; to compare each they must be as many")
    db.outputs.result = [(one == other) is wanted for one, other in zip(a, b, strict=True)]


@node_type(
    "omni.graph.nodes.FindTarget",
    version=1,
    inputs={"searchTarget": Attribute("target", "the prim to look for"), "targets": TARGETS},
    outputs={"index": Attribute("int", "where it first stands, from 0; -1 where it does not")},
)
def find_target(db: Database) -> None:
    """Find a prim among others."""
    wanted, targets = db.inputs.searchTarget, list(db.inputs.targets)
    if len(wanted) != 1:
        db.lack(f"input searchTarget names {len(wanted)} prims; give it one")
    db.outputs.index = targets.index(wanted[0]) if wanted[0] in targets else -1


@node_type(
    "omni.graph.nodes.GetTargets",
    version=1,
    inputs={
        "count": Attribute("int", "how many to take at most; -1 takes all to the end", default=1),
        "index": Attribute("int", "where to begin, from the end where negative", default=0),
        "targets": TARGETS,
    },
    outputs={"targets": Attribute("target", "the prims taken")},
)
def get_targets(db: Database) -> None:
    """Take some prims out of a target; an index out of range fails."""
    targets, index, count = list(db.inputs.targets), db.inputs.index, db.inputs.count
    if not -len(targets) <= index < len(targets):
        db.lack(f"input index is {index}, but the target names {len(targets)} prims")
    start = index % len(targets)
    db.outputs.targets = targets[start:] if count < 0 else targets[start : start + count]


@node_type(
    "omni.graph.nodes.InsertTargets",
    version=1,
    inputs={
        "index": Attribute("int", "before which prim; one beyond either end means that end", default=0),
        "insertTargets": Attribute("target", "the prims to put in"),
        "targets": TARGETS,
    },
    outputs={"targets": CHANGED},
)
def insert_targets(db: Database) -> None:
    """Insert prims into a target."""
    targets = list(db.inputs.targets)
    index = min(max(db.inputs.index, 0), len(targets))
    db.outputs.targets = [*targets[:index], *db.inputs.insertTargets, *targets[index:]]


@node_type(
    "omni.graph.nodes.ReplaceTargets",
    version=1,
    inputs={
        "replaceTargets": Attribute("target", "the prims to replace"),
        "setTargets": Attribute(
            "target", "what comes in their places, one for each or one for all; none takes them out"
        ),
        "targets": TARGETS,
    },
    outputs={"targets": CHANGED},
)
def replace_targets(db: Database) -> None:
    """Replace prims wherever they are in a target, or remove them."""
    old, new = list(db.inputs.replaceTargets), list(db.inputs.setTargets)
    if new and len(new) not in (1, len(old)):
        db.fail(f"{len(old)} prims cannot be replaced by {len(new)}; give it as many, one, or none")
    news = [[one] for one in (new * len(old) if len(new) == 1 else new)] or [[] for _ in old]
    instead = dict(zip(old, news, strict=True))
    db.outputs.targets = [one for target in db.inputs.targets for one in instead.get(target, [target])]


@node_type(
    "omni.graph.nodes.SetTarget",
    version=1,
    inputs={
        "index": Attribute("int", "position from 0, or from the end where negative", default=0),
        "setTarget": Attribute("target", "the prim to put there"),
        "targets": TARGETS,
    },
    outputs={"targets": CHANGED},
)
def set_target(db: Database) -> None:
    """Replace the prim at an index; an index out of range fails."""
    targets, index, new = list(db.inputs.targets), db.inputs.index, list(db.inputs.setTarget)
    if not -len(targets) <= index < len(targets):
        db.lack(f"input index is {index}, but the target names {len(targets)} prims")
    if len(new) != 1:
        db.lack(f"input setTarget names {len(new)} prims; give it one")
    targets[index] = new[0]
    db.outputs.targets = targets


@node_type(
    "omni.graph.nodes.SelectTargetIf",
    version=1,
    inputs={
        "condition": Attribute(("bool", "bool[]"), "which one to take; an array decides prim by prim"),
        "ifFalse": Attribute("target", "taken where the condition is false"),
        "ifTrue": Attribute("target", "taken where the condition is true"),
    },
    outputs={"result": Attribute("target", "what was taken")},
)
def select_target_if(db: Database) -> None:
    """Select one of two targets, or prim by prim from two targets as long as the condition."""
    condition, sides = db.inputs.condition, (list(db.inputs.ifFalse), list(db.inputs.ifTrue))
    if not hasattr(condition, "__len__"):
        db.outputs.result = sides[bool(condition)]
        return
    if any(len(side) != len(condition) for side in sides):
        db.fail(
            f"input condition has {len(condition)} elements, ifTrue and ifFalse name {len(sides[1])} and "
            f"{len(sides[0])} prims; they must be as many"
        )
    db.outputs.result = [sides[bool(one)][place] for place, one in enumerate(condition)]


@node_type(
    "omni.graph.nodes.GraphTarget",
    version=1,
    inputs={"targetPath": Attribute("token", "kept for files that carry it; unused", default="")},
    outputs={"primPath": Attribute("token", "path of the prim, or of the graph where no prim has it")},
)
def graph_target(db: Database) -> None:
    """Give the path of the prim for which this instance of the graph runs."""
    db.outputs.primPath = db.node.graph.target


@node_type(
    "omni.graph.nodes.GetGraphTargetPrim",
    version=1,
    outputs={"prim": Attribute("target", "the prim, or the graph where no prim has it")},
)
def get_graph_target_prim(db: Database) -> None:
    """Give the prim for which this instance of the graph runs."""
    db.outputs.prim = [db.node.graph.target]
