"""`graph exec`: runs an Isaac Sim script, unchanged, over an App, and reports what happened."""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from contextlib import ExitStack, redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import RunError, UserError
from graph.base.inputs import digest
from graph.base.limits import check

from .arguments import add_allow, add_fidelity, add_live, check_folder, fidelity_of
from .printing import EXIT_INTERRUPTED, counted, page_width, say, say_json, tell

if TYPE_CHECKING:
    from graph.isaac.managers.app import App
    from graph.isaac.script import Script, ScriptError

    from .report import Report

OF_A_PLAY = (
    "physics_steps",
    "simulation_time",
    "timeline_time",
    "external_time",
    "real_time_factor",
    "sensors",
    "silent",
)
"""What a report says of the last play, if the script has stopped it."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.usage = "graph exec [options] SCRIPT.py [ARGS...]"
    parser.add_argument("script", metavar="SCRIPT.py", type=Path, help="Isaac Sim script; what follows are its own")
    parser.add_argument(
        "--updates", type=int, metavar="N", help="end loops after N app updates: is_running() is then False"
    )
    parser.add_argument("--play", action="store_true", help="press Play after a snippet's last line; needs --updates")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write report.json and the recording into DIR")
    parser.add_argument("--json", action="store_true", help="print the report as JSON; the script prints on stderr")
    parser.add_argument(
        "--strict",
        action="store_true",
        help="refuse names that do nothing here; exit 1 for silent parts, missed ticks, failed nodes and caught errors",
    )
    parser.add_argument("--parity", choices=("documented", "isaacsim-6.0.1"), default="documented", help="the profile")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of every random stream (default 0)")
    parser.add_argument("--realtime", action="store_true", help="pace updates to the wall clock")
    parser.add_argument("--rclpy", action="store_true", help="let the script import an rclpy over the message bus")
    add_fidelity(parser)
    add_live(parser)
    add_allow(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command; returns its exit code."""
    from graph.isaac.run import Run
    from graph.isaac.script import Script, ScriptError

    from .run import show_log

    show_log()
    if args.updates is not None:
        if args.updates < 0:
            raise UserError(f"--updates {args.updates}: give a number of updates, 0 or more")
        check("run.updates", args.updates, f"--updates {args.updates}: too many updates")
    elif args.play:
        raise UserError("--play: add --updates N, the number of updates to play for")
    if args.out:
        check_folder(args.out)
    script = Script(args.script, args.arguments)
    with ExitStack() as held:
        reporting = _Reporting(args, script, held)
        one = Run(
            reporting.make,
            updates=args.updates,
            strict=args.strict,
            opened=reporting.opened,
            closing=reporting.closing,
            stuck=reporting.stuck,
            notes=lambda code, where, message: tell(f"warning {code}: {where}: {message}"),
            rclpy=args.rclpy,
            play=args.play,
        )
        failure: ScriptError | None = None
        interrupted = False
        code = 0
        with redirect_stdout(sys.stderr) if args.json else ExitStack():
            try:
                code = script.run(one)
            except ScriptError as error:
                failure = error
            except KeyboardInterrupt:
                interrupted = True
            finally:
                one.close()
        sys.stdout.flush()
        reporting.finish(well=failure is None and not interrupted)
    for line in script.caught:
        tell(f"caught by the script: {line}")
    if failure is not None:
        if args.debug:
            import traceback

            traceback.print_exception(failure.cause)
        tell(f"graph: {failure}")
        return 2 if isinstance(failure.cause, UserError) and reporting.report is None else 1
    if interrupted:
        tell("interrupted")
        return EXIT_INTERRUPTED
    if reporting.report is None:
        tell("the script made no application: nothing was simulated")
    elif one.from_editor and not reporting.played:
        tell("the snippet never played the timeline: --play --updates N plays it for N updates")
    if args.strict:
        from .idle_parts import strict_code

        if script.caught:
            tell(f"strict: the script caught {counted(len(script.caught), 'errors')}")
        report: Report = reporting.report or {"silent": (), "warnings": ()}
        failed = [f"{one['where']}: {one['message']}" for one in report["warnings"] if one["code"] == "compute-failed"]
        silent = strict_code([*failed, *report["silent"]], reporting.missed)
        return code or int(bool(script.caught or silent))
    return code


class _Reporting:
    """What a run of a script leaves behind: recording, report, table."""

    def __init__(self, args: argparse.Namespace, script: Script, held: ExitStack) -> None:
        self.report: Report | None = None
        self._last: Report | None = None
        self._args, self._script, self._held = args, script, held
        self._output: Any = None
        self._failures: list[RunError] = []
        self.played = False
        self.missed: list[tuple[str, str, str]] = []
        """Warnings of sensors that missed ticks."""

    def make(self, **options: Any) -> App:
        """The App of the script."""
        from graph.isaac.managers.app import App
        from graph.session.runner import GraphRunner
        from graph.sim.settings import FLAT_SCAN_NEEDS_2D, NODE_ERRORS_STOP
        from graph.sim.timing.run_loop import RealClock

        args = self._args
        scene = options.pop("stage", None)
        as_in_kit = {NODE_ERRORS_STOP: False, FLAT_SCAN_NEEDS_2D: False}
        settings = {**as_in_kit, **options.pop("settings", {}), **args.settings}
        app = App(
            settings=settings,
            parity=args.parity,
            fidelity=fidelity_of(args),
            seed=args.seed,
            wall_clock=RealClock() if args.realtime else None,
            when_playing="recompile",
            allow=args.allow,
            **options,
        )
        self.runner = GraphRunner(app, [], scripts="run", asked=True)
        if scene is not None:
            from graph.isaac import saving
            from graph.isaac.kit import kit_of
            from graph.session.restage import open_scene

            open_scene(app, scene, args.allow)
            kit_of(app).stage_url = str(scene)
            saving.opened(app.stage, scene)
        from graph.isaac.viewports import author_cameras

        author_cameras(app.stage)
        return app

    def opened(self, app: App) -> None:
        """The App is there: counts and records what it publishes from now on."""
        from graph.sim.messages.bus import CountingSink

        from .frames import FrameSink

        self._started = time.perf_counter()
        self._counter, self._frames = CountingSink(), FrameSink()
        app.bus.subscribe(self._counter)
        app.bus.subscribe(self._frames)
        app.on("stopping", lambda: self._keep(app))
        app.on("play", self._note_play)
        self._live = self._connected(app) if self._args.live else []
        out = self._args.out
        if out:
            app.output_folder = out
            self._output = self._files(app, out)
            app.bus.subscribe(self._output.sink)

    def _note_play(self) -> None:
        self.played = True

    def _connected(self, app: App) -> list[Any]:
        """The sinks of --live, each said."""
        from graph.recording.transports.targets import connect, read_targets

        sinks = []
        for target in read_targets(self._args.live):
            sinks.append(connect(app, target))
            tell(f"live {sinks[-1].name}: {sinks[-1].transport.place}{target.advice}")
        return sinks

    def _keep(self, app: App) -> None:
        """Keeps what the sensors did in the play that ends now: many scripts stop before they close."""
        if app.external_time > 0:
            self._last = self._built(app)

    def _built(self, app: App) -> Report:
        from .report import build_report

        wall = time.perf_counter() - self._started
        return build_report(app, self.runner, self._counter, wall, self._live)

    def closing(self, app: App) -> None:
        """The App is about to be closed: makes the report."""
        from .idle_parts import warn_at_end, warn_of_blind_sensors

        try:
            app.tell_closing()
        except RunError as error:
            self._failures.append(error)
        for sink in self._live:
            sink.close()
            for warning in sink.warnings():
                app.warn(*warning)
        warn_of_blind_sensors(app)
        self.missed = warn_at_end(app, self.runner, self._frames)
        self.report = self._built(app)
        if self._last is not None and app.timeline.is_stopped():
            self.report |= {key: self._last[key] for key in OF_A_PLAY}

    def stuck(self, code: int) -> None:
        """Ends the process of a script that catches its end again and again."""
        self.finish(well=True)
        tell("the script caught its own end (a bare `except:`); the process ends here")
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(code)

    def finish(self, *, well: bool) -> None:
        """Writes the report, and prints the table."""
        from .report import table_of, warning_lines

        if self.report is None:
            return
        if self._output is not None:
            self._output.sink.close()
        if self._script.caught:
            self.report["caught"] = self._script.caught
        lines = [] if self._output is None else self._output.finish(self.report, well=well)
        if self._args.json:
            say_json(self.report)
        else:
            for line in table_of(self.report, page_width(sys.stderr)):
                say(line, sys.stderr)
        for line in (*lines, *warning_lines(self.report)):
            tell(line)
        for failure in self._failures:
            tell(f"graph: {failure}")

    def _files(self, app: App, out: Path) -> Any:
        from graph.spec.file_spec import RecordSpec

        from .main import version
        from .output_folder import held_output

        provenance = {
            "file": self._args.script.name,
            "sha256": digest(self._args.script),
            "seed": str(self._args.seed),
            "version": version(),
            "arguments": json.dumps(self._args.arguments),
        }
        return held_output(self._held, out, RecordSpec(), (self._args.script,), provenance)
