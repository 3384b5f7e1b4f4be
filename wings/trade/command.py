"""`graph trade`: measures speed against accuracy of a graph file over settings of its fidelity knobs."""

from __future__ import annotations

import argparse
import functools
import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from graph.base.errors import Problem, RunError, UserError
from graph.base.exact import duration as exact_duration
from graph.base.outputs import make_folder, write
from graph.base.shorten import printable
from graph.cli.arguments import (
    add_allow,
    add_nodes,
    add_overrides,
    add_play,
    add_skip_outside,
    check_folder,
    fidelity_of,
    limits_of,
    overrides_of,
)
from graph.cli.interrupts import between_updates
from graph.cli.printing import EXIT_INTERRUPTED, print_table, say, say_json, tell
from graph.cli.progress import counting

if TYPE_CHECKING:
    from .outcome import Outcome
    from .study import Scene, Study

Answer = TypeVar("Answer")

NONE_KEEPS_THE_BUDGET = 1
MOST_COLUMNS = 4
"""Errors that the table on the terminal shows; fewer where it is narrow."""
COSTS_WIDTH, COLUMN_WIDTH = 26, 17


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("file", metavar="FILE", nargs="?", type=Path, help="graph file (.yaml, .json or .usda)")
    parser.add_argument("--list", action="store_true", help="list the knobs and the metrics, and do nothing else")
    parser.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="KEY=V1,V2,...",
        help="values of a fidelity knob, a node's input (NODE.ATTR) or an attribute of a prim "
        "(/World/Lidar.omni:sensor:tickRate=5,10,20); repeated: every combination is run. KEY+KEY=... gives "
        "several attributes the same value",
    )
    parser.add_argument(
        "--one-at-a-time",
        action="store_true",
        help="run only settings that differ from the reference in one knob, instead of every combination",
    )
    parser.add_argument(
        "--reference",
        action="append",
        default=[],
        metavar="KEY=V",
        help="a knob or attribute of the setting that is taken as exact (default: of each that is varied the finest "
        "value, `graph help trade` says which that is)",
    )
    parser.add_argument(
        "--budget", action="append", default=[], metavar="METRIC=VALUE", help="a bound that the answer has to keep"
    )
    parser.add_argument("--duration", default="1", metavar="S", help="simulated seconds of each run (default 1)")
    parser.add_argument("--repeat", type=int, default=3, metavar="N", help="timed runs of each setting (default 3)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write trade.json, trade.csv, trade.html, trade.png")
    parser.add_argument("--write", action="store_true", help="write the cheapest setting within the budget into FILE")
    parser.add_argument("--json", action="store_true", help="print trade.json and nothing else on stdout")
    add_overrides(parser)
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of every random stream (default 0)")
    parser.add_argument("--skip-unknown", action="store_true", help="leave nodes of unknown types out, with a warning")
    parser.add_argument(
        "--allow-scripts", action="store_true", help="run Python code that the file brings (ScriptNode)"
    )
    add_play(parser)
    add_nodes(parser)
    add_allow(parser)
    add_skip_outside(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command; returns its exit code."""
    if args.list:
        return _list(args.json)
    from .conduct import conduct
    from .workers import Pool

    study = _study(args)
    with between_updates() as received:  # a signal ends the measuring; what was measured is written all the same
        with (
            _progress(not args.json and sys.stderr.isatty()) as progress,
            Pool(study.scene, interrupted=lambda: bool(received)) as pool,
        ):
            outcome = conduct(study, pool, progress)
        return _answer(args, outcome)


def _answer(args: argparse.Namespace, outcome: Outcome) -> int:
    """Prints and writes what was measured; returns the exit code."""
    best = outcome.recommended if outcome.complete else None
    if args.json:
        from .outputs import as_dict

        say_json(as_dict(outcome))
    else:
        _print(outcome)
    files = write_files(outcome, args.out) if args.out else []
    if args.write and best is not None:
        from .outputs import chosen
        from .writing import write_block

        write_block(args.file, chosen(outcome, best))
        files.append(args.file)
    if files:
        (tell if args.json else say)(f"wrote {', '.join(map(str, files))}")
    if not outcome.complete:
        tell("interrupted; this is what was measured by then")
        return EXIT_INTERRUPTED
    return NONE_KEEPS_THE_BUDGET if outcome.study.budget and best is None else 0


# -- what is asked -----------------------------------------------------------------------------------------------------


def _study(args: argparse.Namespace) -> Study:
    """The study of the command line. Raises UserError with everything that is wrong with it."""
    from graph.sim.fidelity import KNOBS

    from .study import Study, overrides_of, plan_settings, read_values, read_varied, references
    from .writing import check_writable

    problems: list[Problem] = []
    nodes = functools.cache(lambda: _node_names(args))
    varied = _collected(problems, lambda: read_varied(args.vary, nodes)) or {}
    given = _collected(problems, lambda: read_values(args.reference, "--reference", nodes)) or {}
    budget = _collected(problems, lambda: _budget(args.budget)) or {}
    length = _collected(problems, lambda: _duration(args.duration))
    scene = _collected(problems, lambda: _scene(args))
    if args.file is None:
        problems.append(Problem("name a graph file: graph trade FILE --vary KEY=V1,V2,..."))
    if not args.vary:
        problems.append(Problem("give a knob to vary: --vary KEY=V1,V2,... (graph trade --list)"))
    if scene is not None:
        set_by = [("--fidelity", name, "knob") for name in varied if name in scene.fidelity]
        set_by += [("--set", name, "attribute") for name in overrides_of(varied) if name in scene.overrides]
        problems += [
            Problem(f"{flag} {name}: --vary has this {what} too; leave it out of one of them")
            for flag, name, what in set_by
        ]
    if args.repeat < 1:
        problems.append(Problem(f"--repeat {args.repeat}: give a number of runs, 1 or more"))
    if args.write and not args.budget:
        problems.append(Problem("--write writes the cheapest setting within a budget; give --budget METRIC=VALUE"))
    if args.write and (others := [name for name in varied if name not in KNOBS]):
        problems.append(Problem(f"--write writes fidelity knobs, not {', '.join(others)}; set it by hand"))
    if args.out:
        _collected(problems, lambda: check_folder(args.out))
    if args.write and args.file is not None and args.file.is_file():
        _collected(problems, lambda: check_writable(args.file))
    if problems or scene is None or length is None:
        raise UserError(problems)
    reference, *alternatives = references(varied, given)
    settings = plan_settings(varied, {name: reference[name] for name in varied} if args.one_at_a_time else None)
    return Study(
        scene,
        varied,
        settings,
        reference,
        budget,
        duration=length,
        repeat=args.repeat,
        others=tuple(alternatives),
        one_at_a_time=args.one_at_a_time,
    )


def _collected(problems: list[Problem], ask: Callable[[], Answer]) -> Answer | None:
    """What `ask` gives; None if it raises UserError, whose problems are added."""
    try:
        return ask()
    except UserError as error:
        problems += error.problems
        return None


def _node_names(args: argparse.Namespace) -> list[str]:
    """The names of the file's nodes; none if it cannot be read, which is said when it is opened."""
    from graph.files import examine
    from graph.session.overrides import node_names

    spec = examine(args.file, allow=args.allow, skip_outside=args.skip_outside).spec if args.file else None
    return node_names(spec) if spec is not None else []


def _scene(args: argparse.Namespace) -> Scene:
    from graph.cli.node_files import load_node_files

    from .study import Scene

    return Scene(
        file=args.file or Path(),
        allow=tuple(args.allow),
        skip_outside=args.skip_outside,
        skip_unknown=args.skip_unknown,
        allow_scripts=args.allow_scripts,
        settings=args.settings,
        fidelity=fidelity_of(args),
        overrides=overrides_of(args),
        play=tuple(args.play),
        limits=limits_of(args),
        seed=args.seed,
        prepare=functools.partial(load_node_files, tuple(args.node_files)),
    )


def _budget(options: list[str]) -> dict[str, float]:
    from .metrics import known_metric

    budget: dict[str, float] = {}
    problems: list[Problem] = []
    for option in options:
        name, equals, text = option.partition("=")
        try:
            if not equals:
                raise ValueError("write it as METRIC=VALUE")
            unit = known_metric(name).unit
            if name in budget:
                raise ValueError("the metric is given twice; leave one of them out")
            try:
                bound = float(text)
            except ValueError:
                bound = math.nan
            if not 0 <= bound < math.inf:
                raise ValueError(f"give a number{f' of {unit}' if unit else ''}, 0 or more")
            if not unit and known_metric(name).more and bound > 1:
                raise ValueError("it is a share; give a number from 0 to 1")
            budget[name] = bound
        except ValueError as error:
            problems.append(Problem(f"--budget {option}: {error}"))
    if problems:
        raise UserError(problems)
    return budget


def _duration(text: str) -> Any:
    try:
        length = exact_duration(text)
        if length <= 0:
            raise ValueError("give simulated seconds, more than 0")
    except ValueError as error:
        raise UserError(f"--duration {text}: {error}") from None
    return length


@contextmanager
def _progress(show: bool) -> Iterator[Callable[[int, int], None]]:
    if not show:
        yield lambda done, total: None
        return
    with counting("runs") as runs:
        yield lambda done, total: runs.update(runs.task_ids[0], completed=done, total=total)


# -- the answer --------------------------------------------------------------------------------------------------------


def write_files(outcome: Outcome, folder: Path) -> list[Path]:
    """Writes the files of a trade; returns them. Raises RunError if one cannot be written."""
    import json

    from .diagrams import overview, parts
    from .outputs import as_csv, as_dict
    from .page import page

    contents: dict[str, bytes] = {
        "trade.json": (json.dumps(as_dict(outcome), indent=2, ensure_ascii=False) + "\n").encode(),
        "trade.csv": as_csv(outcome).encode(),
        "trade.png": overview(outcome),
        "trade_parts.png": parts(outcome),
        "trade.html": page(outcome).encode(),
    }
    try:
        make_folder(folder)
        for name, content in contents.items():
            write(folder / name, content)
    except OSError as error:
        raise RunError(f"--out {folder}: {error.strerror}; the figures are above") from error
    return [folder / name for name in contents]


def _print(outcome: Outcome) -> None:
    from .outputs import block
    from .verdict import answer, remarks, summary

    _print_settings(outcome)
    said, chosen = answer(outcome)
    for line in (*summary(outcome), *remarks(outcome), *said):
        say(line)
    if chosen is not None:
        for line in block(outcome, chosen).splitlines():
            say(line)


def _print_settings(outcome: Outcome) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from graph.sim.fidelity import KNOBS

    from .study import label
    from .verdict import PAYS, UNRESOLVED, marked, values_in

    console = Console(width=None if sys.stdout.isatty() else 140)
    knobs = {
        name: max(len(text) for text in (label(name), *(values_in(row, name) for row in outcome.rows)))
        for name in outcome.knobs
    }
    attributes = any(name not in KNOBS for name in knobs)  # they change how often sensors tick
    if attributes:
        knobs["frames/s"] = len("frames/s")
    room = console.width - sum(knobs.values()) - len(knobs) - COSTS_WIDTH
    most = min(MOST_COLUMNS, room // COLUMN_WIDTH)
    names = outcome.shown[: max(1, most, len(outcome.study.budget))]
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in outcome.knobs:
        table.add_column(label(name), no_wrap=True)
    for name in (*(["frames/s"] if attributes else []), "cpu s/s", "wall s/s"):
        table.add_column(name, justify="right", no_wrap=True)
    for name in names:
        table.add_column(name.replace(".", ".\n"), justify="right", no_wrap=True)
    best = outcome.recommended
    for row in outcome.rows:
        cost, spread = row.cost, row.spread
        cells = [values_in(row, name) for name in outcome.knobs]
        if attributes:
            cells.append("" if row.frames is None else f"{row.frames:.4g}")
        if cost is None:
            cells += [row.status, ""]
        else:
            shares = (f" ±{spread.cpu:.0%}", f" ±{spread.wall:.0%}") if spread else ("", "")
            cells += [f"{cost.cpu:.3g}{shares[0]}", f"{cost.wall:.3g}{shares[1]}"]
        cells += (marked(outcome, row, name) for name in names)
        table.add_row(*map(Text, map(printable, cells)), style="bold" if row is best else None)
    console.print(table)
    say(PAYS)
    if any(outcome.unresolved(row, name) for row in outcome.rows for name in names):
        say(UNRESOLVED)


def _list(as_json: bool) -> int:
    """Prints the knobs and the metrics."""
    from graph.sim.fidelity import KNOBS
    from graph.sim.knob import word

    from .metrics import METRICS

    if as_json:
        knobs = {
            name: {
                "doc": knob.doc,
                "values": knob.values,
                "default": None if knob.default is None else word(knob.default),
                "cost": knob.cost,
                "error": knob.error,
                "why": knob.why,
                "finer": knob.finer,
            }
            for name, knob in KNOBS.items()
        }
        metrics = {name: {"unit": one.unit, "doc": one.doc, "needs": one.needs} for name, one in METRICS.items()}
        say_json({"knobs": knobs, "metrics": metrics})
        return 0
    rows = [
        (name, knob.values, "" if knob.default is None else word(knob.default), knob.cost, knob.error, knob.why)
        for name, knob in KNOBS.items()
    ]
    print_table(rows, ("knob", "values", "default", "cost", "error", "why this default"))
    say()
    print_table([(name, one.unit, one.doc) for name, one in METRICS.items()], ("metric", "unit", "meaning"))
    return 0
