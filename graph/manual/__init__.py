"""The manual: one Markdown page a topic, in this folder. `graph help` prints them; they ship with the package.

A page begins with its title (`# Lidar`) and one paragraph that says what it answers; the list of pages
consists of these.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from importlib import resources

ORDER = (
    *("commands", "graph-files", "robot", "clocks", "world", "physics"),
    *("lidar", "camera", "radar", "other-sensors"),
    *("isaac-sim", "python", "nodes-and-tests", "live-and-recordings"),
    *("trade", "campaigns", "performance", "gpu", "robustness", "stability", "limits"),
)
"""The topics, in reading order; the text of each is `TOPIC.md` in this folder."""


@dataclass(frozen=True, slots=True)
class Page:
    """A page of the manual: its topic, its title, the line that says what it answers, and its whole text."""

    topic: str
    title: str
    line: str
    text: str

    def section(self, heading: str) -> str | None:
        """The part under the heading `## HEADING`, with it; None if the page has no such heading."""
        found = re.search(rf"^## {re.escape(heading)}\n.*?(?=^## |\Z)", self.text, re.MULTILINE | re.DOTALL)
        return found[0].rstrip() + "\n" if found else None


def page(topic: str) -> Page:
    """The page of a topic. Raises FileNotFoundError for an unknown topic."""
    text = resources.files(__package__).joinpath(f"{topic}.md").read_text(encoding="utf-8")
    title, line, *_ = text.split("\n\n", 2)
    return Page(topic, title.removeprefix("# "), " ".join(line.split()), text)


def pages() -> list[Page]:
    """Every page, in reading order."""
    return [page(topic) for topic in ORDER]
