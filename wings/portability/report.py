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
    from graph.isaac.syntax import Script
    from graph.sim.settings import Settings
    from graph.spec.file_spec import FileSpec, Note

    from .case import Asked


@dataclass(frozen=True, slots=True)
class Finding:
    """One broken rule: where, what it concerns (see `wings.portability.case.Found`), and what is wrong with it."""

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


def of_file(
    target: str,
    spec: FileSpec,
    graphs: list[Graph],
    stage: Usd.Stage,
    settings: Settings,
    by_script: Sequence[Asked] = (),
) -> list[Finding]:
    """What fails or differs in the target though the file works here, in the order of the rules.

    by_script: of the file that a script amounts to, what the script asks of sensors.
    """
    from . import clocks, sensors, wiring  # noqa: F401  (they declare what finds the rules)
    from .case import FINDERS, Case

    case = Case(spec, graphs, stage, settings, by_script)
    accepted = str(settings.get(keys.ACCEPTED_FINDINGS) or "").split()
    return [
        Finding(rule, case.mark(subject), subject, detail)
        for rule in RULES.values()
        if target in rule.targets and rule.code not in accepted
        for finder in FINDERS.get(rule.code, ())
        for subject, detail in dict.fromkeys(finder(case))
    ]


def of_script(target: str, path: str | Path) -> list[Finding]:
    """The same for a Python script, by its syntax tree, in the order of its lines. Raises as `read_script`.

    What the script authors by constants is looked at as a graph file too.
    """
    from graph.isaac.syntax import read_script

    from .script_rules import FINDERS

    script = read_script(path)
    found = [
        Finding(rule, script.mark(place), "", detail)
        for rule in RULES.values()
        if target in rule.targets
        for finder in FINDERS.get(rule.code, ())
        for place, detail in finder(script)
    ]
    first: dict[tuple[str, Mark | None], Finding] = {}
    for one in (*found, *_of_draft(target, script)):
        first.setdefault((one.rule.code, one.mark), one)
    return sorted(first.values(), key=lambda one: (one.mark or Mark("", 0, 0), one.rule.code))


def _of_draft(target: str, script: Script) -> Iterator[Finding]:
    """The findings in the graph file that a script amounts to, as far as its constants decide them."""
    from graph.session.open import build_parts
    from graph.sim.settings import of_profile
    from graph.spec.migration import migrate

    from .script_rules.authored import named
    from .script_rules.draft import author_rest, draft
    from .script_rules.edits import adds_attributes, edits_of, refused_by

    drawn = draft(script)
    spec = migrate(drawn.spec)
    for code, where, message in spec.notes:
        if code == "attribute-removed":
            file, line, column = where.rsplit(":", 2)
            yield Finding(RULES[code], Mark(file, int(line), int(column)), "", message)
    parts = build_parts(spec)
    settings = of_profile(spec.clock.parity, spec.settings)
    places = {script.mark(one.place): one.graph for group in edits_of(script).all for one in group}
    for problem in parts.problems if not adds_attributes(script) else ():
        if problem.mark is not None and places.get(problem.mark, "") and refused_by(problem.message):
            yield Finding(RULES["edit-refused"], problem.mark, "", problem.message)
    messages = "\n".join(problem.message for problem in parts.problems)
    unread = tuple(f"{path}." for path in spec.scene.prims if f"{path}: config: " in messages)
    if parts.stage is not None:
        author_rest(parts.stage, drawn.values)
        for one in of_file(target, spec, parts.graphs, parts.stage, settings, drawn.asked):
            mark = one.mark or spec.clock.mark
            if (
                drawn.decides(one.rule.code, one.subject, one.detail)
                and not f"{one.subject}.".startswith(unread)
                and mark is not None
            ):
                yield Finding(one.rule, mark, named(one.subject), named(one.detail))


def without_twins(notes: Iterable[Note], findings: Sequence[Finding]) -> Iterator[Note]:
    """The warnings that no finding repeats with a better place."""
    found: dict[str, list[Finding]] = {}
    for one in findings:
        found.setdefault(one.rule.code, []).append(one)
    for code, where, message in notes:
        place, said = where.partition(".")[0], where + message
        if not any(one.subject.partition(".")[0] in said or place in one.detail for one in found.get(code, ())):
            yield code, where, message
