"""Finishing a recording whose file could not take all of it, as on a full disk."""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from pathlib import Path
from typing import BinaryIO

from mcap.data_stream import RecordBuilder  # noqa: TID253
from mcap.opcode import Opcode  # noqa: TID253
from mcap.records import (  # noqa: TID253
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    MessageIndex,
    Schema,
    Statistics,
)
from mcap.stream_reader import StreamReader, breakup_chunk  # noqa: TID253

MAGIC = b"\x89MCAP0\r\n"


def finish(path: Path, size: int) -> None:
    """Cuts an MCAP file back to its first `size` bytes, which are whole chunks, and ends it with index and summary.

    What is cut off makes the room for them. Raises OSError if even that does not fit; then the chunks alone are left.
    """
    with path.open("r+b", buffering=0) as file:
        file.truncate(size)
        with path.open("rb") as source:
            ending = _ending(source, size)
        file.seek(size)
        try:
            if file.write(ending) != len(ending):
                raise OSError("no room for the summary")
        except OSError:
            file.truncate(size)
            raise


def _ending(source: BinaryIO, size: int) -> bytes:
    """Everything after the data section of `size` bytes: its end, the summary, the footer."""
    parts = RecordBuilder()
    DataEnd(0).write(parts)
    start = size + parts.count
    summary = _summary(source, size)
    # The checksum covers the summary and the footer up to itself.
    checksum = zlib.crc32(struct.pack("<BQQQ", Opcode.FOOTER, 20, start, 0), zlib.crc32(summary))
    parts.write(summary)
    Footer(summary_start=start, summary_offset_start=0, summary_crc=checksum).write(parts)
    return bytes(parts.end()) + MAGIC  # type: ignore[no-untyped-call]


def _summary(source: BinaryIO, size: int) -> bytes:
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    chunks: list[ChunkIndex] = []
    counts: Counter[int] = Counter()
    records = StreamReader(source, emit_chunks=True).records
    position = len(MAGIC)
    while position < size:
        record = next(records)
        begin, position = position, source.tell()
        if isinstance(record, Chunk):
            chunks.append(_index(record, begin, position))
            for inner in breakup_chunk(record):
                if isinstance(inner, Schema):
                    schemas[inner.id] = inner
                elif isinstance(inner, Channel):
                    channels[inner.id] = inner
        elif isinstance(record, MessageIndex):
            chunks[-1].message_index_offsets[record.channel_id] = begin
            chunks[-1].message_index_length += position - begin
            counts[record.channel_id] += len(record.records)
    statistics = Statistics(
        attachment_count=0,
        channel_count=len(channels),
        channel_message_counts=dict(counts),
        chunk_count=len(chunks),
        message_count=counts.total(),
        message_end_time=max((chunk.message_end_time for chunk in chunks), default=0),
        message_start_time=min((chunk.message_start_time for chunk in chunks), default=0),
        metadata_count=0,
        schema_count=len(schemas),
    )
    summary = RecordBuilder()
    for record in (*schemas.values(), *channels.values(), statistics, *chunks):
        record.write(summary)
    return bytes(summary.end())  # type: ignore[no-untyped-call]


def _index(chunk: Chunk, begin: int, end: int) -> ChunkIndex:
    return ChunkIndex(
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
