"""The findings for a file or a script, with their places."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import Mark
from graph.base.records import dataclass
from graph.sim import settings as keys

from .rules import RULES, Rule

if TYPE_CHECKING:
    from pxr import Usd

    from graph.evaluate import Graph
    from graph.sim.settings import Settings
    from graph.spec.file_spec import FileSpec, Note


@dataclass(frozen=True, slots=True)
class Finding:
    """One broken rule: where, what it concerns (see `graph.portability.case.Found`), and what is wrong with it."""

    rule: Rule
    mark: Mark | None
    subject: str
    detail: str

    def note(self) -> Note:
        """Code, place and message of the warning."""
        said = f"{self.detail}: {self.rule.why}; {self.rule.fix}"
        if self.mark is None:
            return self.rule.code, self.subject, said
        return self.rule.code, str(self.mark), f"{self.subject}: {said}" if self.subject else said

    def as_dict(self) -> dict[str, Any]:
        """The finding in the JSON report, beside code, where and message."""
        mark = self.mark
        return {
            "subject": self.subject,
            "file": mark.file if mark else None,
            "line": mark.line if mark else None,
            "column": mark.column if mark else None,
            "why": self.rule.why,
            "fix": self.rule.fix,
            "fixable": self.rule.fixable,
        }


def file_findings(
    target: str, spec: FileSpec, graphs: list[Graph], stage: Usd.Stage, settings: Settings
) -> list[Finding]:
    """What fails or differs in the target though the file works here, in the order of the rules."""
    from . import clocks, sensors, wiring  # noqa: F401  (they declare what finds the rules)
    from .case import FINDERS, Case

    case = Case(spec, graphs, stage, settings)
    accepted = str(settings.get(keys.ACCEPTED_FINDINGS) or "").split()
    return [
        Finding(rule, case.mark(subject), subject, detail)
        for rule in RULES.values()
        if target in rule.targets and rule.code not in accepted
        for finder in FINDERS.get(rule.code, ())
        for subject, detail in dict.fromkeys(finder(case))
    ]


def script_findings(target: str, path: str | Path) -> list[Finding]:
    """The same for a Python script, by its syntax tree, in the order of its lines. Raises as `read_script`."""
    from .script_rules import FINDERS
    from .syntax import read_script

    script = read_script(path)
    found = [
        Finding(rule, script.mark(place), "", detail)
        for rule in RULES.values()
        if target in rule.targets
        for finder in FINDERS.get(rule.code, ())
        for place, detail in finder(script)
    ]
    return sorted(dict.fromkeys(found), key=lambda one: (one.mark or Mark("", 0, 0), one.rule.code))


def without_twins(notes: Iterable[Note], findings: Sequence[Finding]) -> Iterator[Note]:
    """The warnings that no finding repeats with a better place."""
    found: dict[str, list[Finding]] = {}
    for one in findings:
        found.setdefault(one.rule.code, []).append(one)
    for code, where, message in notes:
        place, said = where.partition(".")[0], where + message
        if not any(one.subject.partition(".")[0] in said or place in one.detail for one in found.get(code, ())):
            yield code, where, message
