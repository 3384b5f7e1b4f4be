"""Records to MCAP: ROS 2 CDR messages in chunks that are readable as soon as they are written.

A message's log time is the simulation time at which it was published, its publish time the stamp of its header; the
file is in log order. The bytes depend only on the messages: not on the wall clock or the host.
"""

from __future__ import annotations

import os
import shutil
import signal
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import BinaryIO

from mcap.writer import CompressionType, Writer  # noqa: TID253

from graph.base.errors import RunError, UserError
from graph.base.outputs import created, make_folder, replacing
from graph.base.signals import ENDING
from graph.sim.messages.message import Message
from graph.sim.messages.ros_types import definition

from .mcap_source import PROVENANCE

CHUNK_BYTES = 1_000_000
CHUNK_NS = 500_000_000
"""Simulation time after which a chunk is written even if it is not full, so that a kill loses less than a second."""


class LogClock:
    """Log times that never go back: they continue from their last value when simulation time starts again."""

    __slots__ = ("_log_ns", "_shift_ns")

    def __init__(self) -> None:
        self._log_ns = self._shift_ns = 0

    def at(self, sent_ns: int) -> int:
        """The log time [ns] of a message that is sent at this simulation time."""
        self._shift_ns = max(self._shift_ns, self._log_ns - sent_ns)
        self._log_ns = sent_ns + self._shift_ns
        return self._log_ns


_RECORD_OVERHEAD = 31  # opcode, length and the fixed fields of an MCAP Message record


class McapSink:
    """Writes every message it receives to the MCAP file `path`, which it opens at the first one.

    Chunks hold at most 1 MB before compression (a larger message gets its own chunk) and half a second of simulation,
    and are written when they are full; `close` finishes the file. A signal never splits a chunk: it waits until the
    chunk is written. If the file cannot grow, as on a full disk, it is cut back to its whole chunks and finished; every
    later `write` raises. `provenance` becomes metadata of the file; `messages` counts its messages; `notes` has
    warnings after it is closed. chunk_bytes: another limit of a chunk; clock: shared with the parts before.
    """

    def __init__(
        self,
        path: str | Path,
        provenance: Mapping[str, str] | None = None,
        *,
        chunk_bytes: int = CHUNK_BYTES,
        clock: LogClock | None = None,
    ) -> None:
        self.path = Path(path)
        self.messages = 0
        self.given_up = 0
        """Recorded messages that were removed to make space on a full disk."""
        self.notes: list[str] = []
        self._provenance = dict(provenance or {})
        self._file: BinaryIO | None = None
        self._writer: Writer | None = None
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._pending: list[tuple[Message, int, bytes]] = []
        self._pending_bytes = 0
        self._chunk_bytes = chunk_bytes
        self._clock = clock or LogClock()
        self._closed = False
        self._failure = ""

    def advertise(self, topic: str, type_name: str) -> None:
        """Does nothing: a channel is written with its first message."""

    def write(self, message: Message) -> None:
        """Records one message. Raises RunError if the file cannot be written."""
        if self._failure:
            raise RunError(self._failure)
        if self._closed:
            raise RunError(f"{self.path}: the recording is closed; a message on {message.topic} came too late")
        data = message.cdr()
        size = len(data) + _RECORD_OVERHEAD + self._declaration_bytes(message)
        if self._pending and self._pending_bytes + size > self._chunk_bytes:
            self.flush()
        self._pending.append((message, self._clock.at(message.sent_ns), data))
        self._pending_bytes += size
        self.messages += 1
        if self._pending_bytes >= self._chunk_bytes:
            self.flush()

    @property
    def written(self) -> int:
        """Bytes of the file so far."""
        return self._file.tell() if self._file is not None else 0

    def reached(self, now_ns: int) -> None:
        """Writes the pending messages if the first is half a second old, or from before a restart of time."""
        if self._pending and not 0 <= now_ns - self._pending[0][0].sent_ns < CHUNK_NS:
            self.flush()

    def flush(self) -> None:
        """Writes the pending messages as a chunk and passes it to the operating system."""
        if not self._pending:
            return
        with _uninterrupted(), self._file_errors():
            writer = self._open()
            pending, self._pending, self._pending_bytes = self._pending, [], 0
            for message, log_ns, data in pending:
                channel = self._channel(writer, message)
                stamp_ns = max(message.stamp_ns, 0)  # MCAP's times are unsigned; a header keeps one before 0
                writer.add_message(channel, log_ns, data, stamp_ns, message.sequence & 0xFFFFFFFF)
            writer.flush()  # type: ignore[no-untyped-call]

    def close(self) -> None:
        """Finishes the file: index and summary. Calling it twice is harmless."""
        if self._closed:
            return
        with _uninterrupted(), self._file_errors():
            self._closed = True
            try:
                self.flush()
                if self._writer is not None:
                    self._writer.finish()  # type: ignore[no-untyped-call]
                self._restore_deleted()
            finally:
                if self._file is not None:
                    self._file.close()

    def give_up_chunk(self) -> bool:
        """Makes space on a full disk: removes the last chunk of the closed file; False if it is the only one."""
        from .recovery import finish

        if not self._closed or not self.path.is_file():
            return False
        with suppress(OSError, UserError), _uninterrupted():
            left = finish(self.path, drop=1)
            if left.dropped:
                lost, self.messages = self.messages - left.messages, left.messages
                self.given_up += lost
                return True
        return False

    def __enter__(self) -> McapSink:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _open(self) -> Writer:
        if self._writer is None:
            try:
                self._file = created(self.path)
            except OSError as error:
                raise UserError(f"{self.path}: {error.strerror}; name a file that can be written") from None
            # The sink ends chunks itself before they exceed the limit; the writer's own limit is never reached.
            self._writer = Writer(self._file, chunk_size=2**62, compression=CompressionType.LZ4)
            self._writer.start(profile="ros2", library="tickgraph")
            if self._provenance:
                self._writer.add_metadata(PROVENANCE, self._provenance)
            self._file.flush()
        return self._writer

    def _channel(self, writer: Writer, message: Message) -> int:
        known = self._channels.get(message.topic)
        if known is not None:
            return known
        schema = self._schemas.get(message.type_name)
        if schema is None:
            text = definition(message.type_name).encode()
            schema = self._schemas[message.type_name] = writer.register_schema(message.type_name, "ros2msg", text)
        about = {"offered_qos_profiles": message.quality.as_yaml()}
        if message.cadence is not None:
            about |= message.cadence.as_metadata()
        channel = self._channels[message.topic] = writer.register_channel(message.topic, "cdr", schema, about)
        return channel

    def _declaration_bytes(self, message: Message) -> int:
        """The bytes that the topic's channel and its type's schema add to the chunk with this message."""
        if message.topic in self._channels:
            return 0
        schema = 0 if message.type_name in self._schemas else 64 + len(definition(message.type_name))
        sensor = len(message.cadence.sensor) if message.cadence is not None else 0
        return 640 + len(message.topic) + len(message.type_name) + sensor + schema

    def _restore_deleted(self) -> None:
        """Writes the file again if it was deleted during the recording."""
        if self._file is None:
            return
        self._file.flush()
        if os.fstat(self._file.fileno()).st_nlink:
            return
        make_folder(self.path.parent)
        self._file.seek(0)
        with replacing(self.path) as again:
            shutil.copyfileobj(self._file, again, CHUNK_BYTES)
        self.notes.append(f"{self.path}: it was deleted while it was recorded; it is written again, whole")

    @contextmanager
    def _file_errors(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self._closed = True
            kept = self._finish_short()
            self._failure = f"{self.path}: {error.strerror or error}; {kept}"
            raise RunError(self._failure) from error

    def _finish_short(self) -> str:
        """Finishes the whole chunks of the file; returns what is left of it, in words."""
        from .recovery import finish

        self._pending.clear()
        # Closing may fail again to write buffered data; a device such as /dev/full cannot be cut.
        with suppress(OSError):
            if self._file is not None:
                self._file.close()
        try:
            left = finish(self.path)
        except UserError:
            taken, self.messages = self.messages, 0
            return f"nothing of its {taken} messages is kept"
        except OSError:
            return f"it has no index, for which there is no room; make room, then: graph recover {self.path}"
        lost, self.messages = self.messages - left.messages, left.messages
        return f"its first {left.messages} messages are kept, {lost} later ones lost"


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Delays signals that would end the process until the block ends; outside the main thread no signals arrive."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    received: list[int] = []

    def hold(signum: int, frame: FrameType | None) -> None:
        received.append(signum)

    handlers = {number: signal.getsignal(number) for number in ENDING}
    for number, handler in handlers.items():
        if handler not in (signal.SIG_IGN, None):  # None: not set from Python, and not to be set again
            signal.signal(number, hold)
    try:
        yield
    finally:
        for number, handler in handlers.items():
            if handler not in (signal.SIG_IGN, None):
                signal.signal(number, handler)
    if received:
        signal.raise_signal(received[0])
