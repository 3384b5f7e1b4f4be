"""Serves topics to Foxglove over a WebSocket: the CDR bytes of a recording, with their definitions.

Foxglove's time is simulation time. Clients may publish too, as CDR, if the target says so: the server
asks no client for its origin, so a web page that the user visits while the graph runs could drive the robot.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from typing import Any

from graph.base.errors import UserError, reason_of
from graph.recording.transports.targets import Target
from graph.recording.transports.transport import NotSentError, Outgoing
from graph.sim.messages.bus import Topic, topic_name
from graph.sim.messages.ros_types import definition

MOST_NAME = 1000
"""Characters of a topic that are kept."""
BACKLOG = 64
"""Most messages that the server keeps for one client; for a client that is slower it drops the oldest."""
MOST_CHANNELS = 1000
"""Channels that clients may announce in all; beyond, the oldest are forgotten."""
_SETTLE_S = 0.2
"""How long the server is left to pass on the last messages, since it does not say when it has."""


def open_transport(target: Target) -> FoxgloveTransport:
    """Serves at the target's host and port. Raises UserError if they cannot be bound."""
    return FoxgloveTransport(target)


class FoxgloveTransport:
    """A WebSocket server with a channel for each topic."""

    def __init__(self, target: Target) -> None:
        import foxglove
        from foxglove.websocket import Capability

        self._library = foxglove
        self._context = foxglove.Context()
        self._channels: dict[str, Any] = {}
        self._latched: dict[str, Outgoing] = {}
        self._receivers: dict[str, tuple[str, Callable[[bytes], None]]] = {}
        self.client_channels: dict[tuple[int, int], str] = {}
        capabilities = [Capability.Time, *([Capability.ClientPublish] if target.control else ())]
        self._now_ns = -1
        self._sent_at = 0.0
        self._slow = _SlowClients()
        try:
            self._server = foxglove.start_server(
                name="TickGraph",
                host=target.host,
                port=target.port,
                capabilities=capabilities,
                supported_encodings=["cdr"],
                server_listener=_Clients(self),
                context=self._context,
                message_backlog_size=BACKLOG,
            )
        except (RuntimeError, ValueError, OverflowError) as error:
            self._slow.close()
            raise UserError(
                f"--live {target}: {reason_of(error)}; name a free port of this machine: --live foxglove:PORT"
            ) from None
        host = f"[{target.host}]" if ":" in target.host else target.host
        self.place = f"ws://{host}:{self._server.port}"

    def advertise(self, topic: Topic) -> None:
        """Opens the topic's channel."""
        schema = self._library.Schema(
            name=topic.type_name, encoding="ros2msg", data=definition(topic.type_name).encode()
        )
        self._channels[topic.name] = self._library.Channel(
            topic.name, message_encoding="cdr", schema=schema, context=self._context
        )

    def matched(self, topic: str) -> bool:
        """Whether a client has subscribed."""
        channel = self._channels.get(topic)
        return channel is None or channel.has_sinks()

    def send(self, message: Outgoing) -> None:
        """Passes the message to the server, and the time to its clients."""
        channel = self._channels.get(message.topic)
        if channel is None:
            raise NotSentError("its channel could not be opened")
        if message.sent_ns != self._now_ns:
            self._now_ns = message.sent_ns
            self._server.broadcast_time(message.sent_ns)
        if message.latched:
            self._latched[message.topic] = message
        channel.log(message.data, log_time=message.sent_ns)
        self._sent_at = time.monotonic()

    def subscribe(self, topic: Topic, receive: Callable[[bytes], None]) -> None:
        """Receives what clients publish on the topic."""
        self._receivers[topic.name] = (topic.type_name, receive)

    def flush(self, seconds: float) -> None:
        """Leaves the server a moment for the last messages."""
        time.sleep(max(0.0, min(seconds, self._sent_at + _SETTLE_S - time.monotonic())))

    def close(self) -> None:
        """Stops the server."""
        self._server.stop()
        self._slow.close()

    def notes(self) -> list[tuple[str, str]]:
        """Whether the server has dropped messages for a slow client."""
        if not self._slow.seen:
            return []
        message = (
            f"a client took messages slower than they came; the server keeps {BACKLOG} for each, and dropped older"
        )
        return [("live-slow-listener", message)]

    def repeat(self, topic: str) -> None:
        """Sends the last message of a latched topic again, for a client that comes late."""
        message, channel = self._latched.get(topic), self._channels.get(topic)
        if message is not None and channel is not None:
            channel.log(message.data, log_time=message.sent_ns)

    def client_advertises(self, client: int, channel: Any) -> None:
        """Notes a channel on which a client will publish."""
        topic = topic_name(channel.topic)
        wanted = self._receivers.get(topic)
        if channel.encoding == "cdr" and (wanted is None or channel.schema_name in ("", wanted[0])):
            self.client_channels[client, channel.id] = topic[:MOST_NAME]
            if len(self.client_channels) > MOST_CHANNELS:  # the server does not say when a client is gone
                del self.client_channels[next(iter(self.client_channels))]

    def client_unadvertises(self, client: int, channel: int) -> None:
        """Forgets a channel."""
        self.client_channels.pop((client, channel), None)

    def client_publishes(self, client: int, channel: int, data: bytes) -> None:
        """Receives a client's message."""
        wanted = self._receivers.get(self.client_channels.get((client, channel), ""))
        if wanted is not None:
            wanted[1](bytes(data))


class _Clients:
    """What the server calls, in a thread of its own."""

    def __init__(self, transport: FoxgloveTransport) -> None:
        self._transport = transport

    def on_subscribe(self, client: Any, channel: Any) -> None:
        self._transport.repeat(channel.topic)

    def on_unsubscribe(self, client: Any, channel: Any) -> None:
        pass

    def on_client_advertise(self, client: Any, channel: Any) -> None:
        self._transport.client_advertises(client.id, channel)

    def on_client_unadvertise(self, client: Any, client_channel_id: int) -> None:
        self._transport.client_unadvertises(client.id, client_channel_id)

    def on_message_data(self, client: Any, client_channel_id: int, data: bytes) -> None:
        self._transport.client_publishes(client.id, client_channel_id, data)


class _SlowClients(logging.Handler):
    """Notes the server's log entry about a client whose outbox is full; keeps the server's log off the terminal."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self.seen = False
        self._log = logging.getLogger("foxglove")
        self._log.addHandler(self)
        self._before = self._log.level, self._log.propagate
        self._log.setLevel(logging.INFO)
        self._log.propagate = False

    def emit(self, record: logging.LogRecord) -> None:
        self.seen = self.seen or "outbox" in record.getMessage()

    def close(self) -> None:
        self._log.removeHandler(self)
        self._log.level, self._log.propagate = self._before
        super().close()
