"""Real ROS 2 topics over DDS, as rmw_cyclonedds makes them, through Eclipse Cyclone DDS's Python package.

Topic /points is the DDS topic rt/points of type sensor_msgs::msg::dds_::PointCloud2_; samples are little-endian CDR
version 1, padded to 4 bytes; the user data of each endpoint has the type's hash (REP-2016); the quality of service is
the publisher's. The participant uses one interface, loopback unless the target names another: ROS 2 must use it too.
"""

from __future__ import annotations

import ctypes
import math
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from graph.base.errors import UserError, reason_of
from graph.recording.transports.targets import Target
from graph.recording.transports.transport import NotSentError, Outgoing
from graph.sim.messages.bus import Topic
from graph.sim.messages.message import Quality
from graph.sim.messages.ros_types import type_hash

from .dds_types import dds_type

_BLOCKING_NS = 100_000_000
"""How long a write waits for a slow reliable reader."""
_PATIENCE_NS = 500_000_000
"""How long readers get to confirm what fills a history; they are asked ten times a second."""
_CROWDED_BYTES = 1_000_000
"""A full history of so many bytes waits for its readers every time."""
_CHECK_S = 1.0
"""Time between two looks whether the readers of a smaller one are alive."""
_MOST_PARTICIPANTS = 32
"""Participants of a machine that find each other without multicast (the number of rmw_cyclonedds)."""


def open_transport(target: Target) -> DdsTransport:
    """Joins the target's domain. Raises UserError if its interface cannot be used."""
    return DdsTransport(target)


class DdsTransport:
    """A participant with a writer or reader for each topic."""

    def __init__(self, target: Target) -> None:
        from cyclonedds.core import DDSException, Listener
        from cyclonedds.domain import Domain, DomainParticipant
        from cyclonedds.qos import Policy, Qos

        self._writers: dict[str, _Writer] = {}
        self._readers: dict[str, Any] = {}
        self._stall = _Stall()
        self._overwritten: dict[str, tuple[int, int]] = {}
        self._listener = Listener
        _check_interface(target)
        try:
            self._domain = Domain(target.domain, configuration(target.host))
            self._participant = DomainParticipant(target.domain, Qos(Policy.Userdata(b"enclave=/;")))
        except DDSException as error:
            raise UserError(
                f"--live {target}: DDS cannot join domain {target.domain} on {target.host} ({reason_of(error)}); "
                "set ROS_DOMAIN_ID to another domain"
            ) from None
        self.place = f"DDS domain {target.domain} on {target.host}"

    def advertise(self, topic: Topic) -> None:
        """Makes the topic's writer."""
        from cyclonedds.pub import DataWriter

        writer = DataWriter(self._participant, self._topic(topic), qos(topic.quality, topic.type_name))
        self._writers[topic.name] = _Writer(writer, topic.quality, self._stall)

    def matched(self, topic: str) -> bool:
        """Whether a reader has matched."""
        writer = self._writers.get(topic)
        return writer is None or bool(writer.writer.get_matched_subscriptions())

    def send(self, message: Outgoing) -> None:
        """Writes a sample; waits for a slow reliable reader for a tenth of a second."""
        writer = self._writers.get(message.topic)
        if writer is None:
            raise NotSentError("its writer could not be made")
        writer.write(message.data)

    def subscribe(self, topic: Topic, receive: Callable[[bytes], None]) -> None:
        """Makes the topic's reader."""
        from cyclonedds.qos import Policy, Qos
        from cyclonedds.sub import DataReader

        def take(reader: Any) -> None:
            for sample in reader.take(N=1000):
                if isinstance(sample, bytes):  # not the notice that a writer is gone
                    receive(sample)

        wanted = Qos(Policy.IgnoreLocal.Participant, base=qos(topic.quality, topic.type_name))
        listener = self._listener(on_data_available=take)
        self._readers[topic.name] = DataReader(self._participant, self._topic(topic), wanted, listener)

    def flush(self, seconds: float) -> None:
        """Waits until the reliable readers have everything."""
        end = time.monotonic() + seconds
        for writer in self._writers.values():
            writer.confirmed(max(0, round((end - time.monotonic()) * 10**9)))

    def close(self) -> None:
        """Leaves the domain."""
        self._overwritten.update(
            {topic: (writer.overwritten, writer.depth) for topic, writer in self._writers.items() if writer.overwritten}
        )
        # Entities go with their last reference, the participant after those made in it.
        self._readers.clear()
        self._writers.clear()
        self._participant = self._domain = None

    def notes(self) -> list[tuple[str, str]]:
        """What a reader that stalled cannot have got."""
        return [
            (
                "live-slow-listener",
                f"{topic}: a reader stalled, and missed {count:,} of the messages that left the history of {depth}",
            )
            for topic, (count, depth) in self._overwritten.items()
        ]

    def _topic(self, topic: Topic) -> Any:
        from cyclonedds.topic import Topic as DdsTopic

        try:
            return DdsTopic(self._participant, f"rt{topic.name}", dds_type(topic.type_name))
        except ValueError as error:
            raise NotSentError(str(error)) from None


@dataclass(slots=True)
class _Stall:
    """When a writer last waited for a stalled reader; for a second the others do not wait for it too."""

    seen_at: float = -math.inf


class _Writer:
    """A DDS writer of samples that are CDR already; counts those that a reliable reader cannot have got.

    The package's own `write` holds Python's lock while it waits for a slow reader; the C function does not.
    """

    def __init__(self, writer: Any, quality: Quality, stall: _Stall) -> None:
        from cyclonedds.core import DDSException
        from cyclonedds.topic import Sample

        self.writer, self._stall = writer, stall
        self.depth = max(quality.depth, 1)
        self.overwritten = 0
        """Samples written while the history was full of samples that a reader would not confirm."""
        self._keeps_last = quality.reliability != "bestEffort" and quality.history != "keepAll"
        self._unconfirmed = self._unconfirmed_bytes = 0
        self._next_check = 0.0
        self._stalled = False
        self._sample, self._error = Sample, DDSException
        self._dds_write = writer._dll_handle.dds_write
        self._dds_write.restype, self._dds_write.argtypes = ctypes.c_int32, (ctypes.c_int32, ctypes.c_void_p)

    def write(self, cdr: bytes) -> None:
        """Writes a sample. Raises NotSentError if readers are too slow for it."""
        if not self._unconfirmed:
            self._next_check = time.monotonic() + _CHECK_S
        if self._keeps_last and self._unconfirmed >= self.depth:
            # The history is full: readers get a moment, since a run may be faster than they are.
            crowded = self._unconfirmed_bytes > _CROWDED_BYTES and not self._stalled
            if crowded or time.monotonic() > self._next_check:
                known = time.monotonic() < self._stall.seen_at + _CHECK_S
                self._stalled = not self.confirmed(0 if known else _PATIENCE_NS)
                self._next_check = time.monotonic() + _CHECK_S
                if self._stalled and not known:
                    self._stall.seen_at = self._next_check - _CHECK_S
            self.overwritten += self._stalled
        data = cdr + bytes(-len(cdr) % 4)
        address = ctypes.cast(ctypes.c_char_p(data), ctypes.c_void_p)
        result = self._dds_write(self.writer._ref, ctypes.byref(self._sample(address, len(data))))
        if result == self._error.DDS_RETCODE_TIMEOUT:
            raise NotSentError("a reliable reader was too slow")
        if result < 0:
            raise NotSentError(reason_of(self._error(result, "while writing")))
        self._unconfirmed += 1
        self._unconfirmed_bytes += len(data)

    def confirmed(self, nanoseconds: int) -> bool:
        """Waits until all reliable readers have confirmed everything; False if they do not in this time."""
        # The package's `wait_for_acks` raises AttributeError at a timeout (11.0.1).
        done: bool = self.writer._wait_for_acks(self.writer._ref, nanoseconds) == 0
        if done:
            self._unconfirmed = self._unconfirmed_bytes = 0
            self._stalled = False
        return done


def _check_interface(target: Target) -> None:
    """Raises UserError unless the target's host is an interface of this machine, or the address of one."""
    names = [name for _, name in socket.if_nameindex()]
    if target.host in names:
        return
    try:
        family = socket.AF_INET6 if ":" in target.host else socket.AF_INET
        with socket.socket(family, socket.SOCK_DGRAM) as one:
            one.bind((target.host, 0))
    except OSError:
        raise UserError(
            f"--live {target}: {target.host} is not an interface of this machine; name one of {', '.join(names)} or "
            "its address"
        ) from None


def configuration(host: str) -> str:
    """Cyclone DDS's configuration for one interface, by address or name.

    Finds participants by multicast, and by the ports of this machine: loopback interfaces often have no multicast.
    """
    key = "address" if host.replace(".", "").isdigit() or ":" in host else "name"
    general = f'<Interfaces><NetworkInterface {key}="{host}"/></Interfaces>'
    discovery = (
        "<ParticipantIndex>auto</ParticipantIndex>"
        f"<MaxAutoParticipantIndex>{_MOST_PARTICIPANTS}</MaxAutoParticipantIndex>"
        '<Peers><Peer address="localhost"/></Peers>'
    )
    # What was not acknowledged when a run ends has been waited for already.
    internal = "<WriterLingerDuration>0 s</WriterLingerDuration>"
    quiet = "<OutputFile>/dev/null</OutputFile>"
    return (
        f'<CycloneDDS><Domain Id="any"><General>{general}</General><Discovery>{discovery}</Discovery>'
        f"<Internal>{internal}</Internal><Tracing>{quiet}</Tracing></Domain></CycloneDDS>"
    )


def qos(quality: Quality, type_name: str) -> Any:
    """The DDS policies of a ROS 2 quality of service, as rmw_cyclonedds sets them."""
    from cyclonedds.qos import Policy, Qos

    depth = max(quality.depth, 1)
    history = Policy.History.KeepAll if quality.history == "keepAll" else Policy.History.KeepLast(depth)
    policies = [
        history,
        Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False),
        Policy.WriterDataLifecycle(autodispose=False),
        Policy.Userdata(f"typehash={type_hash(type_name)};".encode()),
    ]
    if quality.reliability == "bestEffort":
        policies.append(Policy.Reliability.BestEffort)
    else:
        policies.append(Policy.Reliability.Reliable(max_blocking_time=_BLOCKING_NS))
    if quality.durability == "transientLocal":
        policies += [Policy.Durability.TransientLocal, Policy.DurabilityService(0, history, -1, -1, -1)]
    else:
        policies.append(Policy.Durability.Volatile)
    if quality.deadline_ns:
        policies.append(Policy.Deadline(quality.deadline_ns))
    if quality.lifespan_ns:
        policies.append(Policy.Lifespan(quality.lifespan_ns))
    lease = quality.lease_ns or 2**63 - 1
    manual = quality.liveliness == "manualByTopic"
    policies.append(Policy.Liveliness.ManualByTopic(lease) if manual else Policy.Liveliness.Automatic(lease))
    return Qos(*policies)
