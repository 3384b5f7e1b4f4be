"""Traps: what a graph file does that surprises people, one line each, with a stable code."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any

from graph.base.errors import UserError
from graph.session.graph_checks import idle_nodes
from graph.session.graph_links import Links, link_notes, nobody_consumes
from graph.session.missed_ticks import missed_ticks

from .explain_clocks import Step, plan_updates, updates_of
from .explain_sensors import planned_ticks
from .explain_topics import (
    disabled,
    named_frames,
    placed_frames,
    planned_topics,
    sensors_behind,
    shared,
    shared_topics,
)
from .frames import unpublished
from .idle_parts import latent_retriggered, product_not_made

if TYPE_CHECKING:
    from graph.evaluate import Graph, Node
    from graph.session.open import Session
    from graph.sim.app import App

    from .explain_clocks import Step
    from .explain_run import Observed

Trap = tuple[str, str, str]
"""Code, where, message."""


def find_traps(
    session: Session, links: Links, seen: Observed, sensors: Sequence[Mapping[str, Any]], steps: Sequence[Step]
) -> list[Trap]:
    """All traps, those of clocks first, and the App's own warnings."""
    app = session.app
    found = [
        *clock_traps(app, steps),
        *wiring_traps(session),
        *_sensor_traps(app, sensors, seen),
        *link_notes(links),
        *_latent_traps(seen),
        *_explained(session),
        *seen.frames.warnings(app.bus),
        *shared_topics(app.bus),
    ]
    found += [(one.code, one.where, one.message) for one in app.warnings]
    return list(dict.fromkeys(found))


def _explained(session: Session) -> Iterator[Trap]:
    """What the memories of nodes that have run tell of themselves, by a method `explained`."""
    for graph in session.runner.graphs.values():
        for node in graph.nodes.values():
            tell = getattr(node.db.memory, "explained", None) if node.type.memory is not None else None
            if tell is not None:
                yield from ((code, node.path, message) for code, message in tell(node.db))


def wiring_traps(session: Session) -> Iterator[Trap]:
    """Missing inputs of a session's nodes, and conflicts on their topics."""
    for graph in session.runner.graphs.values():
        yield from idle_nodes(graph)
        yield from graph.notes
    nodes = [node for graph in session.runner.graphs.values() for node in graph.nodes.values()]
    yield from _unset_inputs(nodes)
    yield from _value_notes(nodes)
    yield from _unfed_inputs(session.runner.graphs.values())
    yield from _mixed_topics(session)


def _unfed_inputs(graphs: Iterable[Graph]) -> Iterator[Trap]:
    """Nodes that publish or command what nothing gives them: no connection and no written value."""
    for graph in graphs:
        written = {node.name: node.inputs for node in graph.spec.nodes}
        for node in graph.nodes.values():
            names = [*node.type.inputs_as("data"), *node.type.inputs_as("command")]
            if not names or ("enabled" in node.type.inputs and node.get("enabled") is False):
                continue
            if any(not any(map(node.connected, group)) for group in node.empty_needs()):  # `input-not-set` says more
                continue
            given = {name.removeprefix("inputs:") for name in written.get(node.name, ())}
            if not any(node.connected(name) or name in given for name in names):
                does = (
                    "its messages hold nothing but defaults" if node.type.inputs_as("data") else "it commands nothing"
                )
                yield (
                    "input-unfed",
                    str(node.mark or node.path),
                    f"{node.path}: nothing feeds {' or '.join(names[:4])}, so {does}; connect what it is to send",
                )


def _unset_inputs(nodes: Iterable[Node]) -> Iterator[Trap]:
    """Required inputs (`NodeType.needs`) without a value."""
    for node in nodes:
        if "enabled" in node.type.inputs and node.get("enabled") is False:
            continue
        for group in node.empty_needs():
            if not any(node.connected(name) for name in group):
                value = node.get(group[0])
                lacking = f"with {value:g}" if isinstance(value, int | float) else "without it"
                others = f" (or {' or '.join(group[1:])})" if len(group) > 1 else ""
                yield (
                    "input-not-set",
                    f"{node.path}.inputs:{group[0]}",
                    f"{node.type.short_name} cannot work {lacking}{others}; give it a value or connect it",
                )


def _value_notes(nodes: Iterable[Node]) -> Iterator[Trap]:
    """What nodes warn of when they compute, as far as the file gives the values (`NodeType.notes`)."""
    from nodes.ros2.profiles import profile_fault

    for node in nodes:
        if "enabled" in node.type.inputs and not node.get("enabled"):
            continue
        if "qosProfile" in node.type.inputs and (fault := profile_fault(str(node.get("qosProfile") or ""))):
            yield "qos-profile-unknown", node.path, f"{fault}; connect a ROS2QoSProfile, or leave it empty"
        if node.type.notes is not None:
            for name, code, message in node.type.notes(node.db):
                if not node.connected(name):
                    yield code, node.path, message


def _mixed_topics(session: Session) -> Iterator[Trap]:
    """Topics on which nodes publish messages of two types (the second ends the run), or that several share."""
    for name, publishers in planned_topics(session).items():
        types = {kind: path for path, kind in reversed([*publishers.items()]) if kind}
        if len(types) > 1:
            sends = ", but ".join(f"{path} sends {kind}" for kind, path in reversed([*types.items()]))
            yield "topic-of-two-types", name, f"{sends}; rename one of the two topics"
        elif types:
            yield from shared(name, next(iter(types)), [*publishers])


def clock_traps(app: App, steps: Sequence[Step]) -> Iterator[Trap]:
    """Traps in the clocks of an App that plays, in these updates."""
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
    if not settings.get(keys.PLAY_SIMULATIONS):
        yield (
            "physics-off",
            keys.PLAY_SIMULATIONS,
            "is false: physics does not step, so its clock stands and nothing ticks",
        )
    yield from _end_traps(app, moving)
    yield from _limit_traps(app)


def _end_traps(app: App, moving: Sequence[Step]) -> Iterator[Trap]:
    """Warns of the end of the scene's time codes."""
    line = app.timeline
    length = line.end_time - line.start_time
    passed = moving[0].timeline_dt * len(moving) if moving else 0
    if line.is_looping() and 0 < length < passed:
        times = math.ceil(passed / length) - 1
        yield (
            "timeline-loops",
            "timeline",
            f"the scene ends at {float(line.end_time):.6g} s (endTimeCode) and starts again at "
            f"{float(line.start_time):.6g} s, {times} times in this run; simulation time goes on",
        )


def _limit_traps(app: App) -> Iterator[Trap]:
    """Warns if an update takes more or less wall time than it advances the timeline."""
    from graph.sim import settings as keys

    settings, line = app.settings, app.timeline
    limit, codes = settings.rate(keys.RATE_LIMIT_FREQUENCY), line.time_codes_per_second
    authored = settings.is_authored(keys.RATE_LIMIT_FREQUENCY)
    if not settings.get(keys.FIXED_STEPPING):
        if authored and app.run_loop.manual_mode and limit != app.loop_rate:
            yield (
                "rate-limit-alone",
                keys.RATE_LIMIT_FREQUENCY,
                f"an update moves by 1/{float(app.loop_rate):g} s whatever the limit is: at {float(limit):g} Hz time "
                f"runs at {float(limit / app.loop_rate):.3g} x wall time; set loop_hz instead",
            )
        return
    lost = line.overwritten_rate_limit
    if lost is None and settings.get(keys.REWRITE_RATE_LIMIT) and not authored and app.loop_rate != limit:
        lost = app.loop_rate
    if lost is not None:
        yield (
            "rate-limit-overwritten",
            keys.RATE_LIMIT_FREQUENCY,
            f"play in fixed stepping replaced {float(lost):g} Hz by N x timeCodesPerSecond = {float(limit):g} Hz; set "
            f"{keys.TIME_CODES_PER_SECOND}, or the limit after play",
        )
    if limit == codes * line.updates_per_frame or settings.get(keys.FAST_MODE):
        return
    speed = limit / codes / line.updates_per_frame
    moves = f"fixed stepping moves by 1/{float(codes):g} s"
    if authored and not settings.is_authored(keys.TIME_CODES_PER_SECOND):
        yield (
            "rate-limit-alone",
            keys.RATE_LIMIT_FREQUENCY,
            f"{moves} whatever the limit is: at {float(limit):g} Hz time runs at {float(speed):.3g} x wall time; set "
            f"{keys.TIME_CODES_PER_SECOND} too",
        )
    else:
        yield (
            "slow-motion" if speed < 1 else "fast-forward",
            "clock",
            f"{moves}: at {float(limit):g} Hz time runs at {float(speed):.3g} x wall time; make the loop's rate a "
            f"multiple of {float(codes):g} Hz, or set {keys.TIME_CODES_PER_SECOND}",
        )


def _sensor_traps(app: App, sensors: Sequence[Mapping[str, Any]], seen: Observed) -> Iterator[Trap]:
    for sensor in sensors:
        if not sensor["product"]:
            continue
        if sensor["missed"]:
            rate = app.rendering.products[sensor["product"]].sensor.rate
            yield missed_ticks(app, sensor["path"], rate, sensor["missed"], sensor["frames"] + sensor["missed"])
        if not (sensor["consumers"] or app.rendering.products[sensor["product"]].writers):
            yield nobody_consumes(sensor["path"], sensor["made_by"] or [sensor["product"]])
    for node in seen.unmade:
        yield product_not_made(node, seen.updates)


def _latent_traps(seen: Observed) -> Iterator[Trap]:
    for node, (ignored, triggered) in seen.ignored.items():
        yield latent_retriggered(node, ignored, triggered, len(seen.substeps))


MOST_UPDATES = 1_000
"""Updates that are planned; problems of later updates are found only by a run."""


def load_traps(session: Session) -> list[Trap]:
    """For `graph check`: the traps of a session that has not played.

    Nothing moves, no ray is cast, no physics is built.
    """
    app = session.app
    nodes = [node for graph in session.runner.graphs.values() for node in graph.nodes.values()]
    steps = list(islice(plan_updates(app), min(updates_of(session), MOST_UPDATES)))
    found = [
        *wiring_traps(session),
        *clock_traps(app, steps),
        *_planned_traps(session, nodes, steps),
        *_frame_traps(session, nodes),
        *_darkness(app, nodes),
    ]
    return list(dict.fromkeys(found))


def _frame_traps(session: Session, nodes: Sequence[Node]) -> Iterator[Trap]:
    """Frames that publishers will name and no transform of the file places."""
    placed = placed_frames(nodes)
    if placed:
        for topic, path, frame in named_frames(session, nodes):
            yield from unpublished(topic, [path], frame, placed)


def _ask(session: Session, sensors: Mapping[str, Any]) -> None:
    """Asks sensors for what nodes will ask them for; they warn of quantities that stay empty."""
    for node, path, channels in Links(session.runner.graphs.values()).consumers():
        if (sensor := sensors.get(path)) is not None and (known := channels & sensor.kind.measures):
            sensor.require(node.path, known)
            sensor.channels()
            sensor.release(node.path)


def _darkness(app: App, nodes: Iterable[Node]) -> Iterator[Trap]:
    """Cameras whose colours are used where no light shines, and lights that are not modelled."""
    from sensors.camera.darkness import COLOURS, darkness

    cameras = [
        path
        for node in nodes
        if node.type.asks is not None and not disabled(node) and not COLOURS.isdisjoint(node.type.asks(node.db))
        for path in sensors_behind(node)
    ]
    if cameras:
        yield from darkness(app.stage, cameras)


def _planned_traps(session: Session, nodes: Iterable[Node], steps: Sequence[Step]) -> Iterator[Trap]:
    """Warnings of the sensors that nodes name: when their render products are made, of what nodes ask them for, and of
    ticks that they will miss.
    """
    from sensors.products import render_product

    app, sensors = session.app, {}
    named = dict.fromkeys(
        str(path) for node in nodes for name in node.type.inputs_as("sensor") for path in node.get(name) or ()
    )
    before = len(list(app.warnings))
    for path in named:
        try:
            product = render_product(app, path)
        except UserError:  # of a saved scene: a problem of the file otherwise
            continue
        sensors[path] = product.sensor
        ticks, missed = planned_ticks(app, product, 0, steps)
        if missed:
            yield missed_ticks(app, path, product.sensor.rate, missed, len(ticks) + missed)
    _ask(session, sensors)
    for warning in list(app.warnings)[before:]:
        yield warning.code, warning.where, warning.message
