"""Reads the records of an MCAP file within limits, without trusting the sizes in the file.

The library's reader unpacks chunks of any size, reads as many bytes as a length says, and holds all chunks that claim
to overlap. Here every read stays inside the file, chunks are unpacked up to `recording.record`, and all waiting chunks
together up to `recording.waiting`.
"""

from __future__ import annotations

import heapq
from collections.abc import Container, Iterator
from dataclasses import dataclass, field, replace
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
from mcap.stream_reader import StreamReader, breakup_chunk, read_magic  # noqa: TID253

from graph.base.limits import check, most

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


def messages(file: BinaryIO, summary: Summary, channels: Container[int]) -> Iterator[Message]:
    """The messages of these channels (ids) by log time; equal times in file order."""
    within = _Within(file)
    order = count()
    indexed = sorted(summary.chunks, key=lambda one: (one.message_start_time, one.chunk_start_offset), reverse=True)
    if not indexed:
        yield from _unindexed(within, channels)
        return
    chunks = [one for one in indexed if _may_hold(one, channels)]
    waiting: list[tuple[int, int, Message]] = []
    held = 0
    while chunks or waiting:
        while chunks and (not waiting or chunks[-1].message_start_time <= waiting[0][0]):
            within.seek(chunks.pop().chunk_start_offset)
            for message in _messages_of(_chunk(within), channels):
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


def _unindexed(within: _Within, channels: Container[int]) -> Iterator[Message]:
    """The records of a file without an index of its chunks, for example one without chunks."""
    found: list[Message] = []
    held = 0
    for record in _records(within, skip_magic=False):
        for message in _messages_of(record, channels):
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


def _messages_of(record: Any, channels: Container[int]) -> Iterator[Message]:
    if isinstance(record, Chunk):
        plain = replace(record, compression="", data=unpacked(record))
        yield from (one for one in breakup_chunk(plain) if isinstance(one, Message) and one.channel_id in channels)
    elif isinstance(record, Message) and record.channel_id in channels:
        yield record


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
