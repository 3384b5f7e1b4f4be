"""Shows topics in the Rerun viewer: each message as the archetype of its type, on the time line of simulation time.

The viewer (`rerun`) may be started before the run or during it.
"""

from __future__ import annotations

import os
import socket
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from graph.recording.transports.targets import Target
from graph.recording.transports.transport import Outgoing
from graph.sim.messages.bus import Topic
from graph.sim.messages.ros_types import deserialize

from .rerun_archetypes import archetypes

_RETRY_S = 1.0
"""Time between two looks for a viewer."""
_FLUSH_BYTES = 4_000_000
"""What is logged at most before the viewer must have taken it."""
_FLUSH_S = 1.0
"""A viewer that takes nothing for so long is given up."""


def open_transport(target: Target) -> RerunTransport:
    """Looks for a viewer at the target from the first message on."""
    return RerunTransport(target)


class RerunTransport:
    """A connection to a viewer, made when there is one. Receives nothing."""

    def __init__(self, target: Target) -> None:
        # The library writes its log to the terminal by default.
        os.environ.setdefault("RUST_LOG", "off")
        import rerun

        self._rerun = rerun
        self._address = (target.host, target.port)
        host = f"[{target.host}]" if ":" in target.host else target.host
        self.place = f"rerun+http://{host}:{target.port}/proxy"
        self._stream: Any = None
        self._looked = 0.0
        self._unflushed = 0
        self._latched: dict[str, Outgoing] = {}
        self._unseen = self._shown = self._given_up = 0

    def advertise(self, topic: Topic) -> None:
        """Nothing to announce."""

    def matched(self, topic: str) -> bool:
        """Whether a viewer is connected."""
        return self._connected()

    def send(self, message: Outgoing) -> None:
        """Logs the message; gives a viewer up that has taken nothing for a second."""
        if message.latched:
            self._latched[message.topic] = message
        if not self._connected():
            self._unseen += 1
            return
        self._log(message)
        self._shown += 1
        if self._unflushed > _FLUSH_BYTES:
            self._flush(_FLUSH_S)

    def subscribe(self, topic: Topic, receive: Callable[[bytes], None]) -> None:
        """Nothing comes from a viewer."""

    def flush(self, seconds: float) -> None:
        """Waits until the viewer has everything."""
        if self._stream is not None:
            self._flush(seconds)

    def close(self) -> None:
        """Leaves the viewer, which keeps what it has."""
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.disconnect()

    def notes(self) -> list[tuple[str, str]]:
        """Messages without a viewer, and viewers that were given up."""
        found = []
        if self._given_up:
            message = f"a viewer that took nothing for {_FLUSH_S:g} s was given up ({self._given_up} in all)"
            found.append(("live-slow-listener", message))
        if self._unseen and not self._shown:
            found.append(("live-no-viewer", f"no viewer answered at {self.place}; start one before or during: rerun"))
        return found

    def _connected(self) -> bool:
        if self._stream is not None:
            return True
        if time.monotonic() < self._looked + _RETRY_S:
            return False
        self._looked = time.monotonic()
        try:
            # The library waits for five seconds if nobody listens.
            socket.create_connection(self._address, timeout=_RETRY_S).close()
        except OSError:
            return False
        self._stream = self._rerun.RecordingStream("tickgraph")
        self._stream.connect_grpc(self.place)
        for message in self._latched.values():
            self._log(message)
        return True

    def _log(self, message: Outgoing) -> None:
        self._stream.set_time("sim_time", duration=np.timedelta64(message.sent_ns, "ns"))
        content = deserialize(message.data, message.type_name)
        for path, archetype in archetypes(self._rerun, message.topic, message.type_name, content):
            self._stream.log(path, archetype, static=message.latched)
        self._unflushed += len(message.data)

    def _flush(self, seconds: float) -> None:
        self._unflushed = 0
        try:
            self._stream.flush(timeout_sec=seconds)
        except (RuntimeError, ValueError):
            self._given_up += 1
            stream, self._stream = self._stream, None
            # Leaving a viewer that does not answer takes five seconds.
            threading.Thread(target=stream.disconnect, daemon=True).start()
