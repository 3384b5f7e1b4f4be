"""ROS 2 topics over zenoh, as rmw_zenoh makes them, through Eclipse zenoh's Python package.

The session connects to the router (or any zenoh peer that listens) at the target, and listens on the loopback
interface only; it finds peers through the router. Publisher and subscription match where topic, type and type hash do.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

from graph.base.errors import UserError, reason_of
from graph.recording.transports.targets import LOOPBACK, Target
from graph.recording.transports.transport import NotSentError, Outgoing
from graph.sim.messages.bus import Topic

from .rmw_zenoh import PUBLISHER, SUBSCRIPTION, attachment, gid, node_token, topic_key, topic_token

_BLOCKED_S = 1.0
"""After so long without taking anything a listener is disconnected."""


def open_transport(target: Target) -> ZenohTransport:
    """Opens a session; its router may come later. Raises UserError if zenoh cannot use the target."""
    return ZenohTransport(target)


class ZenohTransport:
    """A session with a publisher or subscriber for each topic, and liveliness tokens that list them in ROS 2."""

    def __init__(self, target: Target) -> None:
        import zenoh
        from zenoh import ext

        self._zenoh, self._ext = zenoh, ext
        host = f"[{target.host}]" if ":" in target.host else target.host
        self.place = f"tcp/{host}:{target.port}"
        self._domain = target.domain
        try:
            self._session = zenoh.open(self._configuration())
        except zenoh.ZError as error:
            raise UserError(f"--live {target}: zenoh cannot connect to {self.place} ({reason_of(error)})") from None
        self._id = str(self._session.zid())
        self._publishers: dict[str, _Publisher] = {}
        self._subscribers: list[Any] = []
        self._tokens = [self._session.liveliness().declare_token(node_token(self._domain, self._id))]
        self._blocked = 0

    def advertise(self, topic: Topic) -> None:
        """Declares the topic's publisher, with a cache of its last messages for late subscribers if it has them."""
        key = _key(self._domain, topic)
        reliable = topic.quality.reliability != "bestEffort"
        control, reliability = self._zenoh.CongestionControl, self._zenoh.Reliability
        options: dict[str, Any] = {
            "congestion_control": control.BLOCK if reliable else control.DROP,
            "reliability": reliability.RELIABLE if reliable else reliability.BEST_EFFORT,
            "allowed_destination": self._zenoh.Locality.REMOTE,
        }
        identity = gid(self._declare_token(PUBLISHER, topic))
        if topic.quality.durability == "transientLocal":
            options["cache"] = self._ext.CacheConfig(max_samples=max(topic.quality.depth, 1))
            options["publisher_detection"] = True
            publisher = self._ext.declare_advanced_publisher(self._session, key, **options)
        else:
            publisher = self._session.declare_publisher(key, **options)
        self._publishers[topic.name] = _Publisher(publisher, identity)

    def matched(self, topic: str) -> bool:
        """Whether a subscriber has matched; for topics with a cache, which late ones read: whether a peer is there."""
        publisher = self._publishers.get(topic)
        status = getattr(publisher and publisher.publisher, "matching_status", None)
        if status is not None:
            return bool(status.matching)
        return bool(self._session.info.routers_zid() or self._session.info.peers_zid())

    def send(self, message: Outgoing) -> None:
        """Sends the message with its attachment; waits a second at most for a listener that takes nothing."""
        publisher = self._publishers.get(message.topic)
        if publisher is None:
            raise NotSentError("its publisher could not be declared")
        began = time.monotonic()
        publisher.put(message.data)
        self._blocked += time.monotonic() - began > _BLOCKED_S / 2

    def subscribe(self, topic: Topic, receive: Callable[[bytes], None]) -> None:
        """Declares the topic's subscriber, which also gets cached messages if the subscription asks for them."""
        key = _key(self._domain, topic)

        def take(sample: Any) -> None:
            receive(sample.payload.to_bytes())

        options: dict[str, Any] = {"allowed_origin": self._zenoh.Locality.REMOTE}
        if topic.quality.durability == "transientLocal":
            depth = max(topic.quality.depth, 1)
            options["history"] = self._ext.HistoryConfig(detect_late_publishers=True, max_samples=depth)
            subscriber = self._ext.declare_advanced_subscriber(self._session, key, take, **options)
        else:
            subscriber = self._session.declare_subscriber(key, take, **options)
        self._subscribers.append(subscriber)
        self._declare_token(SUBSCRIPTION, topic)

    def flush(self, seconds: float) -> None:
        """Nothing to wait for: closing the session sends what it still has."""

    def close(self) -> None:
        """Closes the session; with a listener that takes nothing this lasts ten seconds."""
        self._session.close()

    def notes(self) -> list[tuple[str, str]]:
        """The listeners that were disconnected because they took nothing."""
        if not self._blocked:
            return []
        message = f"a listener that took nothing for {_BLOCKED_S:g} s was disconnected ({self._blocked} in all)"
        return [("live-slow-listener", message)]

    def _declare_token(self, kind: str, topic: Topic) -> str:
        token = topic_token(self._domain, self._id, len(self._tokens), kind, topic)
        self._tokens.append(self._session.liveliness().declare_token(token))
        return token

    def _configuration(self) -> Any:
        """As rmw_zenoh's session: a peer that goes on trying to reach the router, without multicast."""
        settings: dict[str, object] = {
            "mode": "peer",
            "connect/endpoints": [self.place],
            "connect/timeout_ms": -1,
            "connect/exit_on_failure": False,
            "connect/retry": {"period_init_ms": 100, "period_max_ms": 1000, "period_increase_factor": 2},
            "listen/endpoints": [f"tcp/{LOOPBACK}:0"],
            "scouting/multicast/enabled": False,
            "open/return_conditions/connect_scouted": False,
            "timestamping/enabled": True,  # caches order messages by it
            "transport/shared_memory/enabled": False,  # a pool of memory would hide that a listener takes nothing
            "transport/link/tx/queue/congestion_control/block/wait_before_close": round(_BLOCKED_S * 10**6),
        }
        made = self._zenoh.Config()
        for name, value in settings.items():
            made.insert_json5(name, json.dumps(value))
        return made


class _Publisher:
    """A declared publisher, and the numbers of its messages."""

    def __init__(self, publisher: Any, identity: bytes) -> None:
        self.publisher, self._identity = publisher, identity
        self._sequence = 0

    def put(self, cdr: bytes) -> None:
        """Sends a message."""
        self._sequence += 1
        self.publisher.put(cdr, attachment=attachment(self._sequence, time.time_ns(), self._identity))


def _key(domain: int, topic: Topic) -> str:
    try:
        return topic_key(domain, topic)
    except ValueError as error:
        raise NotSentError(str(error)) from None
