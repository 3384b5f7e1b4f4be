"""`graph explain`: what a graph file will do, and when: clocks, ticks, consumers, and traps."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from graph.base.exact import shortest
from graph.base.shorten import listed

from .arguments import add_allow, add_nodes, add_overrides, add_skip_outside, session_of
from .printing import aligned, counted, say, say_json

MOST_CYCLES = 5
"""Most cycles of one graph that are shown."""
MOST_LEFT_OUT = 3
"""Most names that are shown of what is left out for one reason."""
MOST_NAMES = 12
"""Most nodes of one chain that are shown."""


PAGES = {"OmniLidar": "lidar", "OmniRadar": "radar", "Camera": "camera"}
"""The page of the manual about each type of sensor prim; those of all others are other-sensors."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("file", metavar="FILE", type=Path, help="graph file (.yaml, .json or .usda)")
    parser.add_argument("--json", action="store_true", help="print it as JSON; exact fractions are text")
    parser.add_argument("--skip-unknown", action="store_true", help="leave nodes of unknown types out, with a warning")
    add_overrides(parser)
    add_nodes(parser)
    add_allow(parser)
    add_skip_outside(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command. It runs the first updates, but casts no rays."""
    from .explanation import explain
    from .safe_log import quiet_warnings

    with quiet_warnings():
        session = session_of(args, on_error="continue")
        with session.app:
            told = explain(session, args.file)
    if args.json:
        say_json(told, default=exact)
    else:
        for line in as_text(told):
            say(line)
    return 0


def exact(number: Fraction) -> int | str:
    """A fraction as JSON can hold it: a whole number, else text such as "8/3"."""
    return number.numerator if number.denominator == 1 else str(number)


def as_text(told: Mapping[str, Any]) -> Iterator[str]:
    """The lines of text output."""
    yield f"{told['file']}: {shortest(told['duration_s'])} s, {told['updates']:,} updates"
    counted = told["counted_updates"]
    span = f"{shortest(told['duration_s'])} s" if counted == told["updates"] else f"the first {counted:,} updates"
    yield ""
    yield from _clocks(told["clocks"])
    if told["physics"]:
        yield ""
        yield from _physics(told["physics"])
    if told["graphs"]:
        yield ""
        yield from _graphs(told["graphs"])
    for sensor in told["sensors"]:
        yield ""
        yield from _sensor(sensor, span)
    if told["topics"]:
        yield ""
        yield from _topics(told["topics"])
    if told["left_out"]:
        yield ""
        yield from _left_out(told["left_out"])
    yield ""
    yield "traps" if told["traps"] else "traps: none seen"
    for trap in told["traps"]:
        yield f"  {trap['code']}: {trap['where']}: {trap['message']}"
    yield ""
    yield f"more: {', '.join(f'graph help {topic}' for topic in _pages(told))}"


def _pages(told: Mapping[str, Any]) -> Iterator[str]:
    """The pages of the manual about the parts of a file."""
    yield "clocks"
    if told["physics"]:
        yield "physics"
    types = {sensor["type"] for sensor in told["sensors"]}
    yield from (PAGES[one] for one in PAGES if one in types)
    if types - PAGES.keys():
        yield "other-sensors"


def _clocks(clocks: Mapping[str, Any]) -> Iterator[str]:
    step, every = clocks["timeline_step_s"], clocks["timeline_every_updates"]
    moves = "each update" if every == 1 else f"every {every} updates"
    per_loop = clocks["timeline_per_loop"]
    ratio = "" if per_loop == 1 else f", {shortest(per_loop)} x loop time"
    yield "clocks"
    rows = [
        ("loop", f"{shortest(clocks['loop_hz'])} Hz"),
        ("timeline", f"moves {shortest(step)} s {moves}{ratio}"),
        ("physics", f"{shortest(clocks['physics_hz'])} Hz, {_steps(clocks['substeps_per_update'])} an update"),
        ("substeps", f"{' '.join(map(str, clocks['substeps']))}  in updates 0 to {len(clocks['substeps']) - 1}"),
    ]
    if clocks["most_substeps"] is not None:
        rows.append(("cap", f"at most {_steps(Fraction(clocks['most_substeps']))} an update (minFrameRate)"))
    if steps := clocks["warm_up_steps"]:
        ahead = shortest(steps / clocks["physics_hz"])
        rows.append(("warm-up", f"{_steps(Fraction(steps))} at play: physics stays {ahead} s ahead of the timeline"))
    if clocks["sim_per_wall"] != 1:
        lasts, speed = shortest(clocks["update_lasts_s"]), shortest(clocks["sim_per_wall"])
        rows.append(("wall", f"an update lasts {lasts} s: physics runs at {speed} x wall time"))
    if not clocks["multi_tick"]:
        rows.append(("sensors", "follow the loop's time since the App was made: multi-tick rendering is off"))
    if clocks["frames_later"]:
        rows.append(("frames", "are delivered in the update after the one that renders them"))
    yield from aligned(rows)


def _physics(physics: Mapping[str, Any]) -> Iterator[str]:
    yield "physics"
    bodies = "1 body" if physics["bodies"] == 1 else f"{physics['bodies']:,} bodies"
    counts = [counted(physics[what], what) for what in ("joints", "drives") if physics.get(what)]
    rows = [("engine", f"{physics['engine']}: {', '.join([bodies, *counts])}")]
    if "integrator" in physics:
        cones = f"{physics['cone']} cones, impratio {physics['impratio']:g}"
        solver = f"{physics['solver']} of at most {physics['iterations']} iterations"
        rows.append(("options", f"{physics['integrator']}, {solver}, {cones}"))
    yield from aligned([*rows, *(("error", line) for line in physics["advice"])])


def _graphs(graphs: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    yield "graphs"
    for graph in graphs:
        size = ", ".join(counted(graph[what], what) for what in ("nodes", "connections"))
        yield f"  {graph['path']}  {graph['evaluator']}, {graph['stage']}: {size}"
        chain = graph["longest_chain"]
        rows = [("chain", f"longest, {len(chain):,} nodes: {_shown(chain)}")] if len(chain) > 1 else []
        rows += [("cycle", _shown(cycle)) for cycle in graph["cycles"][:MOST_CYCLES]]
        for line in aligned(rows):
            yield f"  {line}"


def _shown(names: Sequence[str]) -> str:
    """Names joined by arrows, with the middle of a long list left out."""
    half = MOST_NAMES // 2
    return " -> ".join(names if len(names) <= MOST_NAMES else (*names[:half], "...", *names[-half:]))


def _sensor(sensor: Mapping[str, Any], span: str) -> Iterator[str]:
    from sensors.sensor_types import sensor_type

    from .explain_sensors import RULES

    yield f"{sensor['path']} ({sensor['type']})"
    kind = sensor_type(sensor["type"])
    rows = list(kind.rows(sensor)) if kind else []
    if kind and kind.read_by:
        yield from aligned([*rows, ("product", f"not rendered: {kind.read_by} reads it")])
        return
    if not sensor["product"]:
        makers = ", ".join(sensor["made_by"])
        rows.append(("product", f"none so far: {makers} made none" if makers else "none: nobody renders it"))
        yield from aligned(rows)
        return
    made = f"since {shortest(sensor['exists_from_s'])} s, made in update {sensor['made_in_update']}"
    rows.append(("product", f"{made} by {', '.join(sensor['made_by']) or sensor['product']}"))
    rows.append(("rule", {**RULES, **(kind.rules if kind else {})}[sensor["rule"]]))
    ticks = [f"{_seconds(tick['stamp_ns'])} (update {tick['update']})" for tick in sensor["first_ticks"]]
    more = ", ..." if sensor["frames"] > len(ticks) else ""
    rows.append(("stamps", ", ".join(ticks) + more if ticks else "none in this time"))
    missed = f", and {sensor['missed']:,} ticks missed" if sensor["missed"] else ""
    rows.append(("frames", f"{sensor['frames']:,} in {span}{missed}"))
    rows.append(("computes", " ".join(sensor["channels"]) or "nothing"))
    for name, asked in sensor["consumers"].items():
        only = "  (while it has a subscriber)" if asked["needs_subscriber"] else ""
        rows.append(("for", f"{name}: {' '.join(asked['channels'])}{only}"))
    yield from aligned(rows)


def _topics(topics: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    heard = any(topic["heard_in_file"] for topic in topics)
    yield "topics" if heard else "topics (none has a subscriber in the file: recordings and live transports hear them)"
    rows = []
    for topic in topics:
        row = [topic["topic"], (topic["type"] or "-").rpartition("/")[2], ", ".join(topic["publishers"])]
        if heard:
            row.append("heard in the file" if topic["heard_in_file"] else "no subscriber in the file")
        rows.append(row)
    yield from aligned(rows)


def _left_out(parts: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    yield "left out"
    rows = []
    for part in parts:
        names = [listed(part["names"], MOST_LEFT_OUT)] if part["names"] else []
        where = [] if part["where"] == "/" else [part["where"]]
        rows.append((part["part"], ": ".join([*where, *names, part["why"]])))
    yield from aligned(rows)


def _steps(count: Fraction) -> str:
    return "1 step" if count == 1 else f"{shortest(count)} steps"


def _seconds(stamp_ns: int) -> str:
    whole, rest = divmod(stamp_ns, 1_000_000_000)
    return f"{whole}.{rest:09d}".rstrip("0").rstrip(".") + " s"
