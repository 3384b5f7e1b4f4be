"""What a run did, as `report.json` and as a table."""

from __future__ import annotations

import json
import re
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

from graph.base.errors import RunError
from graph.base.exact import shortest
from graph.base.outputs import write
from graph.sim.timing.run_loop import RealClock

from .idle_parts import silent_parts, wired_sensors
from .printing import counted, safe_line
from .tables import Grid

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from graph.recording.transports.sink import LiveSink
    from graph.session.meter import Meter
    from graph.session.runner import GraphRunner
    from graph.sim.app import App
    from graph.sim.messages.bus import CountingSink, Topic, TopicCount

Report = dict[str, Any]

REPORT = "report.json"
SENSOR_COLUMNS = ("Hz", "frames", "points", "begins (s)", "last (s)")
"""The last two: when the first and the last frame begin; a lidar's turn begins a period before its messages' stamp."""
GAP = 2
"""Spaces between the columns of a table."""
WORDS = 60
"""Characters of a line of text in a table."""


def build_report(
    app: App,
    runner: GraphRunner,
    published: CountingSink,
    wall_time_s: float,
    live: Sequence[LiveSink] = (),
    meter: Meter | None = None,
    compiled_s: float = 0.0,
    drawn: Mapping[str, Any] | None = None,
) -> Report:
    """Everything that a run counted; times in seconds, stamps in integer nanoseconds of simulation time.

    compiled_s: wall time that the run spent on compiling, which its real-time factor leaves out. drawn: what
    `randomize` of the file drew.
    """
    running_s = wall_time_s - compiled_s
    report = {
        "updates": app.update_index,
        "physics_steps": app.simulation.get_num_physics_steps(),
        "simulation_time": float(app.simulation.time),
        "timeline_time": float(app.timeline.current_time),
        "external_time": float(app.external_time),
        "wall_time_s": round(wall_time_s, 6),
        "wall_clock": _wall_clock(app),
        "real_time_factor": round(float(app.simulation.time) / running_s, 3) if running_s > 0 else None,
        "sensors": _sensors(app, runner),
        "loop_hz": shortest(app.loop_rate),
        "physics_hz": shortest(app.simulation.steps_per_second),
        "topics": _topics(app, published),
        "nodes": {
            node.path: {"computes": node.computes} for graph in runner.graphs.values() for node in graph.nodes.values()
        },
        "silent": silent_parts(app, runner),
        "warnings": [warning.as_dict() for warning in app.warnings],
        "timing_s": _timing(app, compiled_s),
    }
    if drawn:
        report["randomized"] = {"seed": app.seed, "values": dict(drawn)}
    if app.metrics:
        report["metrics"] = dict(app.metrics)
    if live:
        report["live"] = {sink.name: sink.facts() for sink in live}
    if meter is not None:
        report["stats"] = {part: cost.as_data() for part, cost in meter.costs.items() if cost.wall}
    return report


def write_report(report: Mapping[str, Any], out: Path) -> None:
    """Writes `report.json` into the folder `out`. Raises RunError if that fails, and leaves no part of the file."""
    try:
        write(out / REPORT, to_json(report) + "\n")
    except OSError as error:
        raise RunError(f"{out / REPORT} cannot be written: {error.strerror}") from error


def to_json(report: Mapping[str, Any]) -> str:
    """The report as indented JSON."""
    return json.dumps(report, indent=2, ensure_ascii=False)


def table_of(report: Report, width: int) -> Iterator[str]:
    """The lines of a table of a run's sensors, topics and clocks, at most `width` characters wide."""
    if report["sensors"]:
        table = Grid("sensor", *SENSOR_COLUMNS)
        rows = {path: _sensor_cells(sensor, report["loop_hz"]) for path, sensor in report["sensors"].items()}
        widths = (max(map(len, column)) for column in zip(SENSOR_COLUMNS, *rows.values(), strict=True))
        room = width - sum(GAP + one for one in widths) - GAP
        for path, cells in rows.items():
            table.add(_name(path, room), *cells)
        yield from _indented(table)
    if report["topics"]:
        table = Grid("topic", "messages", "type", texts=(0, 2))
        for topic, count in report["topics"].items():
            table.add(_name(topic, width // 2), _amount(count["messages"]), _name(count["type"]))
        yield from _indented(table)
    clocks = Grid("clock", "at the end (s)", "counted")
    clocks.add("timeline", _decimal(report["timeline_time"]), counted(report["updates"], "updates"))
    clocks.add("physics", _decimal(report["simulation_time"]), counted(report["physics_steps"], "steps"))
    clocks.add("renderer", _decimal(report["external_time"]), counted(_frames(report), "frames"))
    yield from _indented(clocks)
    for name, live in report.get("live", {}).items():
        counts = [sum(topic[what] for topic in live["topics"].values()) for what in ("sent", "dropped", "received")]
        said = "{:,} sent, {:,} dropped, {:,} received".format(*counts)
        yield f"live {name}: {live['place']}: {said}"
    if "stats" in report:
        yield from _indented(_stats_table(report["stats"]))
    for line in report["silent"]:
        yield f"silent: {safe_line(line)}"
    yield _wall_line(report)


def _indented(table: Grid) -> Iterator[str]:
    return (f" {line}" for line in table.lines())


def _stats_table(stats: Mapping[str, Mapping[str, float]]) -> Grid:
    from graph.session.meter import PARTS

    table = Grid("part of the updates", "wall (s)", "processor (s)", "share", "what it is", texts=(0, 4))
    whole = sum(cost["wall_s"] for cost in stats.values())
    for part, cost in stats.items():
        wall, share = cost["wall_s"], f"{cost['wall_s'] / whole:.1%}" if whole else "-"
        table.add(part, f"{wall:.3f}", f"{cost['cpu_s']:.3f}", share, "\n".join(wrap(PARTS[part], WORDS)))
    return table


def warning_lines(report: Report) -> list[str]:
    """One line for each warning of a run."""
    return [
        f"warning {warning['code']}: {warning['where']}: {warning['message']}"
        + (f" ({warning['count']} times)" if warning["count"] > 1 else "")
        for warning in report["warnings"]
    ]


def _sensor_cells(sensor: Mapping[str, Any], loop_hz: str) -> tuple[str, ...]:
    silent = "" if sensor["frames"] else " (silent)"
    return (
        f"{sensor['tick_rate']:g}" if sensor["tick_rate"] else f"{loop_hz} (loop)",
        f"{sensor['frames']:,} of {sensor['due']:,}{silent}",
        f"{sensor['elements']:,}",
        _seconds(sensor["first_frame_ns"]),
        _seconds(sensor["last_frame_ns"]),
    )


def _name(text: str, width: int = 40) -> str:
    """A name as a table cell, without control characters; a long one continues on the next line."""
    lines = [""]
    for part in re.split("(?=/)", safe_line(text)):
        if len(lines[-1]) + len(part) > width and lines[-1]:
            lines.append("")
        lines[-1] += part
    return "\n".join(piece for line in lines for piece in wrap(line, max(width, 1)) or [""])


def _amount(number: int) -> str:
    return f"{number:,}" if number else "0 (silent)"


def _frames(report: Report) -> int:
    return sum(sensor["frames"] for sensor in report["sensors"].values())


def _sensors(app: App, runner: GraphRunner) -> dict[str, Mapping[str, Any]]:
    from sensors.prim import read_tick_rate

    products: dict[str, list[Any]] = {}
    for product in app.rendering.history:
        products.setdefault(product.camera_path, []).append(product)
    sensors = {path: _sensor(rendering) for path, rendering in products.items()}
    for path in wired_sensors(app, runner):
        if path not in sensors:
            rate = float(read_tick_rate(app.stage.GetPrimAtPath(path)))
            sensors[path] = {
                **dict.fromkeys(("due", "frames", "missed", "elements"), 0),
                "tick_rate": rate,
                "first_frame_ns": None,
                "last_frame_ns": None,
            }
    return sensors


def _topics(app: App, published: CountingSink) -> dict[str, Mapping[str, Any]]:
    """Each topic's messages; of those that follow a sensor also its rate [Hz] and the messages that fell due."""
    return {name: _topic(count, app.bus.topics.get(name)) for name, count in published.topics()}


def _topic(count: TopicCount, topic: Topic | None) -> Mapping[str, Any]:
    counts: dict[str, Any] = {
        "type": count.type_name,
        "messages": count.messages,
        "first_ns": count.first_ns,
        "last_ns": count.last_ns,
    }
    if topic is not None and topic.due is not None:
        counts["due"] = topic.due
        if cadence := topic.cadence:
            counts |= {"sensor": cadence.sensor, "rate_hz": shortest(cadence.rate / cadence.every)}
    return counts


def _sensor(products: Sequence[Any]) -> Mapping[str, Any]:
    """The counts of all render products of one sensor."""
    frames, missed = sum(one.frames for one in products), sum(one.missed for one in products)
    first = [one.first_frame_ns for one in products if one.first_frame_ns is not None]
    last = [one.last_frame_ns for one in products if one.last_frame_ns is not None]
    return {
        "tick_rate": float(products[-1].sensor.rate),
        "due": frames + missed,
        "frames": frames,
        "missed": missed,
        "elements": sum(one.elements for one in products),
        "first_frame_ns": min(first, default=None),
        "last_frame_ns": max(last, default=None),
    }


def _timing(app: App, compiled_s: float) -> dict[str, float]:
    """The time of each part; compiling is done where rays are cast, and counts apart from rendering."""
    timing = {name: round(seconds, 6) for name, seconds in app.timing.items()}
    timing["render"] = round(max(0.0, timing["render"] - compiled_s), 6)
    return timing | {"compile": round(compiled_s, 6)}


def _seconds(stamp_ns: int | None) -> str:
    return "-" if stamp_ns is None else _exact_seconds(stamp_ns)


def _exact_seconds(stamp_ns: int) -> str:
    whole, rest = divmod(stamp_ns, 1_000_000_000)
    return f"{whole}.{rest:09d}".rstrip("0").rstrip(".")


def _decimal(seconds: float) -> str:
    return f"{seconds:.9f}".rstrip("0").rstrip(".")


def _wall_clock(app: App) -> Mapping[str, Any]:
    """The clock that paces the updates, and the simulated seconds per second of it, measured while playing."""
    speed = app.speed
    return {
        "kind": "real" if isinstance(app.wall_clock, RealClock) else "virtual",
        "sim_per_wall": None if speed is None else round(float(speed), 6),
    }


def _wall_line(report: Report) -> str:
    timing = report["timing_s"]
    compiled = timing.get("compile", 0.0)
    parts = ", ".join(f"{name} {seconds:.2f}" for name, seconds in timing.items() if name != "compile" or compiled)
    factor, (kind, speed) = report["real_time_factor"], report["wall_clock"].values()
    line = f"{report['wall_time_s']:.2f} s of wall time ({parts})"
    if factor is not None:
        line += f": {factor:.2f} x real time" + (" without compiling, which happens once" if compiled else "")
    if kind == "virtual" and speed not in (None, 1):
        line += f"; {speed:g} x on the virtual wall clock"
    return line
