"""`graph run`: plays a graph file and reports what its clocks, sensors and publishers did."""

from __future__ import annotations

import argparse
import gc
import json
import logging
import math
import shlex
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from fractions import Fraction
from io import TextIOWrapper
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import RunError, UserError
from graph.base.exact import duration as exact_duration
from graph.base.exact import rate, shortest
from graph.base.inputs import digest
from graph.base.limits import check
from graph.base.outputs import created, make_folder

from .arguments import (
    add_allow,
    add_live,
    add_nodes,
    add_overrides,
    add_play,
    add_remap,
    add_skip_outside,
    session_of,
)
from .interrupts import between_updates
from .printing import EXIT_INTERRUPTED, counted, page_width, say, say_json, tell
from .safe_log import SafeFormatter

if TYPE_CHECKING:
    from graph.session.open import Session
    from graph.sim.app import App

    from .output_folder import Output
    from .report import Report


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("file", metavar="FILE", type=Path, help="graph file (.yaml, .json or .usda)")
    parser.add_argument("--skip-unknown", action="store_true", help="leave nodes of unknown types out, with a warning")
    parser.add_argument(
        "--allow-scripts", action="store_true", help="run Python code that the file brings (ScriptNode)"
    )
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--updates", type=int, metavar="N", help="run N app updates")
    length.add_argument("--duration", metavar="S", help="run S seconds of updates (default: the file's, else 5)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write report.json and the recording into DIR")
    parser.add_argument(
        "--preview",
        nargs="?",
        const="1",
        metavar="HZ",
        help="write pictures of what each sensor sees into DIR/preview, HZ times a simulated second (default 1)",
    )
    parser.add_argument("--trace", type=Path, metavar="FILE", help="write a trace for ui.perfetto.dev to FILE (JSON)")
    add_play(parser)
    add_remap(parser)
    add_live(parser)
    add_overrides(parser)
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of every random stream (default 0)")
    parser.add_argument(
        "--device", metavar="NAME", help="cast rays on cuda, cuda:N or warp-cpu (`graph help gpu`); default cpu"
    )
    parser.add_argument("--stats", action="store_true", help="measure the time of each part of the updates")
    parser.add_argument("--realtime", action="store_true", help="pace updates to the wall clock")
    parser.add_argument("--json", action="store_true", help="print the report as JSON and nothing else on stdout")
    parser.add_argument(
        "--strict",
        action="store_true",
        help="exit 1 if a wired sensor or publisher was silent all the run, or a sensor missed ticks",
    )
    parser.add_argument(
        "--on-error",
        choices=("stop", "continue"),
        help="when a node raises (default: stop; continue in parity isaacsim-6.0.1, and for a saved USD scene with "
        "missing assets)",
    )
    add_nodes(parser)
    add_allow(parser)
    add_skip_outside(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command; returns its exit code."""
    from graph.recording.transports.targets import connect, read_targets
    from graph.session.message_sources import files_of, open_sources, play_into, remapping, warn_unheard
    from graph.session.meter import Meter, MeteredSink
    from graph.session.step_limit import check_steps
    from graph.sim.messages.bus import CountingSink
    from graph.sim.settings import suggestion
    from sensors.compiled.compile_time import COMPILING
    from sensors.compiled.kept import why_not_kept
    from sensors.writers.preview import Previews

    from .explain_clocks import MOST_PLANNED_UPDATES, plan_updates
    from .explain_traps import clock_traps
    from .frames import FrameSink
    from .idle_parts import strict_code, warn_at_end, warn_of_blind_sensors
    from .report import build_report

    show_log()
    targets = read_targets(args.live)
    sources = open_sources(args.play, remapping(args.remap))
    session = session_of(
        args, seed=args.seed, realtime=args.realtime, on_error=args.on_error, allow_scripts=args.allow_scripts
    )
    app = session.app
    updates = _number_of_updates(args, session)
    preview = _preview_rate(args)
    pictures: Previews | None = None
    counter, frames = CountingSink(), FrameSink()
    output: Output | None = None
    report: Report | None = None
    failures: list[BaseException] = []
    meter = Meter() if args.stats else None
    with ExitStack() as held:
        try:
            with ExitStack() as cleanup:
                cleanup.enter_context(app)
                tracing = cleanup.enter_context(ExitStack())
                app.bus.subscribe(counter)
                app.bus.subscribe(frames)
                player = play_into(app, sources) if sources else None
                live = [connect(app, target) for target in targets]
                for sink, target in zip(live, targets, strict=True):
                    tell(f"live {sink.name}: {sink.transport.place}{target.advice}")
                started, compiled, loops = time.perf_counter(), COMPILING.seconds, COMPILING.loops
                if meter is not None:
                    cleanup.enter_context(meter.watching())
                    meter.follow(app)
                # Physics is built here: a scene that cannot be simulated is refused before anything is written.
                app.play()
                check_steps(app)
                for warning in clock_traps(app, list(islice(plan_updates(app), min(updates, MOST_PLANNED_UPDATES)))):
                    app.warn(*warning)
                if args.out:
                    app.output_folder = args.out
                    output = _output(args, session, files_of(sources), held)
                    cleanup.callback(output.sink.close)
                    app.bus.subscribe(output.sink if meter is None else MeteredSink(output.sink, meter))
                    if preview:
                        pictures = Previews(app, args.out / "preview", preview)
                        cleanup.callback(pictures.close)
                if args.trace:
                    _trace(session, args.trace, tracing)
                try:
                    _advance(app, updates, show_progress=not args.json and sys.stderr.isatty())
                except (RunError, KeyboardInterrupt) as error:
                    failures.append(error)
                try:
                    app.tell_closing()
                except RunError as error:
                    failures.append(error)
                tracing.close()
                for sink in live:
                    sink.close()
                    for warning in sink.warnings():
                        app.warn(*warning)
                if player is not None:
                    warn_unheard(app, player)
                warn_of_blind_sensors(app)
                for path in args.settings:
                    if not app.settings.is_read(path) and suggestion(path) is None:
                        app.warn("setting-unread", path, "nothing in this run read it; correct it, or leave it out")
                missed = warn_at_end(app, session.runner, frames)
                wall, compiled = time.perf_counter() - started, COMPILING.seconds - compiled
                report = build_report(app, session.runner, counter, wall, live, meter, compiled, session.drawn)
        except RunError as error:  # raised while the recording was finished
            if report is None:
                raise
            failures.append(error)
        lines: list[str] = []
        if output is not None:
            try:
                lines = output.finish(report, well=not failures)
                failures += [output.failure] if output.failure else []
            except RunError as error:
                failures.append(error)
    if pictures is not None and pictures.files:
        lines.append(f"wrote {counted(len(pictures.files), 'pictures')} into {pictures.files[0].parent}")
    if loops := COMPILING.loops - loops:
        reason = why_not_kept()
        later = f"each run compiles again: {reason}; set TICKGRAPH_CACHE to a folder of your own" if reason else ""
        tell(f"compiled {counted(loops, 'loops')} in {compiled:.1f} s; {later or 'later runs find them compiled'}")
    _print(args, report, lines)
    if output is not None and output.sink.messages and not args.json:
        say(f"next: {shlex.join(('graph', 'view', str(args.out)))}")
    for failure in failures[1:]:
        if str(failure) != str(failures[0]):
            tell(f"graph: {failure}")
    if failures and isinstance(failures[0], KeyboardInterrupt):
        tell(f"interrupted after {report['updates']} of {updates} updates")
        return EXIT_INTERRUPTED
    if failures:
        raise failures[0]
    return strict_code(report["silent"], missed) if args.strict else 0


def _preview_rate(args: argparse.Namespace) -> Fraction | None:
    """Pictures a simulated second [Hz], or None. Raises UserError for a rate that cannot be, or without a folder."""
    if args.preview is None:
        return None
    if not args.out:
        raise UserError("--preview writes into the folder of --out; give one: --out DIR --preview")
    try:
        hertz = rate(args.preview)
        if hertz <= 0:
            raise ValueError("pictures need a rate above 0")
        return hertz
    except ValueError as error:
        raise UserError(f"--preview {args.preview}: {error}; give a number of Hz, such as 1") from None


def _print(args: argparse.Namespace, report: Report, lines: list[str]) -> None:
    """Prints what the run did, what it wrote (`lines`), and its warnings."""
    from .report import table_of, warning_lines

    if args.json:
        say_json(report)
    else:
        for line in table_of(report, page_width(sys.stdout)):
            say(line)
    for line in lines:
        (tell if args.json else say)(line)
    for line in warning_lines(report):
        tell(line)


def _output(args: argparse.Namespace, session: Session, played: list[Path], held: ExitStack) -> Output:
    """The output files, in a folder that only this run holds until it ends."""
    from .output_folder import held_output

    read = (args.file, *args.play, *played)
    return held_output(held, args.out, session.spec.record, read, _provenance(args, session.app))


def show_log() -> None:
    """Prints the nodes' log on stderr immediately; warnings are counted and printed at the end of the run."""
    log = logging.getLogger("tickgraph")
    if not log.handlers:
        handler = logging.StreamHandler()
        handler.setFormatter(SafeFormatter())
        log.addHandler(handler)
        log.setLevel(logging.INFO)
        counted = logging.getLogger("tickgraph.warnings")
        counted.propagate = False
        counted.addHandler(logging.NullHandler())


def _number_of_updates(args: argparse.Namespace, session: Session) -> int:
    updates = _updates_asked_for(args, session)
    given = f"--duration {args.duration}" if args.duration is not None else "duration of the file"
    asked = f"--updates {args.updates}" if args.updates is not None else given
    check("run.updates", updates, f"{asked}: too many updates")
    return updates


def _updates_asked_for(args: argparse.Namespace, session: Session) -> int:
    from .explain_clocks import duration_of

    if args.updates is not None:
        if args.updates < 0:
            raise UserError(f"--updates {args.updates}: give a number of updates, 0 or more")
        return int(args.updates)
    if args.duration is None:
        length = duration_of(session)
    else:
        try:
            length = exact_duration(args.duration)
        except ValueError as error:
            raise UserError(f"--duration: {error}") from None
    if length < 0:
        raise UserError(f"--duration {args.duration}: give a duration in seconds, 0 or more")
    return math.ceil(length * session.app.loop_rate)


def _provenance(args: argparse.Namespace, app: App) -> dict[str, str]:
    """Where the recording comes from, and its clocks, without anything that differs between two equal runs.

    Settings are left out: some, such as the number of threads, do not change the recording.
    """
    from .main import version

    options = {"fidelity": args.fidelity, "set": args.set, "nodes": [file.name for file in args.node_files]}
    said = {
        "file": args.file.name,
        "sha256": digest(args.file),
        "seed": str(args.seed),
        "version": version(),
        "loop_hz": shortest(app.loop_rate),
        "physics_hz": shortest(app.simulation.steps_per_second),
    }
    return said | {name: json.dumps(given) for name, given in options.items() if given}


def _trace(session: Session, path: Path, cleanup: ExitStack) -> None:
    from graph.session.tracing import Tracer

    try:
        make_folder(path.parent)
        stream = TextIOWrapper(created(path), encoding="utf-8")
    except OSError as error:
        raise UserError(f"--trace {path}: {error.strerror}; name a file that can be written") from None
    cleanup.callback(Tracer(session.app, session.runner.graphs.values(), stream).close)


def _advance(app: App, updates: int, *, show_progress: bool) -> None:
    from graph.sim.scene.diagnostics import reading
    from graph.sim.scene.stage_metadata import scene_name

    damage = reading(scene_name(app.stage), RunError)
    with damage, between_updates() as interrupted, _progress(updates, show_progress) as advance, ExitStack() as end:
        for number in range(updates):
            app.update()
            advance()
            if number == 0:
                # What is built by now stays: each search for cycles among it would stop the run for about 10 ms.
                gc.freeze()
                end.callback(gc.unfreeze)
            if interrupted:
                raise KeyboardInterrupt
            if app.exit_requested:
                break


@contextmanager
def _progress(updates: int, show: bool) -> Iterator[Any]:
    if not show:
        yield lambda: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, ProgressColumn, Task, TaskProgressColumn, TimeRemainingColumn
    from rich.text import Text

    from sensors.compiled.compile_time import COMPILING

    class Doing(ProgressColumn):
        def render(self, task: Task) -> Text:
            return Text(f"compiling, {counted(COMPILING.left, 'loops')} left" if COMPILING.left else "updates")

    def running() -> float:
        """Time without compiling [s], so that it does not count in the remaining time."""
        return time.perf_counter() - COMPILING.elapsed

    columns = (Doing(), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True, get_time=running) as bar:
        task = bar.add_task("updates", total=updates)
        yield lambda: bar.advance(task)
