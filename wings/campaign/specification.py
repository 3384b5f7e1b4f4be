"""What a campaign is: its points, what all of them share, and what is taken from their reports; as plain data."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from hashlib import sha256
from pathlib import Path
from typing import Any

from graph.base.errors import UserError
from graph.base.inputs import digest, read
from graph.base.outputs import write

NAME = "campaign.json"
VERSION = 1


@dataclass(frozen=True, slots=True)
class Campaign:
    """A campaign. points: the values of each run, by key. common: options of `graph run` that all runs have.

    varied: the keys that differ, in order. metrics: expressions by name. hashes: SHA-256 by file that the runs read.
    """

    points: Sequence[Mapping[str, str]]
    varied: Sequence[str] = ()
    common: Sequence[str] = ()
    metrics: Mapping[str, str] = field(default_factory=dict)
    hashes: Mapping[str, str] = field(default_factory=dict)

    @property
    def width(self) -> int:
        """Digits of a run's number."""
        return max(4, len(str(len(self.points) - 1)))

    def name_of(self, number: int) -> str:
        """The name of a run's folder."""
        return f"{number:0{self.width}d}"

    def digest(self) -> str:
        """A hash of everything that decides about results."""
        return sha256(json.dumps(asdict(self), sort_keys=True).encode()).hexdigest()


def hashes_of(files: Sequence[Path | str]) -> dict[str, str]:
    """The hash of each file. Raises UserError for one that cannot be read."""
    found: dict[str, str] = {}
    for file in dict.fromkeys(map(str, files)):
        try:
            found[file] = digest(file)
        except OSError as error:
            raise UserError(f"{file}: {error.strerror}; name a file that can be read") from None
    return found


def save(campaign: Campaign, folder: Path) -> None:
    """Writes the specification. Raises OSError."""
    content = {"campaign": VERSION, "digest": campaign.digest(), **asdict(campaign)}
    write(folder / NAME, json.dumps(content, indent=1, ensure_ascii=False) + "\n")


def load(folder: Path) -> Campaign | None:
    """The campaign of a folder; None without one. Raises UserError for one that cannot be read."""
    path = folder / NAME
    if not path.exists():
        return None
    try:
        content = json.loads(read(path, "campaign.table"))
        if content.get("campaign") != VERSION:
            raise ValueError(f"its version is not {VERSION}")
        found = Campaign(**{one.name: content[one.name] for one in fields(Campaign)})
        if found.digest() != content["digest"]:
            raise ValueError("it was changed by hand")
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise UserError(f"{path} is not the file of a campaign: {error}; name another folder") from None
    return found


def difference(old: Campaign, new: Campaign) -> str:
    """What a new specification has changed, in words; "" if it is the same."""
    if old.digest() == new.digest():
        return ""
    if len(old.points) != len(new.points):
        return f"it has {len(new.points):,} runs, the campaign of the folder {len(old.points):,}"
    for number, (before, after) in enumerate(zip(old.points, new.points, strict=True)):
        if before != after:
            return f"its run {number} is another: {text_of(after)} instead of {text_of(before)}"
    changed = [file for file in new.hashes if old.hashes.get(file) != new.hashes[file]]
    if changed or old.hashes.keys() != new.hashes.keys():
        return f"{', '.join(changed) or 'the list of files'} has changed"
    return "its options or metrics have changed"


def text_of(point: Mapping[str, Any]) -> str:
    """A point as `KEY=V KEY=V`."""
    return " ".join(f"{key}={value}" for key, value in point.items())
