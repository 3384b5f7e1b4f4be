"""What a graph file does that surprises people: one line each, with a stable code."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

from .explain_links import Link, Links

if TYPE_CHECKING:
    from graph.evaluate import Node
    from graph.sim import App

    from .explain_clocks import Step
    from .explain_run import Observed

Trap = tuple[str, str, str]
"""Code, where, message."""

TIMES = {
    "time": "timeline time, which loops and runs ahead of the physics clock",
    "timeSinceStart": "the run loop's time, which no stop resets",
    "absoluteSimTime": "the run loop's time, which no stop resets",
}
CLOCK_NODES = ("OnPlaybackTick", "OnTick", "ReadTime")


def find_traps(
    app: App, links: Links, seen: Observed, sensors: Sequence[Mapping[str, Any]], steps: Sequence[Step]
) -> list[Trap]:
    """Every trap there is, clocks first, and what the App itself warns of."""
    found = [
        *_clock_traps(app, steps),
        *_sensor_traps(sensors, seen),
        *_stamp_traps(links),
        *_order_traps(links),
        *_latent_traps(seen),
    ]
    found += [(one.code, one.where, one.message) for one in app.warnings]
    return list(dict.fromkeys(found))


def _clock_traps(app: App, steps: Sequence[Step]) -> Iterator[Trap]:
    from graph.sim import settings as keys

    settings = app.settings
    moving = [step for step in steps if step.timeline_dt]
    idle = [step for step in moving if not step.substeps]
    if idle and settings.get(keys.PLAY_SIMULATIONS):
        yield (
            "physics-slower-than-loop",
            "clock",
            f"{len(idle):,} of {len(moving):,} updates run no physics step; nothing is measured in them: raise "
            "physics_hz to loop_hz or above",
        )
    capped = [step for step in steps if step.due > step.substeps]
    if capped:
        yield (
            "catch-up-cap",
            keys.MIN_FRAME_RATE,
            f"{len(capped):,} of {len(steps):,} updates hold substeps back, the first in update {capped[0].index}: "
            "physics falls behind; lower minFrameRate, or 0 for no cap",
        )
    lost = app.timeline.overwritten_rate_limit
    if lost is not None:
        yield (
            "rate-limit-overwritten",
            keys.RATE_LIMIT_FREQUENCY,
            f"play in fixed stepping replaced {float(lost):g} Hz by N x timeCodesPerSecond = "
            f"{float(settings.rate(keys.RATE_LIMIT_FREQUENCY)):g} Hz; set {keys.TIME_CODES_PER_SECOND}, or "
            "the limit after play",
        )
    alone = settings.is_authored(keys.RATE_LIMIT_FREQUENCY) and not settings.is_authored(keys.TIME_CODES_PER_SECOND)
    limit, codes = settings.rate(keys.RATE_LIMIT_FREQUENCY), app.timeline.time_codes_per_second
    in_step = limit == codes * app.timeline.updates_per_frame or settings.get(keys.FAST_MODE)
    if settings.get(keys.FIXED_STEPPING) and not in_step and not alone:
        speed = limit / codes / app.timeline.updates_per_frame
        yield (
            "slow-motion" if speed < 1 else "fast-forward",
            "clock",
            f"fixed stepping moves by 1/{float(codes):g} s: at {float(limit):g} Hz time runs at {float(speed):.3g} x "
            f"wall time; make the loop's rate a multiple of {float(codes):g} Hz, or set {keys.TIME_CODES_PER_SECOND}",
        )
    elif settings.get(keys.FIXED_STEPPING) and not in_step:
        speed = limit / codes / app.timeline.updates_per_frame
        yield (
            "rate-limit-alone",
            keys.RATE_LIMIT_FREQUENCY,
            f"fixed stepping moves by 1/{float(codes):g} s whatever the limit is: at {float(limit):g} Hz time runs at "
            f"{float(speed):.3g} x wall time; set {keys.TIME_CODES_PER_SECOND} too",
        )


def _sensor_traps(sensors: Sequence[Mapping[str, Any]], seen: Observed) -> Iterator[Trap]:
    for sensor in sensors:
        if not sensor["product"]:
            continue
        if sensor["missed"]:
            yield (
                "sensor-faster-than-loop",
                sensor["path"],
                f"{sensor['missed']:,} of {sensor['frames'] + sensor['missed']:,} ticks are passed over: at most one "
                "frame an update; raise loop_hz and physics_hz, or lower the tick rate",
            )
        if not sensor["consumers"]:
            yield (
                "nobody-consumes",
                sensor["path"],
                f"it is rendered for {', '.join(sensor['made_by']) or sensor['product']}, but nothing asks for its "
                "channels",
            )
    for node in seen.unmade:
        yield "product-not-made", node.path, f"it makes no render product in the first {seen.updates} updates"


def _stamp_traps(links: Links) -> Iterator[Trap]:
    for link in links.all:
        if not link.input.lower().endswith("timestamp"):
            continue
        for source in links.data_sources(link):
            if source.source.type.short_name in CLOCK_NODES and source.output in TIMES:
                yield (
                    "timeline-stamp",
                    f"{link.target.path}.inputs:{link.input}",
                    f"gets {source.source.name}.{source.output}: {TIMES[source.output]}; sensors are stamped with "
                    "IsaacReadSimulationTime.simulationTime",
                )


def _order_traps(links: Links) -> Iterator[Trap]:
    for node, output, targets in links.execution_outputs():
        reached = {target: links.reached(target) for target in targets}
        for first, second in combinations(targets, 2):
            shared = reached[first] & reached[second]
            early, late = reached[first] - shared, reached[second] - shared
            if exchange := _exchange(links, early, late):
                yield (
                    "fan-out-order",
                    f"{node.path}.outputs:{output}",
                    f"{exchange} reads it in the same update only because {first.name} is wired before {second.name}; "
                    "chain them, or use Multisequence",
                )
            if exchange := _exchange(links, late, early):
                yield (
                    "fan-out-order",
                    f"{node.path}.outputs:{output}",
                    f"{exchange} reads the value of the update before, because {first.name} is wired before "
                    f"{second.name}; swap them, or use Multisequence",
                )


def _exchange(links: Links, writers: set[Node], readers: set[Node]) -> str:
    """The first data connection from one of the writers to one of the readers, as text; "" if there is none."""
    for link in links.all:
        if link.target in readers and not link.execution:
            for source in links.data_sources(link):
                if source.source in writers:
                    return _as_text(source, link)
    return ""


def _as_text(source: Link, link: Link) -> str:
    name = link.target.name
    return f"{source.source.name}.{source.output} -> {name}.{link.input}: {name}"


def _latent_traps(seen: Observed) -> Iterator[Trap]:
    for node, missed in seen.missed_triggers.items():
        if missed:
            yield (
                "latent-retriggered",
                node.path,
                f"{node.type.short_name} sleeps through {missed} of its {seen.triggers[node]} triggers in the first "
                f"{len(seen.substeps)} updates, and starts over when it ends; to wait once, put Once before it",
            )
