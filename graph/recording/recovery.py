"""Finishes an MCAP file that was not finished: after a kill, on a full disk.

The whole chunks are kept. The file is cut after the last chunk that leaves space for the summary; then that chunk's
message indexes and the summary are written, with the bytes that the writer would have written.
"""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

from mcap.data_stream import ReadDataStream, RecordBuilder  # noqa: TID253
from mcap.opcode import Opcode  # noqa: TID253
from mcap.records import (  # noqa: TID253
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from graph.base.errors import UserError
from graph.base.limits import check
from graph.base.outputs import changed

from .mcap_records import MESSAGE, PREFIX, Budget, OverBudget, Summary, records_in, unpacked

MAGIC = b"\x89MCAP0\r\n"
_OUTSIDE = (Opcode.MESSAGE, Opcode.ATTACHMENT)


@dataclass(frozen=True, slots=True)
class Finished:
    """What finishing did to a file.

    whole: it was finished already, and is unchanged. dropped: chunks removed to make space. cut: bytes of an incomplete
    record that were cut off. damaged: chunks and other records that cannot be read; they stay in the file, outside the
    index. end_ns: the log time of the last message.
    """

    messages: int
    chunks: int
    end_ns: int
    whole: bool = False
    dropped: int = 0
    cut: int = 0
    damaged: int = 0


@dataclass(slots=True)
class _Chunk:
    """A whole chunk: its index entry, its end, its declarations, its messages by channel."""

    index: ChunkIndex
    end: int
    declared: list[Schema | Channel]
    counts: Counter[int] = field(default_factory=Counter)


@dataclass(slots=True)
class _Content:
    """The whole records of a file. start: lowest place of its first chunk; cut: bytes of an incomplete record at the
    end.
    """

    start: int = len(MAGIC)
    cut: int = 0
    declared: list[Schema | Channel] = field(default_factory=list)
    """Outside chunks."""
    chunks: list[_Chunk] = field(default_factory=list)
    metadata: list[MetadataIndex] = field(default_factory=list)
    damaged: int = 0
    whole: bool = False

    def result(self, **more: Any) -> Finished:
        count = sum(chunk.counts.total() for chunk in self.chunks)
        last = max((chunk.index.message_end_time for chunk in self.chunks), default=0)
        return Finished(count, len(self.chunks), last, damaged=self.damaged, **more)


def finish(path: Path, *, drop: int = 0) -> Finished:
    """Ends the MCAP file at `path` with index and summary, in place; a finished file stays unchanged.

    drop: how many of its last chunks to remove. If there is no space for the summary more are removed, but never the
    only one. Raises UserError for a file that is not an MCAP recording or has messages outside chunks, OSError if the
    file cannot be written: then its whole chunks remain.
    """
    with changed(path) as file:
        content = _read(file, path)
        if content.whole and not drop:
            return content.result(whole=True)
        dropped = 0
        for _ in range(min(drop, len(content.chunks) - 1)):
            content.chunks.pop()
            dropped += 1
        while True:
            end = content.chunks[-1].end if content.chunks else content.start
            ending = _ending(file, content, end)
            file.truncate(end)
            file.seek(end)
            try:
                if file.write(ending) != len(ending):
                    raise OSError("no room for the summary")
            except OSError:
                file.truncate(end)
                if len(content.chunks) < 2:
                    raise
                content.chunks.pop()
                dropped += 1
                continue
            return content.result(dropped=dropped, cut=content.cut)


def scan(file: BinaryIO, path: Path) -> Summary:
    """The summary of a file that was not finished, over its whole chunks; the file stays as it is.

    Raises UserError as `finish` does.
    """
    file.seek(0)
    content = _read(file, path)
    schemas, channels = _declared(content)
    if content.chunks:  # the message indexes after the last one may be incomplete
        content.chunks[-1].index.message_index_offsets = {}
    return Summary(
        schemas=schemas,
        channels=channels,
        chunks=[chunk.index for chunk in content.chunks],
        metadata=content.metadata,
        counts=dict(_counts(content)),
        start_ns=min((chunk.index.message_start_time for chunk in content.chunks), default=0),
    )


def _read(file: BinaryIO, path: Path) -> _Content:
    size = path.stat().st_size
    if file.read(len(MAGIC)) != MAGIC:
        raise UserError(f"{path}: not an MCAP recording, or nothing of it is left; there is nothing to recover")
    content = _Content(cut=size - len(MAGIC))
    budget = Budget(size)
    for opcode, begin, end in _records(file, size):
        if opcode == Opcode.DATA_END:
            content.whole, content.cut = _is_finished(file, size), 0
            break
        content.cut = size - end
        if opcode in _OUTSIDE:
            raise UserError(f"{path}: it has messages outside chunks; use the tool `mcap recover` for this file")
        if opcode == Opcode.CHUNK:
            chunk = _chunk(file, begin, end, budget)
            if chunk is None:
                content.damaged += 1
            else:
                content.chunks.append(chunk)
        else:
            try:
                _note(file, content, opcode, begin, end)
            except Exception:  # as for chunks
                content.damaged += 1
        if not content.chunks:
            content.start = end
    return content


def _note(file: BinaryIO, content: _Content, opcode: int, begin: int, end: int) -> None:
    """Notes a record other than a chunk. Raises anything if it is damaged."""
    if opcode == Opcode.MESSAGE_INDEX and content.chunks:
        _note_index(file, content.chunks[-1].index, begin, end)
    elif opcode == Opcode.METADATA:
        found = Metadata.read(_body(file, begin, end))
        content.metadata.append(MetadataIndex(offset=begin, length=end - begin, name=found.name))
    elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
        kind = Schema if opcode == Opcode.SCHEMA else Channel
        content.declared.append(kind.read(_body(file, begin, end)))


def _records(file: BinaryIO, size: int) -> Iterator[tuple[int, int, int]]:
    """(opcode, begin, end) of each whole record within the first `size` bytes."""
    begin = len(MAGIC)
    while begin + PREFIX.size <= size:
        file.seek(begin)
        opcode, length = PREFIX.unpack(file.read(PREFIX.size))
        end = begin + PREFIX.size + length
        if opcode == 0 or end > size:  # a file system leaves zeros after a write that did not complete
            return
        yield opcode, begin, end
        begin = end


def _is_finished(file: BinaryIO, size: int) -> bool:
    """Whether the file ends like a finished one."""
    file.seek(max(size - len(MAGIC), len(MAGIC)))
    return file.read() == MAGIC


def _body(file: BinaryIO, begin: int, end: int) -> ReadDataStream:
    file.seek(begin + PREFIX.size)
    data = bytearray()
    while missing := end - begin - PREFIX.size - len(data):
        part = file.read(missing)
        if not part:
            raise EOFError("the file became shorter while it was read")
        data += part
    return ReadDataStream(BytesIO(data))


def _chunk(file: BinaryIO, begin: int, end: int, budget: Budget) -> _Chunk | None:
    """The chunk of a record; None if it cannot be read. Raises OverBudget."""
    counts = Counter[int]()
    declared: list[Schema | Channel] = []
    try:
        chunk, data = _loaded(file, begin, end)
        budget.unpacked(len(data))
        if chunk.uncompressed_crc and chunk.uncompressed_crc != zlib.crc32(data):
            return None
        for opcode, _, body, finish in records_in(data, budget):
            if opcode == Opcode.MESSAGE:
                counts[MESSAGE.unpack_from(data, body)[0]] += 1
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                kind = Schema if opcode == Opcode.SCHEMA else Channel
                declared.append(kind.read(ReadDataStream(BytesIO(data[body:finish]))))
    except OverBudget:
        raise
    except Exception:  # the reader may raise anything for damaged content
        return None
    index = ChunkIndex(
        chunk_length=end - begin,
        chunk_start_offset=begin,
        compression=chunk.compression,
        compressed_size=len(chunk.data),
        message_end_time=chunk.message_end_time,
        message_index_length=0,
        message_index_offsets={},
        message_start_time=chunk.message_start_time,
        uncompressed_size=chunk.uncompressed_size,
    )
    return _Chunk(index, end, declared, counts)


def _loaded(file: BinaryIO, begin: int, end: int) -> tuple[Chunk, bytes]:
    """The chunk of a record, and its bytes unpacked. Raises ValueError for one above `recording.record`."""
    check("recording.record", end - begin, f"a chunk of it has {end - begin:,} bytes")
    chunk: Chunk = Chunk.read(_body(file, begin, end))
    return chunk, unpacked(chunk)


def _note_index(file: BinaryIO, index: ChunkIndex, begin: int, end: int) -> None:
    file.seek(begin + PREFIX.size)
    (channel,) = struct.unpack("<H", file.read(2))
    index.message_index_offsets[channel] = begin
    index.message_index_length += end - begin


def _message_indexes(file: BinaryIO, index: ChunkIndex) -> list[MessageIndex]:
    """The positions of a chunk's messages in it, by channel, in order of first appearance."""
    begin = index.chunk_start_offset
    data = _loaded(file, begin, begin + index.chunk_length)[1]
    found: dict[int, MessageIndex] = {}
    for opcode, offset, body, _ in records_in(data, Budget(len(data))):
        if opcode == Opcode.MESSAGE:
            channel, _, log_ns, _ = MESSAGE.unpack_from(data, body)
            found.setdefault(channel, MessageIndex(channel_id=channel, records=[])).records.append((log_ns, offset))
    return list(found.values())


def _ending(file: BinaryIO, content: _Content, end: int) -> bytes:
    """Everything after the last chunk, which ends at `end`: its message indexes, the summary, the footer."""
    parts = RecordBuilder()
    if content.chunks:
        index = content.chunks[-1].index
        index.message_index_offsets = {}
        for one in _message_indexes(file, index):
            index.message_index_offsets[one.channel_id] = end + parts.count
            one.write(parts)
        index.message_index_length = parts.count
    DataEnd(0).write(parts)
    start = end + parts.count
    summary = _summary(content)
    # The checksum covers the summary and the footer up to itself.
    checksum = zlib.crc32(struct.pack("<BQQQ", Opcode.FOOTER, 20, start, 0), zlib.crc32(summary))
    parts.write(summary)
    Footer(summary_start=start, summary_offset_start=0, summary_crc=checksum).write(parts)
    return bytes(parts.end()) + MAGIC  # type: ignore[no-untyped-call]


def _declared(content: _Content) -> tuple[dict[int, Schema], dict[int, Channel]]:
    declared = [*content.declared, *(one for chunk in content.chunks for one in chunk.declared)]
    schemas = {one.id: one for one in declared if isinstance(one, Schema)}
    return schemas, {one.id: one for one in declared if isinstance(one, Channel)}


def _counts(content: _Content) -> Counter[int]:
    """Messages by channel."""
    return sum((chunk.counts for chunk in content.chunks), Counter())


def _summary(content: _Content) -> bytes:
    schemas, channels = _declared(content)
    chunks = [chunk.index for chunk in content.chunks]
    counts = _counts(content)
    statistics = Statistics(
        attachment_count=0,
        channel_count=len(channels),
        channel_message_counts=dict(counts),
        chunk_count=len(chunks),
        message_count=counts.total(),
        message_end_time=max((chunk.message_end_time for chunk in chunks), default=0),
        message_start_time=min((chunk.message_start_time for chunk in chunks), default=0),
        metadata_count=len(content.metadata),
        schema_count=len(schemas),
    )
    summary = RecordBuilder()
    for record in (*schemas.values(), *channels.values(), statistics, *chunks, *content.metadata):
        record.write(summary)
    return bytes(summary.end())  # type: ignore[no-untyped-call]
