"""MCAP files put together record by record, as no writer would."""

from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Chunk, ChunkIndex, DataEnd, Footer, Header, Message, Schema


def written(path, data, *, compression, size=None, starts=(0,), repeats=1):
    """An MCAP file with a chunk of these bytes for each of `starts`, that its index names so many times."""
    parts = RecordBuilder()
    parts.write(b"\x89MCAP0\r\n")
    Header("ros2", "").write(parts)
    places = []
    for _ in starts:
        places.append(parts.count)
        Chunk(compression, data, 0, 0, 0, size if size is not None else len(data)).write(parts)
        length = parts.count - places[-1]
    DataEnd(0).write(parts)
    start = parts.count
    Schema(data=b"", encoding="ros2msg", id=1, name="std_msgs/msg/String").write(parts)
    Channel(id=1, message_encoding="cdr", metadata={}, schema_id=1, topic="/a").write(parts)
    for first, place in [*zip(starts, places, strict=True)] * repeats:
        ChunkIndex(length, place, compression, len(data), first, 0, {}, first, len(data)).write(parts)
    Footer(summary_start=start, summary_offset_start=0, summary_crc=0).write(parts)
    path.write_bytes(bytes(parts.end()) + b"\x89MCAP0\r\n")
    return path


def message(size, time_ns=0):
    """The record of a message of so many zeros: 31 bytes and the zeros."""
    parts = RecordBuilder()
    Message(channel_id=1, data=bytes(size), log_time=time_ns, publish_time=time_ns, sequence=0).write(parts)
    return bytes(parts.end())
