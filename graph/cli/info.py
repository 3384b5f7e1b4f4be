"""`graph info`: what a recording holds, and how it compares with what was due."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .arguments import add_limit
from .printing import counted, say_hanging, say_json, tell
from .progress import reading

SHOWN = 3
"""Gaps of a topic in its line."""

if TYPE_CHECKING:
    from graph.recording.regularity import Regularity
    from graph.recording.run_reader import RunReader


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument(
        "run", metavar="RUN", type=Path, help="folder of a run (--out), a .mcap or .db3 file, or a rosbag2 folder"
    )
    parser.add_argument("--json", action="store_true", help="print it as JSON")
    add_limit(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command."""
    from graph.recording.run_reader import open_run

    with open_run(args.run, whole=False) as recording:
        with reading(recording):
            found = measure(recording)
        if args.json:
            say_json(_as_json(recording, found))
            return 0
        for line in _lines(recording, found):
            say_hanging(line)
        for note in recording.notes:
            tell(note)
        for topic, why in recording.skipped.items():
            tell(f"{recording.name}: {topic} is left out: {why}")
    return 0


def measure(recording: RunReader) -> dict[str, Regularity]:
    """The regularity of every topic, from one pass over the recording."""
    from graph.recording.regularity import Regularity

    found = {name: Regularity.of_channel(topic.metadata) for name, topic in recording.recorded.items()}
    for entry in recording.read():
        stamp_ns = entry.time_ns if entry.stamp_ns is None else entry.stamp_ns
        found[entry.topic].add(stamp_ns, entry.time_ns, entry.size)
    return found


def said_of(recording: RunReader, topic: str, one: Regularity) -> str:
    """A line about a topic: what came of what was due, period, gaps, times."""
    return ", ".join(_said(recording, topic, one))


def due(recording: RunReader, topic: str, found: Regularity) -> int | None:
    """The messages that were due: by the report, else the ticks from the first to the last message; None if no schedule
    is known.
    """
    reported = _reported(recording, topic).get("due")
    if isinstance(reported, int):
        return reported
    return found.ticks + found.missing if found.scheduled else None


def _reported(recording: RunReader, topic: str) -> Mapping[str, Any]:
    return _reported_topics(recording).get(topic, {})


def _reported_topics(recording: RunReader) -> Mapping[str, Mapping[str, Any]]:
    """The topics of the report, by name; a report may hold anything."""
    topics = (recording.report or {}).get("topics")
    return {name: one for name, one in topics.items() if isinstance(one, dict)} if isinstance(topics, dict) else {}


def _lines(recording: RunReader, found: Mapping[str, Regularity]) -> Iterator[str]:
    messages = sum(one.messages for one in found.values())
    size = sum(Path(file.name).stat().st_size for file in recording.files)
    source = f" of {recording.provenance['file']}" if "file" in recording.provenance else ""
    files = counted(len(recording.files), "files")
    yield f"{recording.name}: a recording{source}: {messages:,} messages in {files}, {size / 1e6:,.1f} MB"
    for name, one in found.items():
        type_name = recording.recorded[name].type_name
        yield f"{name}: {said_of(recording, name, one)} ({type_name}, {one.size / 1e6:,.3f} MB)"
    for name, topic in _reported_topics(recording).items():
        if name not in found:
            sent = topic.get("messages")
            said = (
                f"not recorded, {sent:,} messages were published" if isinstance(sent, int) and sent else "no messages"
            )
            yield f"{name}: {said} ({topic.get('type')})"


def _said(recording: RunReader, topic: str, one: Regularity) -> Iterator[str]:
    """The parts of a topic's line."""
    expected = due(recording, topic, one)
    published = _reported(recording, topic).get("messages")
    if expected is None and isinstance(published, int) and published > one.messages:
        yield f"{one.messages:,} of {published:,} messages"
    elif expected is None:
        yield counted(one.messages, "messages")
    else:
        yield f"{one.ticks:,} of {expected:,} {'ticks' if one.scheduled else 'updates'}"
    if one.first_ns is None or one.last_ns is None:
        return
    period = one.period_ns
    if period is not None and one.messages > 1:
        yield _period(period, one)
    if expected is not None and one.ticks < expected:
        yield _missing(expected - one.ticks, one)
    elif one.gaps():
        yield _gaps(one)
    if one.repeats:
        yield f"{one.repeats:,} with the stamp of the one before"
    if one.restarts:
        yield f"time starts again {counted(one.restarts, 'times')}"
    if one.wall:
        yield "stamped with wall time"
    yield f"at {_seconds(one.first_ns)}" if one.messages == 1 else f"{_number(one.first_ns)} to {_seconds(one.last_ns)}"


def _period(period: Fraction, one: Regularity) -> str:
    said = f"period {_milliseconds(period)}"
    if one.exact:
        return f"{said} exact"
    if (late := one.late_ns) is not None:
        return f"{said}, stamps {_number_ms(late[0])} to {_milliseconds(late[1])} after the ticks"
    low, high = one.distances_ns or (0, 0)
    return f"{said}, {_number_ms(low)} to {_milliseconds(high)} apart"


def _missing(number: int, one: Regularity) -> str:
    parts = [_gaps(one)] if one.gaps() else []
    outside = number - one.missing
    if outside > 0 and one.scheduled and one.every == 1:
        parts.append(f"{outside:,} before the first or after the last")
    return f"{number:,} missing" + (f" ({'; '.join(parts)})" if parts else "")


def _gaps(one: Regularity) -> str:
    """The longest gaps, by time."""
    gaps = one.gaps()
    listed = ", ".join(f"{_milliseconds(length)} after {_seconds(at)}" for at, length in gaps[:SHOWN])
    return f"gaps: {listed}" + (" and more" if len(gaps) > SHOWN else "")


def _number(nanoseconds: int) -> str:
    whole, rest = divmod(abs(nanoseconds), 10**9)
    return ("-" if nanoseconds < 0 else "") + f"{whole}.{rest:09d}".rstrip("0").rstrip(".")


def _seconds(nanoseconds: int) -> str:
    return f"{_number(nanoseconds)} s"


def _number_ms(nanoseconds: Fraction | int) -> str:
    return f"{float(nanoseconds) / 1e6:.6f}".rstrip("0").rstrip(".")


def _milliseconds(nanoseconds: Fraction | int) -> str:
    return f"{_number_ms(nanoseconds)} ms"


def _as_json(recording: RunReader, found: Mapping[str, Regularity]) -> dict[str, Any]:
    return {
        "name": recording.name,
        "provenance": recording.provenance,
        "files": [
            {"name": one.name, "bytes": Path(one.name).stat().st_size, "finished": not one.unfinished}
            for one in recording.files
        ],
        "report": recording.report is not None,
        "messages": sum(one.messages for one in found.values()),
        "topics": {name: _topic(recording, name, one) for name, one in found.items()},
        "notes": recording.notes,
        "skipped": recording.skipped,
    }


def _topic(recording: RunReader, name: str, one: Regularity) -> dict[str, Any]:
    period, late, apart = one.period_ns, one.late_ns, one.distances_ns
    expected = due(recording, name, one)
    return {
        "type": recording.recorded[name].type_name,
        "messages": one.messages,
        "bytes": one.size,
        "sensor": one.sensor or None,
        "tick_rate_hz": None if one.rate is None else float(one.rate),
        "due": expected,
        "ticks": one.ticks,
        "missing": None if expected is None else max(0, expected - one.ticks),
        "first_ns": one.first_ns,
        "last_ns": one.last_ns,
        "rate_hz": float(10**9 / period) if period else None,
        "period_ns": None if period is None else float(period),
        "exact": one.exact,
        "late_ns": None if late is None else {"least": late[0], "most": late[1]},
        "apart_ns": None if apart is None else {"least": apart[0], "most": apart[1]},
        "gaps": [{"after_ns": at, "length_ns": length} for at, length in one.gaps()],
        "repeats": one.repeats,
        "restarts": one.restarts,
        "wall_time": one.wall,
    }
