"""Exports of a recording: which formats there are, and which topics one takes. What writes them comes with plug-ins."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from graph.base.errors import UserError
from graph.base.outputs import make_folder
from graph.base.plugins import EXPORTS, required
from graph.base.records import dataclass

if TYPE_CHECKING:
    from graph.recording.run_reader import RunReader


class Exporter(Protocol):
    """What writes one or more recordings in a format."""

    def add(self, run: RunReader, topics: list[str], out: Path, *, world: bool, number: int | None) -> list[str]:
        """Writes the topics of a recording into the folder `out`; returns lines for the user.

        world: points in the root frame of the recorded transforms, each by the pose of its own time. number: of a run
        among several, from 0 in order.
        """

    def finish(self, out: Path) -> None:
        """Writes what belongs to all recordings that were added. Raises OSError."""


@dataclass(frozen=True, slots=True)
class Format:
    """A format, declared in the entry point group `tickgraph.exports` under its name in `graph export --format`.

    - help: what it writes, in a few words.
    - fits(type_name): whether it can hold the messages of a ROS type.
    - begin(): what writes it. Raises UserError, for instance where a library is missing.
    - place(number): where in `out` a run among several is found; None for a folder of its own.
    """

    help: str
    fits: Callable[[str], bool]
    begin: Callable[[], Exporter]
    place: Callable[[int], str] | None = None


def format_of(name: str) -> Format:
    """The format of a name. Raises UserError for an unknown one, and for one that cannot be used."""
    return required(EXPORTS, name, Format, "format")


def export(
    run: RunReader,
    name: str,
    out: Path,
    patterns: Sequence[str] = (),
    *,
    world: bool = False,
    number: int | None = None,
    exporter: Exporter | None = None,
) -> list[str]:
    """Writes a recording into the folder `out`, in the format of that name; returns lines for the user.

    patterns: topics to export, * for any text (default: all that the format can hold). world, number: see `Exporter`.
    exporter: what several runs are added to, which the caller finishes. Raises UserError if no topic fits.
    """
    form = format_of(name)
    topics = _chosen(run, name, form, patterns)
    writing = exporter or form.begin()
    make_folder(out)
    lines = writing.add(run, topics, out, world=world, number=number)
    if exporter is None:
        writing.finish(out)
    return lines


def named_topics(run: RunReader, patterns: Sequence[str]) -> list[str]:
    """The topics that one of the patterns fits, * for any text (no pattern: all). Raises UserError for one without."""
    wanted = [pattern if pattern.startswith(("/", "*")) else f"/{pattern}" for pattern in patterns]
    named = [name for name in run.recorded if not wanted or any(fnmatchcase(name, pattern) for pattern in wanted)]
    for pattern in wanted:
        if not any(fnmatchcase(name, pattern) for name in run.recorded):
            listed = ", ".join(run.recorded) or "no topics"
            raise UserError(f"--topic {pattern}: the recording has no such topic; it has {listed}")
    return named


def _chosen(run: RunReader, name: str, form: Format, patterns: Sequence[str]) -> list[str]:
    named = named_topics(run, patterns)
    topics = [one for one in named if form.fits(run.recorded[one].type_name)]
    if not topics:
        listed = ", ".join(f"{one} ({run.recorded[one].type_name})" for one in named) or "no topics"
        raise UserError(f"--format {name} fits no topic of the recording: {listed}")
    return topics
