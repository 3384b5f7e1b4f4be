"""Writes what commands print into the pages of the manual: their options, the knobs, the limits, the extremes.

The figures of benchmarks come from `tests/benchmarks/measured.json`; README shows some of them.

python -m tests.support.manual [--check] [--measure] [--slow]

--check: change nothing, and fail if a page is not up to date. --measure: run the cases at the extremes
again (--slow: also those that take minutes); without it the page keeps their measured values.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import io
import re
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args, get_type_hints

from graph.base.forms import Form
from graph.base.limits import LIMITS
from graph.cli import completion
from graph.cli.commands import every, find
from graph.cli.extreme_cases import outcomes
from graph.files.file_forms import GraphFile
from graph.files.prim_schema import PRIM
from graph.sim.fidelity import KNOBS
from graph.sim.knob import word
from tests.stability.extremes.table import CASES, HEADINGS
from tests.support import figures
from tests.support.places import ROOT

COMMAND = ".venv/bin/python -m tests.support.manual"
FOLDER = ROOT / "graph" / "manual"
README = ROOT / "README.md"
SAID_ONCE = ("--help", "--debug")
"""Options of every command, which the page of commands explains at its top."""
PLACE = {"graphs": "PATH"}
"""The word for the keys below a key that are the user's own; else `NAME`."""
MANY = 3
"""Commands with the same argument for which it is explained once."""


@dataclass(frozen=True)
class Block:
    """A part of a page between `<!-- NAME -->` and `<!-- end NAME -->`, made by a function from what it is now."""

    page: str
    name: str
    make: Callable[[str], str]

    @property
    def path(self) -> Path:
        """The file of its page."""
        return README if self.page == README.stem else FOLDER / f"{self.page}.md"


def table(headings: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table; `|` in cells is escaped."""
    lines = [[cell.replace("|", "\\|") for cell in row] for row in (headings, *rows)]
    rule = f"|{'---|' * len(lines[0])}"
    return "\n".join([f"| {' | '.join(lines[0])} |", rule, *(f"| {' | '.join(row)} |" for row in lines[1:])])


def commands() -> str:
    """Every command with its line, as `graph --help` prints them."""
    return table(("command", "what it does"), ((f"`graph {name}`", one.help) for name, one in every().items()))


@functools.cache
def arguments() -> dict[str, dict[str, str]]:
    """The arguments of each command, in the order of its --help: how each is written, and what it does."""
    return {
        name: {spelling(action): said(action) for action in actions if action.help != argparse.SUPPRESS}
        for name, actions in completion.arguments().items()
    }


def shared() -> dict[str, list[str]]:
    """The arguments that several commands explain in the same words, with these commands."""
    owners: dict[tuple[str, str], list[str]] = {}
    for name, listed in arguments().items():
        for argument in listed.items():
            owners.setdefault(argument, []).append(name)
    return {argument: names for (argument, _), names in owners.items() if len(names) >= MANY}


def options(name: str) -> str:
    """The arguments of a command, as its --help prints them; those of many commands by name."""
    listed, common = arguments()[name], shared()
    own = [argument for argument in listed if name not in common.get(argument, ())]
    lines = [table(("argument", "what it does"), ((f"`{argument}`", listed[argument]) for argument in own))]
    also = [f"`{argument.split()[0]}`" for argument in listed if argument not in own and argument not in SAID_ONCE]
    if also:
        lines += ["", f"Also: {', '.join(also)} ([below](#options-of-several-commands))."]
    return "\n".join(lines)


def shared_options() -> str:
    """What the arguments of many commands do."""
    listed = arguments()
    rows = (
        (f"`{argument}`", listed[names[0]][argument])
        for argument, names in shared().items()
        if argument not in SAID_ONCE
    )
    return table(("argument", "what it does"), rows)


def said(action: argparse.Action) -> str:
    """The help of an argument; an option that may be given several times says so."""
    several = action.option_strings and isinstance(action.default, list) and "repeated" not in (action.help or "")
    return f"{action.help or ''}{'; may be repeated' if several else ''}"


def spelling(action: argparse.Action) -> str:
    """How an argument is written: `--out DIR`, `FILE`."""
    value = action.metavar or ("{" + ",".join(map(str, action.choices)) + "}" if action.choices else "")
    if not action.option_strings:
        return str(value or action.dest)
    return f"{action.option_strings[-1]} {value}".rstrip() if action.nargs != 0 else action.option_strings[-1]


def keys() -> str:
    """The keys of graph files, with dots between the levels."""
    return table(("key", "meaning"), ((f"`{key}`", text) for key, text in _keys(GraphFile, "")))


def _keys(form: type[Form], before: str) -> Iterator[tuple[str, str]]:
    """The keys below a key (`clock.`), each with its description."""
    hints = get_type_hints(form, include_extras=True)
    for name, field in form.fields.items():
        inner = next((one for one in _forms(hints[name]) if one is not form), None)
        if field.description:
            yield f"{before}{name}", field.description
        if inner is not None:
            own = f"{PLACE.get(name, 'NAME')}." if field.description else ""
            yield from _keys(inner, f"{before}{name}.{own}")


def _forms(hint: Any) -> Iterator[type[Form]]:
    """The forms in a type hint, however deep."""
    if isinstance(hint, type) and issubclass(hint, Form):
        yield hint
    for part in get_args(hint):
        yield from _forms(part)


def prim_keys() -> str:
    """The keys of prims in graph files."""
    properties: dict[str, dict[str, Any]] = PRIM["properties"]
    return table(("key", "meaning"), ((f"`{key}`", _with_values(one)) for key, one in properties.items()))


def _with_values(schema: dict[str, Any]) -> str:
    """The description of a key; with its values, if they are few."""
    values = f": {', '.join(schema['enum'])}." if "enum" in schema else "."
    return f"{schema['description'].rstrip('.')}{values}"


def knobs() -> str:
    """The fidelity knobs, as `graph trade --list` has them: a paragraph each."""
    return "\n".join(
        f"- **`{name}`** = {knob.values}{'' if knob.default is None else f' (default {word(knob.default)})'}: "
        f"{knob.doc}. *Cost:* {knob.cost}. *Error:* {knob.error}. *This default:* {knob.why}."
        for name, knob in KNOBS.items()
    )


def metrics() -> str:
    """The metrics of `graph trade`."""
    from wings.trade.metrics import METRICS  # the other pages do without the wing

    rows = ((f"`{name}`", one.unit or "1", one.doc) for name, one in METRICS.items())
    return table(("metric", "unit", "meaning"), rows)


def rules() -> str:
    """The rules of `graph check --target`."""
    from wings.portability.rules import RULES

    rows = ((f"`{code}`", one.what, f"{one.why}. {one.fix[0].upper()}{one.fix[1:]}") for code, one in RULES.items())
    return table(("code", "found", "what happens there, and what to do"), rows)


def limits() -> str:
    """The table of limits."""
    rows = ((f"`{name}`", f"{one.default:,} {one.unit}", one.doc) for name, one in LIMITS.items())
    return table(("limit", "value", "of"), rows)


def extremes(before: str, measure: bool, slow: bool) -> str:
    """The table of cases at the extremes; cases that do not run again keep their measured value."""
    kept = {cells[1]: cells[3] for cells in map(cells_of, before.splitlines()[2:])}
    again = {case.name for case in CASES if case.name not in kept or (measure and (slow or not case.slow))}
    measured = kept | {one.case.name: one.measured for one in outcomes(case for case in CASES if case.name in again)}
    return table(HEADINGS, ((one.area, one.name, one.limit, measured[one.name], one.why) for one in CASES))


def benchmarks() -> str:
    """The tables of benchmarks, a heading for each group, and where the figures come from."""
    parts = []
    for heading, of, rows in figures.sections():
        parts += [f"### {heading}", *([of] if of else []), table(("case", "result", "goal"), rows)]
    return "\n\n".join((*parts, *figures.origins()))


def readme_figures() -> str:
    """The table of README, from the measured values of the manual."""
    stability = (FOLDER / "stability.md").read_text(encoding="utf8")
    cases = [cells_of(line) for line in stability.splitlines() if line.startswith("| ")]
    return table(("measured", "result", "by"), figures.shown(cases))


def cells_of(line: str) -> list[str]:
    """The cells of a row of a Markdown table."""
    return [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]]


def _options(name: str, before: str) -> str:
    return options(name)


def blocks(measure: bool = False, slow: bool = False) -> Iterator[Block]:
    """Every generated part."""
    yield Block("commands", "commands", lambda _: commands())
    for name in every():
        yield Block("commands", f"options of {name}", functools.partial(_options, name))
    yield Block("commands", "options of several commands", lambda _: shared_options())
    yield Block("graph-files", "keys", lambda _: keys())
    yield Block("world", "prim keys", lambda _: prim_keys())
    yield Block("trade", "knobs", lambda _: knobs())
    yield Block("trade", "metrics", lambda _: metrics())
    yield Block("isaac-sim", "rules", lambda _: rules())
    yield Block("robustness", "limits", lambda _: limits())
    yield Block("performance", "benchmarks", lambda _: benchmarks())
    yield Block("stability", "extremes", lambda before: extremes(before, measure, slow))
    yield Block(README.stem, "figures", lambda _: readme_figures())


def words(line: str) -> list[str]:
    """The arguments of a line that calls the command, without its comment."""
    _, _, rest = line.partition("graph ")
    return shlex.split(rest, comments=True)


def refused(line: str) -> str:
    """What is wrong with a line that calls the command: an option or argument that it does not have; "" if nothing."""
    said, given = io.StringIO(), [word for word in words(line) if not word.startswith("--/")]
    command = find(given[0]) if given else None
    if command and command.script:  # what follows the script is its own
        given = given[: next((place for place, word in enumerate(given) if word.endswith(".py")), len(given)) + 1]
    with contextlib.redirect_stderr(said), contextlib.suppress(SystemExit):
        completion.command_line().parse_args(given)
    return f"{line}: {said.getvalue()}" if said.getvalue() else ""


def renewed(text: str, block: Block) -> str:
    """A page with one part made again. Raises LookupError if the page has no such part."""
    start, end = f"<!-- {block.name} -->\n", f"<!-- end {block.name} -->\n"
    head, found, rest = text.partition(start)
    before, closed, tail = rest.partition(end)
    if not found or not closed:
        raise LookupError(f"{block.page}.md has no part {start.strip()} ... {end.strip()}; add these two lines")
    return f"{head}{start}{block.make(before)}\n{end}{tail}"


def main(arguments: list[str] | None = None) -> int:
    """Writes the pages, or checks them; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    for option in ("--check", "--measure", "--slow"):
        parser.add_argument(option, action="store_true")
    args = parser.parse_args(arguments)
    stale = []
    for block in blocks(args.measure or args.slow, args.slow):
        text = block.path.read_text(encoding="utf8")
        new = renewed(text, block)
        if new != text:
            stale.append(block.page)
            if not args.check:
                block.path.write_text(new, encoding="utf8")
    if args.check and stale:
        print(f"not up to date: {', '.join(dict.fromkeys(stale))}; run: {COMMAND}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
