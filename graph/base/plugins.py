"""Plug-ins: node types, sensors, exports, commands, devices, targets and more: entry points in groups.

TickGraph's own, most of them in wings (`wings/`), are declared in pyproject.toml, as those of any other package. A
clone is read from there, so that it need not be installed, and an installation from its table of entry points.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, TypeVar

from .errors import UserError
from .inputs import start_of
from .records import dataclass

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

LARGEST = 1 << 20
"""Bytes of a package's table of entry points that are looked at."""
OWN = re.compile(r"tickgraph-[^-]+\.(?:dist|egg)-info")
"""The folder of facts on TickGraph itself, whose declarations `graph.base.plugins` reads."""


def entry_points(*groups: str) -> list[list[EntryPoint]]:
    """The entry points of each group, sorted by name and value; without TickGraph's own."""
    wanted = [f"[{group}]".encode() for group in groups]
    if not any(group in table for table in _tables(b"".join(wanted)) for group in wanted):
        return [[] for _ in groups]
    from importlib import metadata

    found = (metadata.entry_points(group=group) for group in groups)
    return [
        sorted((entry for entry in entries if _of_others(entry)), key=lambda entry: (entry.name, entry.value))
        for entries in found
    ]


def _of_others(entry: EntryPoint) -> bool:
    return entry.dist is None or entry.dist.name != "tickgraph"


def _tables(any_group: bytes) -> Iterator[bytes]:
    """The tables of the packages on Python's path; for an archive on it, which may hold one, a table of every group."""
    for folder in dict.fromkeys(sys.path):
        if os.path.isfile(folder):
            yield any_group
            continue
        try:
            names = os.listdir(folder or os.curdir)
        except OSError:
            continue
        for name in names:
            if name.endswith((".dist-info", ".egg-info")) and not OWN.fullmatch(name):
                try:
                    yield start_of(os.path.join(folder, name, "entry_points.txt"), LARGEST)
                except OSError:
                    continue


NODES = "tickgraph.nodes"
"""Modules that register node types at import. Of a wing each type is named by its id, and imported when it is used."""
SENSORS = "tickgraph.sensors"
"""Each a `sensors.sensor_types.SensorType`."""
TRANSPORTS = "tickgraph.transports"
"""Each a `graph.recording.transports.transport.Kind`, by its name in `graph run --live NAME`."""
EXPORTS = "tickgraph.exports"
"""Each a `graph.recording.exporting.Format`, by its name in `graph export --format NAME`."""
COMMANDS = "tickgraph.commands"
"""Each a `graph.cli.commands.Command`, by its name in `graph NAME`."""
BACKENDS = "tickgraph.backends"
"""Each a module that draws the images of cameras, by its name in the knob `camera.backend`."""
DEVICES = "tickgraph.devices"
"""Each a module that computes on devices (`graph.sim.devices.plugin_of`), by their name up to the colon."""

FILES = "tickgraph.files"
"""Each a `graph.files.kinds.FileKind`, by the first key of such files."""
TARGETS = "tickgraph.targets"
"""Each a `graph.cli.targets.Target`, by its name in `graph check --target NAME`."""
MODELS = "tickgraph.models"
"""Each a function that opens the file of a scene's model, as `graph.sim.physics.protocol.ModelScene`."""
ASSETS = "tickgraph.assets"
"""Each a function that makes the `graph.sim.scene.assets.StandIn` of an asset path from `/Isaac/` on, or gives None.

TickGraph's own are named by the folder of the assets.
"""
NAMES = "tickgraph.names"
"""Each a module of names of Isaac Sim that a wing has; `graph/isaac/names.txt` says which module of theirs has them."""
KIT = "tickgraph.kit"
"""`modules`: the `graph.ogn.kit_modules.KitModules` that the code of nodes may import."""
READERS = "tickgraph.readers"
"""`usd`: the function that reads graph files of USD; `ogn`: that which registers the types of a package."""
WRITERS = "tickgraph.writers"
"""Each a dict of `sensors.writers.registry.WriterSpec` by the writer's name."""

OGN = "tickgraph.ogn"
"""Packages with `.ogn` files, see `graph.ogn`."""

_KINDS = {
    NODES: "node",
    OGN: "node",
    SENSORS: "sensor",
    TRANSPORTS: "transport",
    EXPORTS: "export",
    COMMANDS: "command",
    BACKENDS: "camera backend",
    DEVICES: "device",
    FILES: "kind of file",
    TARGETS: "target",
    ASSETS: "stand-in",
    NAMES: "module of Isaac Sim",
    KIT: "code",
    READERS: "reader",
    WRITERS: "writers",
    MODELS: "scene format",
}
_GROUP = re.compile(r'\[(?:project\.entry-points\.)?"?(tickgraph\.\w+)"?\]')
_ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
T = TypeVar("T")


class PluginError(UserError):
    """A plug-in that is declared and cannot be used."""


@dataclass(frozen=True, slots=True)
class Plugin:
    """A declaration: a name, and where what it stands for is found, as "module" or "module:object"."""

    group: str
    name: str
    value: str

    def __str__(self) -> str:
        return f"{self.name} ({self.value})"

    @property
    def module(self) -> str:
        """The module that it is loaded from."""
        return self.value.partition(":")[0].strip()

    @property
    def absence(self) -> str:
        """Why a plug-in of a wing cannot be there: its folder is missing. "" where it is there."""
        wing = ".".join(self.module.split(".")[:2])
        if _present(wing):
            return ""
        folder = wing.replace(".", "/")
        todo = f"reinstall tickgraph, or restore the folder {folder}"
        return f"it comes with the wing {wing}, which is not installed; {todo}"

    def load(self) -> Any:
        """What it stands for. Raises whatever its package raises."""
        module = import_module(self.module)
        place = self.value.partition(":")[2].strip()
        return getattr(module, place) if place else module


def shipped(group: str) -> Mapping[str, Plugin]:
    """The plug-ins of a group that TickGraph itself declares, sorted by name; no other package is looked at."""
    return {name: Plugin(group, name, value) for name, value in sorted(_declared().get(group, {}).items())}


def of_others(*groups: str) -> list[list[Plugin]]:
    """The plug-ins of each group that other packages declare, sorted by name."""
    found = zip(groups, entry_points(*groups), strict=True)
    return [[Plugin(group, entry.name, entry.value) for entry in entries] for group, entries in found]


def names(group: str) -> list[str]:
    """All names of a group, our own first."""
    return list(dict.fromkeys([*shipped(group), *(plugin.name for plugin in of_others(group)[0])]))


def load(group: str, name: str, kind: type[T]) -> T | None:
    """What a name of a group stands for, of that class; None if no package declares it.

    Raises PluginError, which names the package and the reason in one line, if it cannot be used.
    """
    plugin = shipped(group).get(name)
    if plugin and plugin.absence:
        raise PluginError(f"the {_KINDS[group]} {name} cannot be used: {plugin.absence}")
    plugin = plugin or next((one for one in of_others(group)[0] if one.name == name), None)
    if plugin is None:
        return None
    try:
        return _of_class(plugin.load(), kind)
    except (Exception, SystemExit) as error:  # a third-party module may raise anything
        raise PluginError(f"the {_KINDS[group]} {plugin} cannot be used: {failure_of(error)}") from error


def required(group: str, name: str, kind: type[T], what: str) -> T:
    """As `load`. Raises UserError for a name that no package declares; what: what the user calls it."""
    found = load(group, name, kind)
    if found is None:
        from .suggest import did_you_mean  # the start of the command does without it

        known = names(group)
        near = did_you_mean(name, known, otherwise=f"there are {', '.join(known)}")
        raise UserError(f"there is no {what} {name!r}{near}")
    return found


def loaded(group: str, kind: type[T]) -> Iterator[tuple[Plugin, T]]:
    """Each plug-in that can be used and what it stands for, those of wings first; what is broken gives a warning."""
    wings = [plugin for plugin in shipped(group).values() if not plugin.absence]
    for plugin in (*wings, *of_others(group)[0]):
        try:
            thing = _of_class(plugin.load(), kind)
        except (Exception, SystemExit) as error:  # a third-party module may raise anything
            leave_out(plugin, error)
        else:
            yield plugin, thing


def _of_class(thing: Any, kind: type[T]) -> T:
    if not isinstance(thing, kind):
        raise TypeError(f"it is of the class {type(thing).__name__}, not a {kind.__name__}")
    return thing


def leave_out(plugin: Plugin, error: BaseException) -> str:
    """Warns that a plug-in is left out; returns the reason."""
    import logging

    reason = failure_of(error)
    logging.getLogger("tickgraph.warnings").warning(
        "warning %s-package: %s: %s; the package is left out, repair or uninstall it",
        *(_KINDS[plugin.group], plugin, reason),
    )
    return reason


def failure_of(error: BaseException) -> str:
    """What a package raised, in one line."""
    reason = " ".join(str(error).split())
    return reason if isinstance(error, UserError) else f"{type(error).__name__}: {reason}"


@cache
def _declared() -> Mapping[str, Mapping[str, str]]:
    """What TickGraph itself declares: value by name by group."""
    found = _groups(os.path.join(_ROOT, "pyproject.toml"))
    if not found:
        folders = [name for name in os.listdir(_ROOT) if OWN.fullmatch(name)]
        for folder in folders:
            found |= _groups(os.path.join(_ROOT, folder, "entry_points.txt"))
    return found


def _groups(file: str) -> dict[str, dict[str, str]]:
    """Our groups of a pyproject.toml or of a table of entry points, which for us differ in quotes; {} without the file.

    Read by lines, because every start of the command needs it: tomllib takes 5 ms, and importlib.metadata 20.
    """
    try:
        lines = start_of(file, LARGEST).decode("utf-8", "replace").splitlines()
    except OSError:
        return {}
    groups: dict[str, dict[str, str]] = {}
    group: dict[str, str] | None = None
    for line in lines:
        if line.startswith("["):
            head = _GROUP.match(line)
            group = groups.setdefault(head[1], {}) if head else None
        elif group is not None and "=" in line and not line.startswith("#"):
            name, _, value = line.partition("=")
            group[name.strip(' "')] = value.strip(' "')
    return groups


@cache
def _present(package: str) -> bool:
    try:
        return find_spec(package) is not None
    except ImportError:
        return False
