"""Names of files for topics: all different, and short enough for every file system."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Sequence

LONGEST = 100
"""Characters of a name; endings and numbers of frames follow. File systems hold 255 bytes."""
ENDINGS = ("", ".csv")
"""What a name is used with: a folder, and a table beside it."""


def file_names(topics: Iterable[str], endings: Sequence[str] = ENDINGS) -> dict[str, str]:
    """A name of a file for each topic: /front/points is front_points. All differ with each of `endings`.

    Of topics whose names would be the same (also where upper and lower case are), the later ones get _2, _3, ...; a
    long name keeps its start, and ends with digits of its checksum.
    """
    names: dict[str, str] = {}
    taken: set[str] = set()
    for topic in dict.fromkeys(topics):
        plain = re.sub(r"[^A-Za-z0-9_.-]", "_", topic.strip("/")).strip(".") or "topic"
        if len(plain) > LONGEST:
            plain = (
                f"{plain[: LONGEST - 9]}_{hashlib.sha256(topic.encode('utf-8', 'backslashreplace')).hexdigest()[:8]}"
            )
        name, number = plain, 1
        while not taken.isdisjoint(used := {f"{name}{ending}".lower() for ending in endings}):
            number += 1
            name = f"{plain}_{number}"
        taken |= used
        names[topic] = name
    return names
