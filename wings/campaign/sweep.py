"""`graph sweep`: runs graph files at many points, each in a process of its own, into one table."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from graph.base.errors import Problem, RunError, UserError
from graph.base.work import usable_cores
from graph.cli.arguments import add_allow, add_nodes, add_overrides, add_play, add_skip_outside, check_folder
from graph.cli.interrupts import between_updates
from graph.cli.printing import EXIT_INTERRUPTED, counted, say, say_json, tell
from graph.cli.progress import counting

from .conduct import OK, Executor, Limits, State, conduct, is_due
from .folder import Folder
from .launcher import Launcher
from .points import FILE, arguments_of
from .specification import Campaign, difference, hashes_of, load, save, text_of

SOME_FAILED = 1
MOST_REHEARSED = 4
"""Most files of which the beginning is played before runs are started."""
SIZES = {"": 1, "k": 10**3, "m": 10**6, "g": 10**9, "ki": 2**10, "mi": 2**20, "gi": 2**30}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("files", metavar="FILE", nargs="*", type=Path, help="graph files, or one campaign file (.yaml)")
    parser.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="KEY=V1,V2,...",
        help="values of a key (an option, a knob, NODE.ATTR, /PRIM/PATH.ATTR, a setting), a range as seed=0..99, or "
        "draws such as x=uniform(0,1)*20; repeated: every combination is run",
    )
    parser.add_argument("--points", type=Path, metavar="FILE.csv", help="points from a table: keys in its first line")
    parser.add_argument("--vary-seed", type=int, default=0, metavar="N", help="seed of the values that --vary draws")
    parser.add_argument("--metric", action="append", default=[], metavar="NAME=EXPR", help="a column of the table, "
                        "such as far=max(topic('/odom').pose.pose.position.x); may be repeated")  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of the campaign")
    parser.add_argument("--jobs", type=int, metavar="N", help="runs at a time (default: the cores of this machine)")
    parser.add_argument("--cluster", metavar="ADDRESS", help="run on the Dask cluster of this scheduler, such as "
                        "tcp://127.0.0.1:8786 or tls://host:8786 (pip install 'tickgraph[cluster]')")  # fmt: skip
    parser.add_argument(
        "--transfer",
        choices=("shared", "upload"),
        default="shared",
        help="how files reach the cluster: shared, at the same paths everywhere (default), or upload, with the runs",
    )
    parser.add_argument("--timeout", type=float, default=0.0, metavar="S", help="wall time at which a run is ended [s]")
    parser.add_argument("--memory", default="", metavar="SIZE", help="memory at which a run is ended, such as 4G")
    parser.add_argument("--retries", type=int, default=0, metavar="N", help="start a failed run again, N times at most")
    parser.add_argument(
        "--max-failures", type=int, default=0, metavar="N", help="start no further run after N failed ones"
    )
    parser.add_argument("--resume", action="store_true", help="go on with the campaign of DIR: run what is missing")
    parser.add_argument("--plan", action="store_true", help="write the campaign into DIR and run nothing: for --index")
    parser.add_argument("--missing", action="store_true", help="print the runs of DIR that are missing, such as 0-3,7; "
                        "with --retries also failed ones")  # fmt: skip
    parser.add_argument("--index", type=int, metavar="N", help="run number N of the campaign of DIR, and no other: for "
                        "the array jobs of a batch system; the table is written by --resume")  # fmt: skip
    parser.add_argument("--report", action="store_true", help="draw the table: DIR/campaign.html; with --out alone, of "
                        "a campaign that is there")  # fmt: skip
    parser.add_argument("--duration", metavar="S", help="simulated seconds of each run (default: the file's, else 5)")
    parser.add_argument("--updates", type=int, metavar="N", help="app updates of each run")
    parser.add_argument("--skip-unknown", action="store_true", help="leave nodes of unknown types out, with a warning")
    parser.add_argument(
        "--allow-scripts", action="store_true", help="run Python code that the file brings (ScriptNode)"
    )
    parser.add_argument("--json", action="store_true", help="print how the campaign ended as JSON on stdout")
    add_play(parser)
    add_overrides(parser)
    add_nodes(parser)
    add_allow(parser)
    add_skip_outside(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command; returns its exit code."""
    if args.out is None:
        raise UserError("a campaign needs a folder; give one: --out DIR")
    folder = Folder(args.out)
    earlier = load(args.out)
    if args.missing or args.index is not None:
        if earlier is None:
            raise UserError(f"there is no campaign in {args.out}; begin it with --plan")
        return _missing(args, earlier, folder) if args.missing else _one(args, earlier, folder)
    if not args.files and not args.resume and args.points is None:
        return _report_alone(args, folder, earlier)
    limits = _limits(args)
    campaign = _campaign(args, earlier)
    check_folder(args.out)
    with ExitStack() as held:
        from graph.cli.output_folder import held_folder

        held.enter_context(held_folder(args.out, "let that campaign end, or name another folder"))
        folder.tidy()
        if earlier is None:
            try:
                save(campaign, args.out)
            except OSError as error:
                raise RunError(f"{args.out}: {error.strerror}") from error
        if args.plan:
            say(f"planned {counted(len(campaign.points), 'runs')} in {args.out}")
            return 0
        state, received = _conduct(args, campaign, folder, limits, held)
        try:
            files = _written(campaign, folder, page=args.report)
        except OSError as error:
            raise RunError(f"{args.out}: {error.strerror}; make space and go on with --resume") from error
    return _answer(args, state, files, interrupted=bool(received))


def _conduct(
    args: argparse.Namespace, campaign: Campaign, folder: Folder, limits: Limits, held: ExitStack
) -> tuple[State, list[int]]:
    with between_updates() as received:
        tell_state = held.enter_context(_progress(args, campaign))
        executor = held.enter_context(_executor(args, campaign, limits))
        try:
            state = conduct(campaign, folder, executor, limits, interrupted=lambda: bool(received), tell=tell_state)
        except KeyboardInterrupt:
            state = State(len(campaign.points))
            state.done = sum(folder.result(campaign.name_of(one)) is not None for one in range(state.total))
            received.append(0)
    return state, received


def _answer(args: argparse.Namespace, state: State, files: list[Path], *, interrupted: bool) -> int:
    if args.json:
        say_json(
            {"runs": state.total, "done": state.done, "failed": state.failed, "files": [str(one) for one in files]}
        )
    else:
        say(f"{state.done:,} of {counted(state.total, 'runs')} done, {state.failed:,} failed")
        say(f"wrote {', '.join(map(str, files))}")
    if interrupted:
        tell(f"interrupted; graph sweep --resume --out {args.out} goes on")
        return EXIT_INTERRUPTED
    if state.why_stopped:
        tell(f"graph: stopped: {state.why_stopped}")
    return SOME_FAILED if state.failed or state.why_stopped else 0


# -- what is asked -----------------------------------------------------------------------------------------------------


def _limits(args: argparse.Namespace) -> Limits:
    problems = []
    if args.jobs is not None and args.jobs < 1:
        problems.append(f"--jobs {args.jobs}: give a number of runs, 1 or more")
    if not 0 <= args.timeout < 10**9:
        problems.append(f"--timeout {args.timeout:g}: give seconds, more than 0")
    for name, number in (("retries", args.retries), ("max-failures", args.max_failures)):
        if number < 0:
            problems.append(f"--{name} {number}: give a number, 0 or more")
    memory = 0
    try:
        memory = _size(args.memory)
    except ValueError:
        problems.append(f"--memory {args.memory}: give bytes, such as 4G or 500M")
    if problems:
        raise UserError([Problem(one) for one in problems])
    jobs = args.jobs or (0 if args.cluster else usable_cores())
    return Limits(jobs, args.timeout, memory, args.retries, args.max_failures)


def _size(text: str) -> int:
    """A size in bytes: `4G`, `500M`, `2GiB`. Raises ValueError."""
    if not text:
        return 0
    number = text.rstrip("bBiIkKmMgG")
    unit = text[len(number) :].lower().removesuffix("b")
    if unit not in SIZES or float(number) <= 0:
        raise ValueError
    return int(float(number) * SIZES[unit])


def _campaign(args: argparse.Namespace, earlier: Campaign | None) -> Campaign:
    """The campaign of the command line, or of the folder. Raises UserError if they differ."""
    if earlier is None and args.resume and not args.files and args.points is None:
        raise UserError(f"--resume: there is no campaign in {args.out}")
    if earlier is not None and not args.resume:
        raise UserError(f"--out {args.out} holds a campaign; go on with it by --resume, or name another folder")
    if earlier is not None and not args.files and args.points is None:
        _check_unchanged(earlier)
        return earlier
    from .asked import new_campaign

    campaign = new_campaign(args)
    if earlier is not None and (changed_by := difference(earlier, campaign)):
        raise UserError(f"--resume: this is not the campaign of {args.out}: {changed_by}; begin another elsewhere")
    return campaign


def _check_unchanged(campaign: Campaign) -> None:
    """Raises UserError if a file of a campaign is another by now, or is not seen from here."""
    if absent := [file for file in campaign.hashes if not Path(file).is_file()]:
        raise UserError(f"{', '.join(absent)}: no such file; start the command where the campaign began")
    changed = [file for file, known in hashes_of([*campaign.hashes]).items() if campaign.hashes[file] != known]
    if changed:
        raise UserError(f"{', '.join(changed)} has changed since the campaign began; begin another")


# -- running -----------------------------------------------------------------------------------------------------------


@contextmanager
def _executor(args: argparse.Namespace, campaign: Campaign, limits: Limits) -> Iterator[Executor]:
    firsts = {point[FILE]: point for point in reversed(campaign.points)}
    long = len(campaign.points) > 2 * len(firsts)
    chosen = [*firsts.values()][:MOST_REHEARSED] if long else []
    rehearsed = [arguments_of(point, campaign.common) for point in chosen]
    if args.cluster:
        from .cluster import UPLOAD, Cluster, Upload, require_distributed

        require_distributed()
        upload = None
        if args.transfer == UPLOAD:
            folders = [*(Path(file).parent for file in firsts), *args.allow]
            upload = Upload(folders, [*args.node_files, *args.play], args.out)
        with Cluster(args.cluster, campaign.hashes, rehearsed, upload) as cluster:
            yield cluster
        return
    with Launcher(rehearsed, play=2 * limits.jobs > usable_cores()) as launcher:
        yield launcher


@contextmanager
def _progress(args: argparse.Namespace, campaign: Campaign) -> Iterator[Callable[[State], None]]:
    """Tells of failed runs as they come, and on a terminal how many runs are done and the time left."""

    def failed(state: State) -> str:
        last = state.last
        if not last or last["status"] == OK:
            return ""
        point = {key: campaign.points[last["number"]].get(key, "") for key in campaign.varied}
        return f"run {campaign.name_of(last['number'])} {last['status']}: {text_of(point)}: {last['why']}"

    if args.json or not sys.stderr.isatty():
        began = time.monotonic()
        shown = [began]

        def line(state: State) -> None:
            if text := failed(state):
                tell(text)
            now = time.monotonic()
            if now - shown[0] >= 30 and state.done > state.kept:
                shown[0] = now
                left = (now - began) / (state.done - state.kept) * (state.total - state.done)
                tell(f"{state.done:,} of {state.total:,} runs, {state.failed:,} failed, about {left:.0f} s left")

        yield line
        return
    with counting("runs", len(campaign.points)) as runs:

        def show(state: State) -> None:
            if text := failed(state):
                runs.console.print(text, markup=False, highlight=False)
            runs.update(runs.task_ids[0], completed=state.done, total=state.total)

        yield show


def _missing(args: argparse.Namespace, campaign: Campaign, folder: Folder) -> int:
    """Prints the numbers of the runs that are missing, as an array job takes them; with --retries also failed ones."""
    limits, numbers = _limits(args), range(len(campaign.points))
    missing = [one for one in numbers if is_due(folder.result(campaign.name_of(one)), limits)]
    spans: list[list[int]] = []
    for number in missing:
        if spans and number == spans[-1][1] + 1:
            spans[-1][1] = number
        else:
            spans.append([number, number])
    say(",".join(str(first) if first == last else f"{first}-{last}" for first, last in spans))
    return 0


def _one(args: argparse.Namespace, campaign: Campaign, folder: Folder) -> int:
    """One run of a campaign that others make at the same time: they share its lock, and no table is written."""
    if not 0 <= args.index < len(campaign.points):
        raise UserError(f"--index {args.index}: the campaign has the runs 0 to {len(campaign.points) - 1}")
    limits, name = _limits(args), campaign.name_of(args.index)
    if is_due(folder.result(name), limits):
        from graph.cli.output_folder import locked

        _check_unchanged(campaign)
        wait = "let that campaign end"
        with locked(args.out, wait, shared=True), between_updates() as received, Launcher() as launcher:
            state = conduct(campaign, folder, launcher, limits, only=[args.index], interrupted=lambda: bool(received))
        if state.why_stopped:
            raise RunError(state.why_stopped)
    result = folder.result(name)
    assert result is not None
    say(f"run {name} {result['status']}{result['why'] and ': ' + result['why']}")
    return 0 if result["status"] == OK else SOME_FAILED


# -- the report --------------------------------------------------------------------------------------------------------


def _report_alone(args: argparse.Namespace, folder: Folder, campaign: Campaign | None) -> int:
    if campaign is None:
        raise UserError("name a graph file or a campaign file: graph sweep FILE --vary KEY=V1,V2,... --out DIR")
    if not args.report:
        raise UserError(f"{args.out} holds a campaign; give --resume to go on with it, or --report to draw its table")
    try:
        files = _written(campaign, folder, page=True)
    except OSError as error:
        raise RunError(f"{args.out}: {error.strerror}") from error
    say(f"wrote {', '.join(map(str, files))}")
    return 0


def _written(campaign: Campaign, folder: Folder, *, page: bool) -> list[Path]:
    """Writes the tables and, if asked, the page; returns the files. Raises OSError."""
    from .page import write_page
    from .table import write_tables

    return write_tables(campaign, folder) + (write_page(campaign, folder) if page else [])
