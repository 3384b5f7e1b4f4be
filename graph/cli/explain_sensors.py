"""The sensors of a stage: their ticks, cost and consumers."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pxr import Usd

    from graph.evaluate import Node
    from graph.sim.app import App
    from graph.sim.renderer.products import RenderProduct
    from graph.sim.renderer.schedule import Tick

    from .explain_clocks import Step
    from .explain_run import Observed

FIRST_TICKS = 3
RULES = {
    "every update": "tick rate 0: a frame in each update in which physics steps",
    "tick": "one frame a tick",
    "multi-tick off": "a frame in every update (multi-tick rendering is off)",
}
"""The rules of ticks that hold for every sensor; sensor types add their own."""


def sensors_of(app: App, seen: Observed, steps: Sequence[Step]) -> list[dict[str, Any]]:
    """Every sensor prim in stage order, once for each of its render products; rendered ones first."""
    from graph.sim.usd import Usd
    from sensors.sensor_types import sensor_types

    known = sensor_types()
    rendered, others = [], []
    for prim in app.stage.Traverse(Usd.TraverseInstanceProxies()):
        if prim.GetTypeName() not in known:
            continue
        path = str(prim.GetPath())
        products = [product for product in seen.products.values() if product.camera_path == path]
        rendered += [{**_prim(app, prim), **_rendered(app, product, seen, steps)} for product in products]
        if not products:
            makers = [node.path for node in seen.unmade if path in _targets(node)]
            others.append({**_prim(app, prim), "product": None, "made_by": makers})
    return rendered + others


def _targets(node: Node) -> set[str]:
    """The prims that a node's inputs name."""
    names = [name for name, attribute in node.type.inputs.items() if attribute.type == "target"]
    return {path for name in names for path in node.get(name) or ()}


def planned_ticks(
    app: App, product: RenderProduct, made_in: int, steps: Sequence[Step]
) -> tuple[list[tuple[int, Tick]], int]:
    """(update, tick) of every frame in these updates, and the skipped grid times, by the scheduler's rules."""
    from graph.sim.renderer.schedule import EveryUpdate, Tick, TickSchedule

    schedule = product.sensor.schedule
    created = product.created_at or Fraction(0)
    if isinstance(schedule, EveryUpdate):
        copy: TickSchedule | EveryUpdate = EveryUpdate(created, schedule.rate)
    else:
        copy = TickSchedule(schedule.rate, created, accumulates=schedule.accumulates)
    scheduler = app.rendering
    every_update = not scheduler.multi_tick and not copy.accumulates and isinstance(copy, TickSchedule)
    found, last = [], created
    for step in steps[made_in:]:
        time = step.external_time
        tick = Tick(0, copy.rate, time, last, time) if every_update else copy.advance(time)
        if tick is None and app.rendering.autotrigger_idle and isinstance(copy, EveryUpdate) and not copy.rate:
            tick = copy.repeat(time)
        last = time
        if tick is not None:
            found.append((step.index, tick))
    return found, copy.missed


def _prim(app: App, prim: Usd.Prim) -> dict[str, Any]:
    from sensors.sensor_types import sensor_type

    known: dict[str, Any] = {"path": str(prim.GetPath()), "type": str(prim.GetTypeName())}
    kind = sensor_type(known["type"])
    return known | dict(kind.facts(app.world, prim)) if kind else known


def _rendered(app: App, product: RenderProduct, seen: Observed, steps: Sequence[Step]) -> dict[str, Any]:
    from graph.base.exact import nanoseconds

    path = product.path
    made_in = seen.made_in[path]
    planned, missed = planned_ticks(app, product, made_in, steps)
    observed = [entry for entry in seen.ticks[path] if entry[0] < min(seen.updates, len(steps))]
    ticks = observed + [entry for entry in planned if entry[0] >= seen.updates]
    # Where frames arrive one update later, that of the last update does not arrive.
    delivered = len(steps) - app.rendering.frames_later
    return {
        "product": path,
        "made_by": seen.makers.get(path, []),
        "made_in_update": made_in,
        "exists_from_s": product.created_at,
        "rule": _rule(app, product),
        "first_ticks": [
            {"stamp_ns": nanoseconds(product.sensor.interval(tick)[0]), "time_s": tick.time, "update": update}
            for update, tick in ticks[:FIRST_TICKS]
        ],
        "frames": sum(update < delivered for update, _ in ticks),
        "missed": missed,
        "channels": seen.channels[path],
        "consumers": {
            name: {"channels": channels, "needs_subscriber": name in seen.unheard[path]}
            for name, channels in seen.demand[path].items()
        },
    }


def _rule(app: App, product: RenderProduct) -> str:
    from graph.sim.renderer.schedule import TickSchedule

    schedule = product.sensor.schedule
    if isinstance(schedule, TickSchedule) and not app.rendering.multi_tick and not schedule.accumulates:
        return "multi-tick off"
    return product.sensor.rule
