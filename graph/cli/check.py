"""`graph check`: validates graph files, and those of other kinds, without running them; every problem is one line."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import Mark, Problem, UserError
from graph.base.gc_pause import collector_paused
from graph.base.plugins import FILES, TARGETS, shipped
from graph.base.records import dataclass

from .arguments import add_allow, add_nodes, add_set, add_skip_outside, overrides_of
from .printing import counted, note_line, problem_line, say, say_json, tell
from .targets import Finding, checks_of

if TYPE_CHECKING:
    from graph.session.open import Parts
    from graph.spec.file_spec import FileSpec, Note


@dataclass(frozen=True, slots=True)
class Checked:
    """The result for one file: its content (None if the text could not be read), its problems and its warnings."""

    file: str
    spec: FileSpec | None
    problems: tuple[Problem, ...]
    notes: tuple[Note, ...] = ()
    numbers: Mapping[str, int] | None = None
    """What the file has, by name, if it is not a graph file: cases, runs, findings."""
    prims: int = 0
    """The number of inline prims; with a scene, of all its prims except graphs and nodes."""
    findings: tuple[Finding, ...] = ()
    """What fails or differs in the target; their notes are among `notes`."""

    def counts(self) -> dict[str, int]:
        """The numbers of graphs, nodes, connections and prims; in a file of another kind `numbers`."""
        if self.numbers is not None:
            return dict(self.numbers)
        graphs = self.spec.graphs if self.spec else ()
        return {
            "graphs": len(graphs),
            "nodes": sum(len(graph.nodes) for graph in graphs),
            "connections": sum(len(graph.connections) for graph in graphs),
            "prims": self.prims,
        }

    def as_dict(self) -> dict[str, Any]:
        """The file's part of the JSON report."""
        more = {one.note(): one.as_dict() for one in self.findings}
        return {
            "file": self.file,
            "ok": not self.problems,
            **self.counts(),
            "problems": [
                {
                    "message": problem.message,
                    "file": problem.mark.file if problem.mark else self.file,
                    "line": problem.mark.line if problem.mark else None,
                    "column": problem.mark.column if problem.mark else None,
                }
                for problem in self.problems
            ],
            "warnings": [
                {"code": note[0], "where": note[1], "message": note[2], **more.get(note, {})} for note in self.notes
            ],
        }


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    kinds = "".join(f", {name} file" for name in shipped(FILES))
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="+",
        help=f"graph file (.yaml, .json or .usda), *.test.yaml{kinds}; or a Python script, only read: "
        "what graph exec cannot run of it, with --target what fails there",
    )
    parser.add_argument(
        "--target",
        metavar="NAME",
        help=f"also tell what would fail or differ in that product, though not here: {' or '.join(shipped(TARGETS))}",
    )
    parser.add_argument(
        "--fix", action="store_true", help="with --target: apply the safe fixes to graph files, and say what changed"
    )
    parser.add_argument("--skip-unknown", action="store_true", help="leave nodes of unknown types out, with a warning")
    parser.add_argument("--json", action="store_true", help="print the result as JSON and nothing else on stdout")
    add_set(parser)
    add_nodes(parser)
    add_allow(parser)
    add_skip_outside(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command; returns 2 if any file is wrong."""
    if args.target is not None:
        checks_of(args.target)
    elif args.fix:
        raise UserError(f"--fix mends what a product needs; name it: --target {next(iter(shipped(TARGETS)))}")

    def checked_once(file: str) -> Checked:
        return check(
            file,
            allow=args.allow,
            skip_outside=args.skip_outside,
            settings=args.settings,
            overrides=overrides_of(args),
            skip_unknown=args.skip_unknown,
            target=args.target,
        )

    checked = [checked_once(file) for file in args.files]
    if args.fix:
        checked = [checked_once(one.file) if _fixed(one, args.target) else one for one in checked]
    if args.json:
        say_json({"files": [one.as_dict() for one in checked]})
    for one in checked:
        for note in one.notes:
            tell(note_line(note))
        for problem in one.problems:
            tell(problem_line(problem))
        if not args.json and not one.problems:
            counts = ", ".join(counted(number, word) for word, number in one.counts().items())
            say(f"{one.file}: ok, {counts}")
    return 2 if any(one.problems for one in checked) else 0


def _fixed(one: Checked, target: str) -> bool:
    """Applies the safe fixes to a file that is right otherwise; whether it changed."""
    if one.problems or not one.findings or one.spec is None:
        return False
    lines: list[str] = checks_of(target).fix_file(Path(one.file), one.spec, one.findings, target)
    for line in lines:
        tell(f"{one.file}: {line}")
    return bool(lines)


@collector_paused()
def check(
    file: str,
    *,
    allow: Sequence[Path] = (),
    skip_outside: bool = False,
    settings: Mapping[str, Any] | None = None,
    overrides: Mapping[str, Any] | None = None,
    skip_unknown: bool = False,
    target: str | None = None,
) -> Checked:
    """Loads, compiles and stages one file, without playing it; `settings` and `overrides` replace the file's values.

    target: a product whose known faults are looked for too.
    """
    # The engine, the world and the nodes are imported only here: `graph check --help` does not need them.
    from graph.files.kinds import file_kind, kind_of
    from graph.session.open import build_parts
    from graph.testing.names import is_test_file

    if is_test_file(Path(file)):
        return _check_tests(file, allow)
    if kind := kind_of(Path(file)):
        options = {"skip_outside": skip_outside, "skip_unknown": skip_unknown, "target": target}
        checked: Checked = import_module(file_kind(kind).module).check(file, allow, **options)
        return checked
    if _is_script(file):
        return _check_script(file, target)
    parts = build_parts(
        file,
        allow=allow,
        skip_outside=skip_outside,
        settings=settings,
        overrides=overrides,
        skip_unknown=skip_unknown,
    )
    problems, notes = tuple(parts.problems), tuple(parts.warnings)
    findings: tuple[Finding, ...] = ()
    if target is not None and parts.spec is not None and parts.stage is not None:
        from graph.sim.settings import of_profile

        held = of_profile(parts.spec.clock.parity, {**parts.spec.settings, **(settings or {})})
        findings = tuple(checks_of(target).of_file(target, parts.spec, parts.graphs, parts.stage, held))
    if parts.stage is not None and not problems:
        from graph.session.graph_links import Links, unread_products
        from graph.sim.physics.read_world import survey
        from graph.sim.scene.diagnostics import reading

        notes += tuple(unread_products(Links(parts.graphs)))
        try:
            with reading(file):
                notes += tuple(survey(parts.stage, mirrors=parts.mjcf is not None))
                notes += tuple(_traps(parts, allow))
        except UserError as error:
            problems = tuple(error.problems)
    if target is not None and findings:
        notes = (*checks_of(target).without_twins(notes, findings), *(one.note() for one in findings))
    once = tuple(dict.fromkeys(notes))
    return Checked(file, parts.spec, problems, once, prims=_count_prims(parts), findings=findings)


def _is_script(file: str) -> bool:
    return Path(file).suffix.lower() == ".py"


def _check_script(file: str, target: str | None) -> Checked:
    """What `graph exec` cannot run of a script, or with a target what it would lose there; it is never run."""
    try:
        if target is None:
            from graph.isaac.runnable import lacks
            from graph.isaac.syntax import read_script

            found = lacks(read_script(file))
            problems = tuple(one.problem for one in found if one.certain)
            notes = tuple(
                ("script-name-missing", str(one.problem.mark), one.problem.message) for one in found if not one.certain
            )
            return Checked(file, None, problems, notes, {"findings": 0})
        findings = tuple(checks_of(target).of_script(target, file))
    except UserError as error:
        return Checked(file, None, error.problems, numbers={"findings": 0})
    notes = tuple(one.note() for one in findings)
    return Checked(file, None, (), notes, {"findings": len(findings)}, findings=findings)


def _count_prims(parts: Parts) -> int:
    if parts.spec is None:
        return 0
    scene = parts.spec.scene
    if parts.stage is None or (scene.usd is None and scene.mjcf is None):
        return len(scene.prims)
    return sum(prim.GetTypeName() not in ("OmniGraph", "OmniGraphNode") for prim in parts.stage.Traverse())


def _traps(parts: Parts, allow: Sequence[Path]) -> list[Note]:
    from graph.session.open import start
    from graph.session.step_limit import check_steps

    from .explain_traps import load_traps
    from .safe_log import quiet_warnings

    with quiet_warnings():
        session = start(parts, allow)
        with session.app:
            check_steps(session.app)
            return load_traps(session)


def _check_tests(file: str, allow: Sequence[Path]) -> Checked:
    from graph.testing.cases import read_cases
    from graph.testing.checking import check_cases

    tests = read_cases(file, allow)
    problems = (*tests.problems, *check_cases(tests.cases, allow))
    problems = tuple(sorted(problems, key=lambda one: one.mark or Mark("", 0, 0)))
    return Checked(file, None, problems, (), {"cases": len(tests.cases)})
