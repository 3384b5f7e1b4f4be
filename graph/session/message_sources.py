"""Recordings and text files of messages that a run receives: `--play FILE`, `play:` of test files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import Problem, UserError

if TYPE_CHECKING:
    from graph.files.played import Played
    from graph.recording.sources import MemorySource, Player, Source
    from graph.sim.app import App

UNHEARD = "play-unheard"
SKIPPED = "play-topic-skipped"


def remapping(options: Iterable[str]) -> dict[str, str]:
    """Options OLD:=NEW as a mapping of topics. Raises UserError for other texts, and for a topic given twice."""
    topics: dict[str, str] = {}
    for option in options:
        old, between, new = option.partition(":=")
        if not between or not old.strip("/ ") or not new.strip("/ "):
            raise UserError(f"--remap {option}: write it as OLD:=NEW, such as /cmd_vel:=/robot/cmd_vel")
        old, new = _absolute(old), _absolute(new)
        if topics.setdefault(old, new) != new:
            raise UserError(f"--remap {option}: {old} already goes to {topics[old]}; a topic goes to one other")
    return topics


def open_sources(paths: Iterable[str | Path], remap: Mapping[str, str] | None = None) -> list[Source]:
    """The sources in files, by their extensions. Raises UserError with the problems of all files.

    remap: topic -> topic on which its messages are played; each must be in one of the files.
    """
    sources: list[Source] = []
    problems: list[Problem] = []
    for path in paths:
        try:
            sources.append(_open(Path(path)))
        except UserError as error:
            problems += error.problems
    if problems:
        for source in sources:
            source.close()
        raise UserError(problems)
    return _remapped(sources, remap) if remap else sources


def _remapped(sources: list[Source], remap: Mapping[str, str]) -> list[Source]:
    from graph.base.suggest import did_you_mean
    from graph.recording.sources import RemappedSource

    known = dict.fromkeys(topic for source in sources for topic in source.topics())
    for old, new in remap.items():
        if not sources:
            raise UserError(f"--remap {old}:={new}: it is for the topics of --play; give --play too, or leave it out")
        if old not in known:
            for source in sources:
                source.close()
            said = f"they have {', '.join(known)}" if known else "they have no topics"
            near = did_you_mean(old, known, said)
            raise UserError(f"--remap {old}:={new}: the files of --play have no topic {old}{near}")
    return [RemappedSource(source, remap) for source in sources]


def _absolute(topic: str) -> str:
    return f"/{topic.strip().strip('/')}"


def files_of(sources: Iterable[Source]) -> list[Path]:
    """The files that the sources read while they are played."""
    return [Path(file.name) for source in sources for file in getattr(source, "files", ())]


def play_into(app: App, sources: Sequence[Source]) -> Player:
    """Plays the sources into the App from its next play on; topics that cannot be read give warnings."""
    from graph.recording.sources import Player

    for source in sources:
        for topic, why in getattr(source, "skipped", {}).items():
            app.warn(SKIPPED, f"{source.name} {topic}", f"the topic is left out: {why}")
    return Player(app, sources)


def warn_unheard(app: App, player: Player) -> None:
    """Warns of files without any listener. Call it after the last update, while the App still plays."""
    for name, why in player.unheard():
        app.warn(UNHEARD, name, why)


def _open(path: Path) -> Source:
    from graph.files.played import is_played_text, load_played

    if is_played_text(path) and not path.is_dir():
        return written_source(load_played(path), str(path))
    from graph.recording.run_reader import SUFFIXES, open_run

    if path.is_dir() or path.suffix.lower() in SUFFIXES:
        return open_run(path)
    raise UserError(
        f"{path}: messages are played from .mcap, .db3, .yaml, .json and .jsonl files, folders of runs and rosbag2 "
        "folders; name one"
    )


def written_source(entries: Iterable[Played], name: str) -> MemorySource:
    """The source of messages that are written as text. Raises UserError with every unknown type and wrong field."""
    from graph.base.suggest import did_you_mean
    from graph.recording.sources import MemorySource
    from graph.sim.messages.ros_fields import from_plain
    from graph.sim.messages.ros_types import known, type_names

    problems: list[Problem] = []
    messages: list[tuple[Any, str, str, Any]] = []
    for entry in entries:
        try:
            if not known(entry.type_name):
                raise ValueError(
                    f'there is no message type "{entry.type_name}"{did_you_mean(entry.type_name, type_names())}'
                )
            messages.append((entry.time, entry.topic, entry.type_name, from_plain(entry.type_name, entry.fields)))
        except ValueError as error:
            problems.append(Problem(str(error), entry.mark))
    if problems:
        raise UserError(problems)
    return MemorySource(messages, name=name)
