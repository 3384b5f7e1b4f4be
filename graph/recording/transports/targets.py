"""The texts of `--live`: NAME, NAME:HOST, NAME:PORT or NAME:HOST:PORT; NAME:control... lets clients publish."""

from __future__ import annotations

import importlib
import importlib.util
import os
from collections.abc import Callable
from typing import TYPE_CHECKING

from graph.base.errors import UserError
from graph.base.extras import install_command
from graph.base.plugins import TRANSPORTS, required
from graph.base.records import dataclass

from .transport import Kind

if TYPE_CHECKING:
    from graph.sim.app import App

    from .sink import LiveSink
    from .transport import Transport

CONTROL = "control"
"""Stands behind the name of a transport whose clients only watch otherwise."""
LOOPBACK = "127.0.0.1"
_MOST_DOMAIN = 232
"""The largest domain of ROS 2 whose ports exist (7400 + 250 * domain)."""


@dataclass(frozen=True, slots=True)
class Target:
    """One transport to open. domain: the ROS domain (ROS_DOMAIN_ID). port 0 for transports without one."""

    name: str
    host: str = LOOPBACK
    port: int = 0
    domain: int = 0
    control: bool = False
    """Whether clients may publish, where a target has to say so."""

    @property
    def advice(self) -> str:
        """What the line about the open transport ends with."""
        watched = _kind(self.name).control and not self.control
        return f"; clients only watch, --live {self.name}:{CONTROL} lets them publish" if watched else ""

    def __str__(self) -> str:
        return f"{self.name}:{self.host}" + (f":{self.port}" if self.port else "")


def read_targets(texts: list[str]) -> list[Target]:
    """The targets that a command line names. Raises UserError for a name, host, port or domain that cannot be.

    Also if the library of one is not installed, with the command that installs it.
    """
    targets: list[Target] = []
    for text in texts:
        target = _read(text)
        if any(target.name == other.name for other in targets):
            raise UserError(f"--live {text}: {target.name} is given twice; give each transport once")
        targets.append(target)
    return targets


def connect(app: App, target: Target) -> LiveSink:
    """Sends the App's messages to a target and receives those that its subscribers wait for, until the App is closed.

    Raises UserError if the target cannot be opened.
    """
    from .sink import LiveSink

    module = importlib.import_module(_kind(target.name).module)
    opening: Callable[[Target], Transport] = module.open_transport
    sink = LiveSink(target.name, opening(target), app.bus)

    def deliver() -> None:
        if app.timeline.is_playing():
            sink.deliver()

    # Behind the phase's own work: the play of this update has begun, its physics and graphs have not.
    app.on("timeline_state", deliver)
    app.bus.subscribe(sink)
    return sink


def _read(text: str) -> Target:
    name, colon, place = text.partition(":")
    try:
        kind = _kind(name)
    except UserError as error:
        raise UserError(f"--live {text}: {error}") from error
    control = kind.control and place.partition(":")[0] == CONTROL
    if control:
        _, colon, place = place.partition(":")
    for library in kind.libraries:
        if importlib.util.find_spec(library) is None:
            raise UserError(f"--live {name} needs the package {library}. Run: {install_command(name)}")
    host, port = (LOOPBACK, kind.port or 0) if not colon else _place(text, place, kind.port)
    return Target(name, host, port, _domain() if kind.domain else 0, control)


def _kind(name: str) -> Kind:
    return required(TRANSPORTS, name, Kind, "transport")


def _place(text: str, place: str, usual: int | None) -> tuple[str, int]:
    host, colon, port = place.rpartition(":") if not place.endswith("]") else (place, "", "")
    if not colon and not host:  # one part: all digits are a port
        host, port = ("", place) if usual is not None and place.isdigit() else (place, "")
    host = host.strip("[]") or LOOPBACK
    if any(not (letter.isalnum() or letter in ".-_:%") for letter in host) or (usual is None and port):
        shape = "HOST" if usual is None else "HOST, PORT or HOST:PORT"
        raise UserError(f"--live {text}: {place!r} is not an address; write {text.partition(':')[0]}:{shape}")
    if port and not (port.isdecimal() and 0 < int(port) < 2**16):
        raise UserError(f"--live {text}: {port!r} is not a port; give a number from 1 to 65535")
    return host, int(port) if port else usual or 0


def _domain() -> int:
    text = os.environ.get("ROS_DOMAIN_ID", "") or "0"
    if not (text.isdecimal() and int(text) <= _MOST_DOMAIN):
        raise UserError(f"ROS_DOMAIN_ID {text!r} is not a domain; set a number from 0 to {_MOST_DOMAIN}, or unset it")
    return int(text)
