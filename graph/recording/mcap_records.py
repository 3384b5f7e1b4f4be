"""Reads the records of an MCAP file within limits, without trusting the sizes in the file.

The library's reader unpacks chunks of any size, reads as many bytes as a length says, and holds all chunks that claim
to overlap. Here every read stays inside the file, chunks are unpacked up to `recording.record`, and all waiting chunks
together up to `recording.waiting`.
"""

from __future__ import annotations

import heapq
import struct
from collections.abc import Container, Iterator
from dataclasses import dataclass, field
from itertools import count
from typing import Any, BinaryIO

from mcap.data_stream import ReadDataStream  # noqa: TID253
from mcap.opcode import Opcode  # noqa: TID253
from mcap.records import (  # noqa: TID253
    Channel,
    Chunk,
    ChunkIndex,
    Footer,
    Message,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)
from mcap.stream_reader import StreamReader, read_magic  # noqa: TID253

from graph.base.limits import OverLimit, allowed, check, most

PREFIX = struct.Struct("<BQ")
"""The opcode of a record, and the length of its content."""
MESSAGE = struct.Struct("<HIQQ")
"""The start of a message: channel, sequence, log time, publish time."""
_RATIO = 255
"""The most that lz4 packs."""
_FOOTER = 8 + 8 + 4
_LEAST_WINDOW = 2**20
"""Bytes that zstd may look back in any case."""
_OBJECT = 400
"""Memory of a message beside its data, in bytes."""
_ENDING = 1 + 8 + _FOOTER + 8
"""Bytes of the footer's record and the magic at the end."""


@dataclass(slots=True)
class Summary:
    """The summary at the end of a file: schemas and channels by id, chunks, where its metadata is, statistics if
    present: messages by channel id.
    """

    schemas: dict[int, Any] = field(default_factory=dict)
    channels: dict[int, Any] = field(default_factory=dict)
    chunks: list[Any] = field(default_factory=list)
    metadata: list[Any] = field(default_factory=list)
    counts: dict[int, int] = field(default_factory=dict)
    start_ns: int = 0
    """Log time of the first message [ns]."""


class _Within:
    """A file that limits every read to its remaining bytes."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.size = file.seek(0, 2)
        file.seek(0)

    def seek(self, place: int) -> None:
        self._file.seek(min(place, self.size))

    def read(self, length: int) -> bytes:
        return self._file.read(min(length, self.size - self._file.tell()))


def read_summary(file: BinaryIO) -> Summary | None:
    """The summary of a file; None if it was not finished and has no summary.

    Raises ValueError, or what the library raises, for a damaged file.
    """
    within = _Within(file)
    read_magic(ReadDataStream(within))  # type: ignore[arg-type]
    within.seek(max(0, within.size - _ENDING))
    footer = next(_records(within), None)
    if not isinstance(footer, Footer) or footer.summary_start == 0:
        return None
    within.seek(footer.summary_start)
    summary = Summary()
    for record in _records(within):
        if isinstance(record, Schema):
            summary.schemas[record.id] = record
        elif isinstance(record, Channel):
            summary.channels[record.id] = record
        elif isinstance(record, ChunkIndex):
            summary.chunks.append(record)
        elif isinstance(record, Statistics):
            summary.start_ns = record.message_start_time
            summary.counts = dict(record.channel_message_counts)
        elif isinstance(record, MetadataIndex):
            summary.metadata.append(record)
    check_chunks(summary.chunks, within.size)
    return summary


def read_metadata(file: BinaryIO, summary: Summary, name: str) -> dict[str, str]:
    """The first metadata of a name; empty if there is no such metadata. Raises ValueError for a wrong index."""
    for index in summary.metadata:
        if index.name == name:
            check("recording.record", index.length, f"its metadata has {index.length:,} bytes")
            within = _Within(file)
            within.seek(index.offset)
            stream = ReadDataStream(within)  # type: ignore[arg-type]
            if stream.read1() != Opcode.METADATA:
                raise ValueError("its index leads to what is not metadata")
            stream.read8()
            return dict(Metadata.read(stream).metadata)
    return {}


def leading_metadata(file: BinaryIO, name: str) -> dict[str, str]:
    """The metadata of a name before the first chunk; empty if there is no such metadata.

    Raises ValueError, or what the library raises, for a damaged file.
    """
    within = _Within(file)
    for record in _records(within, skip_magic=False):
        if isinstance(record, Metadata) and record.name == name:
            return dict(record.metadata)
        if isinstance(record, Chunk | Message):
            break
    return {}


class OverBudget(OverLimit):  # (named after what happened)
    """A file asks for more work than its size tells."""


class Budget:
    """What one pass over a file of so many bytes may unpack, and how many records it may hold.

    A few bytes can unpack to thousands of times as many; no recording of sensors does, in all of its length.
    """

    __slots__ = ("_bytes", "_records")

    def __init__(self, size: int) -> None:
        self._bytes = most("recording.unpacked") + _RATIO * size
        self._records = most("recording.messages") + size

    def unpacked(self, size: int) -> None:
        """Counts the bytes of an unpacked chunk. Raises OverLimit if they are too many."""
        self._bytes -= size
        if self._bytes < 0:
            raise OverBudget(f"it unpacks to far more than its size; {allowed('recording.unpacked')}")

    def record(self) -> None:
        """Counts a record. Raises OverLimit if there are too many."""
        self._records -= 1
        if self._records < 0:
            raise OverBudget(f"it holds far more messages than its size; {allowed('recording.messages')}")


def check_chunks(chunks: list[ChunkIndex], size: int) -> None:
    """Raises ValueError for an index whose chunks overlap, are there twice or lie outside of the file's bytes."""
    end = 0
    for one in sorted(chunks, key=lambda one: one.chunk_start_offset):
        if one.chunk_start_offset < end or one.chunk_start_offset + one.chunk_length > size or not one.chunk_length:
            raise ValueError("its index names chunks that overlap or are not in it")
        end = one.chunk_start_offset + one.chunk_length


def messages(file: BinaryIO, summary: Summary, channels: Container[int]) -> Iterator[Message]:
    """The messages of these channels (ids) by log time; equal times in file order."""
    within = _Within(file)
    budget = Budget(within.size)
    order = count()
    indexed = sorted(summary.chunks, key=lambda one: (one.message_start_time, one.chunk_start_offset), reverse=True)
    if not indexed:
        yield from _unindexed(within, channels, budget)
        return
    chunks = [one for one in indexed if _may_hold(one, channels)]
    waiting: list[tuple[int, int, Message]] = []
    held = 0
    while chunks or waiting:
        while chunks and (not waiting or chunks[-1].message_start_time <= waiting[0][0]):
            within.seek(chunks.pop().chunk_start_offset)
            for message in _messages_of(_chunk(within), channels, budget):
                held = _held(held + _OBJECT + len(message.data))
                heapq.heappush(waiting, (message.log_time, next(order), message))
        if not waiting:
            continue
        message = heapq.heappop(waiting)[2]
        held -= _OBJECT + len(message.data)
        yield message


def _may_hold(chunk: ChunkIndex, channels: Container[int]) -> bool:
    """Whether a chunk may have messages of these channels; one without message indexes may."""
    held = chunk.message_index_offsets
    return not held or any(number in channels for number in held)


def _unindexed(within: _Within, channels: Container[int], budget: Budget) -> Iterator[Message]:
    """The records of a file without an index of its chunks, for example one without chunks."""
    found: list[Message] = []
    held = 0
    for record in _records(within, skip_magic=False):
        for message in _messages_of(record, channels, budget):
            held = _held(held + _OBJECT + len(message.data))
            found.append(message)
    yield from sorted(found, key=lambda one: one.log_time)


def _records(within: _Within, *, skip_magic: bool = True) -> Iterator[Any]:
    """The records from here to the footer, with chunks unopened."""
    reader = StreamReader(within, skip_magic=skip_magic, emit_chunks=True, record_size_limit=None)  # type: ignore[arg-type]
    return reader.records


def _chunk(within: _Within) -> Chunk:
    stream = ReadDataStream(within)  # type: ignore[arg-type]
    if stream.read1() != Opcode.CHUNK:
        raise ValueError("its index leads to what is not a chunk")
    length = stream.read8()
    check("recording.record", length, f"a chunk of it has {length:,} bytes")
    chunk: Chunk = Chunk.read(stream)
    return chunk


def _messages_of(record: Any, channels: Container[int], budget: Budget) -> Iterator[Message]:
    if isinstance(record, Chunk):
        data = unpacked(record)
        budget.unpacked(len(data))
        yield from _messages_in(data, channels, budget)
    elif isinstance(record, Message) and record.channel_id in channels:
        yield record


def _messages_in(data: bytes, channels: Container[int], budget: Budget) -> Iterator[Message]:
    """The messages of these channels in an unpacked chunk."""
    for opcode, _, body, end in records_in(data, budget):
        if opcode == Opcode.MESSAGE:
            channel, sequence, log_ns, publish_ns = MESSAGE.unpack_from(data, body)
            if channel in channels:
                content = data[body + MESSAGE.size : end]
                yield Message(
                    channel_id=channel, log_time=log_ns, data=content, publish_time=publish_ns, sequence=sequence
                )


def records_in(data: bytes, budget: Budget) -> Iterator[tuple[int, int, int, int]]:
    """Each record of an unpacked chunk: opcode, where it begins, where its content begins, where it ends.

    Raises ValueError, or struct.error, for a record that does not fit into the chunk.
    """
    begin = 0
    while begin < len(data):
        opcode, length = PREFIX.unpack_from(data, begin)
        body = begin + PREFIX.size
        end = body + length
        if end > len(data):
            raise ValueError("a record of it is longer than its chunk")
        budget.record()
        yield opcode, begin, body, end
        begin = end


def unpacked(chunk: Chunk) -> bytes:
    """The bytes of a chunk, at most the limit, whatever size it claims."""
    limit = most("recording.record")
    if not chunk.compression:
        return bytes(chunk.data)
    if chunk.compression == "lz4":
        from lz4.frame import LZ4FrameDecompressor

        unpacking = LZ4FrameDecompressor()
        data: bytes = unpacking.decompress(chunk.data, max_length=limit + 1)
        whole = unpacking.eof
    elif chunk.compression == "zstd":
        data = _unpacked_zstd(chunk.data, limit)
        whole = len(data) == chunk.uncompressed_size
    else:
        raise ValueError(f"its chunks are packed as {chunk.compression!r}; lz4 and zstd can be read")
    check("recording.record", len(data), f"a chunk of it unpacks to more than {limit:,} bytes")
    if not whole:
        raise ValueError("a chunk of it is not whole")
    return data


def _unpacked_zstd(packed: bytes, limit: int) -> bytes:
    from zstandard import ZstdDecompressor

    data = bytearray()
    for part in ZstdDecompressor(max_window_size=max(limit, _LEAST_WINDOW)).read_to_iter(packed):
        data += part
        if len(data) > limit:
            break
    return bytes(data)


def _held(size: int) -> int:
    check("recording.waiting", size, "its chunks overlap in time by more than can wait")
    return size
