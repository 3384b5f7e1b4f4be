"""CREATE_PRIMS: prims on the App's stage, checked before anything is made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graph.base.suggest import did_you_mean
from graph.editing.errors import OmniGraphError
from graph.editing.graph_set import GraphSet
from graph.sim.scene.prim_paths import is_path
from graph.values.coercion import coerce, shown
from graph.values.types import TYPES

from .names import node_text


class PrimPlan:
    """The prims that one edit creates."""

    def __init__(self, graphs: GraphSet, graph_path: str) -> None:
        """graph_path: of the graph that the edit makes or changes."""
        self._graphs = graphs
        self._graph_path = graph_path
        self._app = graphs.app
        self._entries: dict[str, tuple[str, dict[str, tuple[Any, Any]]]] = {}

    def add(self, entry: Any) -> None:
        """Adds one entry: path, (path, type), (path, {attribute: (type, value)}) or all three.

        Raises OmniGraphError for an entry that is not valid.
        """
        path, attributes, kind = _parts(entry)
        if self._app is None:
            raise OmniGraphError(f"prim {path} needs a stage; edit the graphs of an App")
        from graph.sim import usd

        if not is_path(path) or not path.startswith("/"):
            raise OmniGraphError(f'"{path}" is not an absolute prim path')
        if path in self._entries or self._app.stage.GetPrimAtPath(path):
            raise OmniGraphError(f"prim {path} already exists")
        if path == self._graph_path or self._graphs.latest(path) is not None or self._graphs.node(path) is not None:
            raise OmniGraphError(f"there is a graph or a node at {path}; give the prim another path")
        self._refuse_while_playing(usd, path, kind)
        self._entries[path] = kind, {name: _typed(usd, path, name, given) for name, given in attributes.items()}

    def _refuse_while_playing(self, usd: Any, path: str, kind: str) -> None:
        """Raises OmniGraphError for prims that physics or sensors cannot add while the App plays."""
        live = self._app.live
        if live is None or live.watch.collecting or self._app.when_playing == "recompile":
            return
        from graph.sim.live.roles import role_of

        scratch = usd.Usd.Stage.CreateInMemory()
        role = role_of(scratch.DefinePrim(path, kind))
        if role:
            raise OmniGraphError(
                f"prim {path} ({role.strip()}) cannot come while the world plays; stop first, edit inside `with "
                'app.edit(when_playing="recompile"):`, or make App(when_playing="recompile")'
            )

    def apply(self) -> list[Any]:
        """Creates the prims, in order."""
        made = []
        for path, (kind, attributes) in self._entries.items():
            prim = self._app.stage.DefinePrim(path, kind)
            for name, (type_, value) in attributes.items():
                prim.CreateAttribute(name, type_).Set(value)
            made.append(prim)
        return made


def _parts(entry: Any) -> tuple[str, Mapping[str, Any], str]:
    if isinstance(entry, (tuple, list)):
        path, *rest = entry
    else:
        path, rest = entry, []
    attributes = next((one for one in rest if isinstance(one, Mapping)), {})
    kind = next((one for one in rest if isinstance(one, str)), "")
    return node_text(path, "prim"), attributes, kind


def _typed(usd: Any, path: str, name: str, given: Any) -> tuple[Any, Any]:
    """The Sdf type of an attribute, and its value converted to that type."""
    if not isinstance(given, (tuple, list)) or len(given) != 2:
        raise OmniGraphError(f"prim {path}: {name}: write (type, value), not {shown(given)}")
    written, value = str(given[0]), given[1]
    type_ = usd.Sdf.ValueTypeNames.Find(_usd_name(written))
    if not type_:
        raise OmniGraphError(f'prim {path}: {name}: no attribute type "{written}"{did_you_mean(written, TYPES)}')
    from graph.usd_files import values

    ours = values.ogn_name(str(type_))
    if ours is None:
        raise OmniGraphError(f"prim {path}: {name}: values of type {written} cannot be given here")
    try:
        return type_, values.to_usd(coerce(TYPES[ours], value), TYPES[ours])
    except ValueError as error:
        raise OmniGraphError(f"prim {path}: {name}: {error}") from None


def _usd_name(written: str) -> str:
    """`point3d` for pointd[3]; a name that is not an OGN type may be a USD type."""
    if written not in TYPES:
        return written
    from graph.usd_files.values import sdf_name

    return str(sdf_name(TYPES[written]))
