"""Recording to MCAP: ROS 2 CDR messages in chunks that are readable as soon as they are written.

The bytes depend on the messages alone: log time = publish time = simulation time, no wall clock, no host, no version.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import BinaryIO

from mcap.writer import CompressionType, Writer  # noqa: TID253

from graph.base.errors import RunError, UserError

from .message import Message
from .ros_types import definition, serialize

CHUNK_BYTES = 1_000_000
_ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_RECORD_OVERHEAD = 31  # opcode, length and the fixed fields of an MCAP Message record


class McapSink:
    """Writes every message it receives to the MCAP file `path`, which it opens at the first one.

    Chunks hold at most 1 MB before compression (a larger message gets a chunk of its own) and reach the file as they
    fill; `close` finishes the file. A signal never splits a chunk: it is honoured once the chunk is written. A file
    that takes no more, as on a full disk, is cut back to its whole chunks and finished; every later `write` raises.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._file: BinaryIO | None = None
        self._writer: Writer | None = None
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._pending: list[tuple[Message, bytes]] = []
        self._pending_bytes = 0
        self._whole_bytes = 0
        self._closed = False
        self._failure = ""

    def advertise(self, topic: str, type_name: str) -> None:
        """Nothing to do: a channel is written with its first message."""

    def write(self, message: Message) -> None:
        """Records one message. Raises RunError if the file cannot be written."""
        if self._failure:
            raise RunError(self._failure)
        if self._closed:
            raise RunError(f"{self.path}: the recording is closed; a message on {message.topic} came too late")
        data = serialize(message.message, message.type_name)
        size = len(data) + _RECORD_OVERHEAD + self._declaration_bytes(message)
        if self._pending and self._pending_bytes + size > CHUNK_BYTES:
            self.flush()
        self._pending.append((message, data))
        self._pending_bytes += size
        if self._pending_bytes >= CHUNK_BYTES:
            self.flush()

    def flush(self) -> None:
        """Writes what is pending as a chunk and hands it to the operating system."""
        if not self._pending:
            return
        with _uninterrupted(), self._file_errors():
            writer = self._open()
            pending, self._pending, self._pending_bytes = self._pending, [], 0
            for message, data in pending:
                stamp = message.stamp_ns
                writer.add_message(self._channel(writer, message), stamp, data, stamp, message.sequence & 0xFFFFFFFF)
            writer.flush()  # type: ignore[no-untyped-call]
            assert self._file is not None
            self._whole_bytes = self._file.tell()

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
            finally:
                if self._file is not None:
                    self._file.close()

    def __enter__(self) -> McapSink:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _open(self) -> Writer:
        if self._writer is None:
            try:
                self._file = self.path.open("wb")
            except OSError as error:
                raise UserError(f"{self.path}: {error.strerror}; name a file that can be written") from None
            # The sink cuts the chunks itself, before they grow past the limit: the writer's own limit is out of reach.
            self._writer = Writer(self._file, chunk_size=2**62, compression=CompressionType.LZ4)
            self._writer.start(profile="ros2", library="tickgraph")
            self._file.flush()
            self._whole_bytes = self._file.tell()
        return self._writer

    def _channel(self, writer: Writer, message: Message) -> int:
        known = self._channels.get(message.topic)
        if known is not None:
            return known
        schema = self._schemas.get(message.type_name)
        if schema is None:
            text = definition(message.type_name).encode()
            schema = self._schemas[message.type_name] = writer.register_schema(message.type_name, "ros2msg", text)
        channel = self._channels[message.topic] = writer.register_channel(message.topic, "cdr", schema, {})
        return channel

    def _declaration_bytes(self, message: Message) -> int:
        """What the topic's channel and its type's schema add to the chunk if this message brings them."""
        if message.topic in self._channels:
            return 0
        schema = 0 if message.type_name in self._schemas else 64 + len(definition(message.type_name))
        return 64 + len(message.topic) + len(message.type_name) + schema

    @contextmanager
    def _file_errors(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self._closed = True
            self._failure = f"{self.path}: {error.strerror or error}; what was written before is kept"
            self._finish_short()
            raise RunError(self._failure) from error

    def _finish_short(self) -> None:
        from .torn_recording import finish

        self._pending.clear()
        # Closing may once more fail to write what is buffered; a device such as /dev/full cannot be cut.
        with suppress(OSError):
            if self._file is not None:
                self._file.close()
        with suppress(OSError):
            if self._whole_bytes:
                finish(self.path, self._whole_bytes)


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Holds what would end the process back until the block ends; outside the main thread no signals arrive anyway."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    received: list[int] = []

    def hold(signum: int, frame: FrameType | None) -> None:
        received.append(signum)

    handlers = {number: signal.getsignal(number) for number in _ENDING}
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
