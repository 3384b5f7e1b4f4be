"""Names of files for topics."""

from __future__ import annotations

import re
from collections.abc import Iterable


def file_names(topics: Iterable[str]) -> dict[str, str]:
    """A name of a file for each topic, all different: /front/points is front_points.

    Of topics whose names would be the same (also where upper and lower case are), the later ones get _2, _3, ...
    """
    names: dict[str, str] = {}
    taken: set[str] = set()
    for topic in dict.fromkeys(topics):
        plain = re.sub(r"[^A-Za-z0-9_.-]", "_", topic.strip("/")).strip(".") or "topic"
        name, number = plain, 1
        while name.lower() in taken:
            number += 1
            name = f"{plain}_{number}"
        taken.add(name.lower())
        names[topic] = name
    return names
