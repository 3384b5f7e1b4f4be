"""Writes outcomes as JUnit XML, the format that CI servers read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

from graph.base.outputs import make_folder, replacing

from .running import Outcome


def write_junit(path: Path, outcomes: Mapping[str, Sequence[Outcome]]) -> None:
    """Writes the outcomes of each test file: one testsuite for each file, one testcase for each case, times in seconds.

    Raises OSError if the file cannot be written.
    """
    every = [outcome for group in outcomes.values() for outcome in group]
    root = ElementTree.Element("testsuites", _totals(every))
    for name, group in outcomes.items():
        suite = ElementTree.SubElement(root, "testsuite", {"name": _text(name), **_totals(group)})
        for outcome in group:
            case = outcome.case
            attributes = {
                "classname": _text(name),
                "name": _text(case.name),
                "file": _text(case.mark.file),
                "line": str(case.mark.line),
                "time": f"{outcome.seconds:.6f}",
            }
            element = ElementTree.SubElement(suite, "testcase", attributes)
            if outcome.failures:
                lines = [_text(str(failure)) for failure in outcome.failures]
                ElementTree.SubElement(element, "failure", {"message": lines[0]}).text = "\n".join(lines)
    tree = ElementTree.ElementTree(root)
    ElementTree.indent(tree)
    make_folder(path.parent)
    with replacing(path) as stream:
        tree.write(stream, encoding="utf-8", xml_declaration=True)


def _totals(outcomes: Sequence[Outcome]) -> dict[str, str]:
    return {
        "tests": str(len(outcomes)),
        "failures": str(sum(not outcome.passed for outcome in outcomes)),
        "errors": "0",
        "skipped": "0",
        "time": f"{sum(outcome.seconds for outcome in outcomes):.6f}",
    }


def _text(text: str) -> str:
    """Text that XML 1.0 can hold: other characters become escapes."""
    return "".join(c if c.isprintable() or c in "\n\t" else f"\\u{ord(c):04x}" for c in text)
