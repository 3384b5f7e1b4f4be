"""The sensors of a stage: when each ticks, what it costs, who asks for it."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim import App
    from graph.sim.renderer.rendering import RenderProduct
    from graph.sim.renderer.schedule import Tick

    from .explain_clocks import Step
    from .explain_run import Observed

SENSOR_TYPES = ("OmniLidar", "OmniRadar", "OmniAcoustic", "Camera")
FIRST_TICKS = 3
RULES = {
    "whole": "tick = scan rate: whole scans, one a tick",
    "partial": "tick is not the scan rate: each update in which physics steps gives the firings since the last",
    "slices": "accumulateOutputs off: each update in which physics steps gives the firings since the last",
    "every update": "tick rate 0: a frame in each update in which physics steps",
    "tick": "one frame a tick",
    "multi-tick off": "a frame in every update (multi-tick rendering is off)",
}


def sensors_of(app: App, seen: Observed, steps: Sequence[Step]) -> list[dict[str, Any]]:
    """Every sensor prim of the stage in its order, once for each of its render products; rendered ones first."""
    from graph.sim.usd import Usd

    rendered, others = [], []
    for prim in app.stage.Traverse(Usd.TraverseInstanceProxies()):
        if prim.GetTypeName() not in SENSOR_TYPES:
            continue
        path = str(prim.GetPath())
        products = [product for product in seen.products.values() if product.camera_path == path]
        rendered += [{**_prim(app, prim), **_rendered(app, product, seen, steps)} for product in products]
        if not products:
            makers = [node.path for node in seen.unmade if path in node.get("cameraPrim")]
            others.append({**_prim(app, prim), "product": None, "made_by": makers})
    return rendered + others


def planned_ticks(
    app: App, product: RenderProduct, made_in: int, steps: Sequence[Step]
) -> tuple[list[tuple[int, Tick]], int]:
    """(update, tick) of every frame in these updates, and the grid times passed over, by the scheduler's rules."""
    from graph.sim.renderer.schedule import EveryUpdate, Tick, TickSchedule

    schedule: TickSchedule | EveryUpdate = product.sensor.schedule
    created = product.created_at or Fraction(0)
    if isinstance(schedule, EveryUpdate):
        copy: TickSchedule | EveryUpdate = EveryUpdate(created, schedule.rate)
    else:
        copy = TickSchedule(schedule.rate, created, accumulates=schedule.accumulates)
    every_update = not app.rendering.multi_tick and not copy.accumulates and isinstance(copy, TickSchedule)
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
    known: dict[str, Any] = {"path": str(prim.GetPath()), "type": str(prim.GetTypeName())}
    if known["type"] == "OmniLidar":
        from graph.sim.settings import BARE_LIDAR_TICK_RATE
        from sensors.lidar.pattern import firing_pattern
        from sensors.lidar.prim import read_config, read_tick_rate

        config = read_config(prim)
        rays, rate = len(firing_pattern(config)), config.scan_rate_base_hz
        known |= {
            "tick_rate_hz": read_tick_rate(prim, app.settings.rate(BARE_LIDAR_TICK_RATE)),
            "scan_rate_hz": rate,
            "accumulates": config.accumulate_outputs,
            "rays_per_scan": rays,
            "rays_per_second": rays * rate,
        }
    return known


def _rendered(app: App, product: RenderProduct, seen: Observed, steps: Sequence[Step]) -> dict[str, Any]:
    path = product.path
    made_in = seen.made_in[path]
    planned, missed = planned_ticks(app, product, made_in, steps)
    observed: list[tuple[int, Tick]] = [
        entry for entry in getattr(product.sensor, "ticks", ()) if entry[0] < min(seen.updates, len(steps))
    ]
    ticks = observed + [entry for entry in planned if entry[0] >= seen.updates]
    return {
        "product": path,
        "made_by": seen.makers.get(path, []),
        "made_in_update": made_in,
        "exists_from_s": product.created_at,
        "rule": _rule(app, product),
        "first_ticks": [
            {"stamp_ns": _stamp(product, tick), "time_s": tick.time, "update": update}
            for update, tick in ticks[:FIRST_TICKS]
        ],
        "frames": len(ticks),
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
    if isinstance(schedule, TickSchedule):
        if not app.rendering.multi_tick and not schedule.accumulates:
            return "multi-tick off"
        return "whole" if schedule.accumulates else "tick"
    if not schedule.rate:
        return "every update"
    config = getattr(product.sensor, "config", None)
    return "slices" if config and config.scan_rate_base_hz == schedule.rate else "partial"


def _stamp(product: RenderProduct, tick: Tick) -> int:
    from graph.base.exact import nanoseconds

    turns = getattr(product.sensor, "turns", None)  # a lidar's
    if turns is None:
        return nanoseconds(tick.time)
    return nanoseconds(max(tick.start, tick.end - turns.period))
