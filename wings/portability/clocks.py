"""What a file's rates and settings do in another product."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

from graph.base.exact import shortest
from graph.sim import settings as keys

from .case import Case, Found, finds

STOCK_MIN_FRAME_RATE = 30
DEFAULT_RATE = Fraction(60)
WALL_TIME = ("isaacsim.core.nodes.IsaacReadSystemTime", "isaacsim.core.nodes.IsaacRealTimeFactor")


def _rates(case: Case) -> tuple[Fraction, Fraction]:
    """Physics and loop rate [Hz] of the file."""
    from graph.sim.scene.stage_metadata import physics_scene_rate

    clock = case.spec.clock
    loop = clock.loop_hz or DEFAULT_RATE
    physics = clock.physics_hz or physics_scene_rate(case.stage) or DEFAULT_RATE
    if clock.experience == "zero_delay":
        both = clock.physics_hz or clock.loop_hz or physics
        return both, both
    return physics, loop


@finds("physics-slower-than-loop")
def _slow_physics(case: Case) -> Iterator[Found]:
    physics, loop = _rates(case)
    if physics < loop:
        yield "clock", f"physics_hz is {shortest(physics)}, loop_hz {shortest(loop)}"


@finds("catch-up-cap")
def _capped(case: Case) -> Iterator[Found]:
    physics, loop = _rates(case)
    authored = case.spec.settings.get(keys.MIN_FRAME_RATE)
    slowest = STOCK_MIN_FRAME_RATE if authored is None else authored
    if not isinstance(slowest, int | float) or slowest <= 0:
        return
    most = max(1, int(physics // int(slowest)))
    if physics / loop > most:
        held = f"{most} of the {shortest(physics / loop)} physics steps"
        yield (
            keys.MIN_FRAME_RATE,
            f"at {shortest(physics)} Hz physics and {shortest(loop)} Hz loop an update runs {held}",
        )


@finds("physics-rate-truncated")
def _truncated(case: Case) -> Iterator[Found]:
    physics, _ = _rates(case)
    if physics.denominator > 1:
        yield "clock", f"physics_hz is {shortest(physics)} and becomes {physics // 1} there"


def truncated(dt: float | Fraction) -> int | None:
    """The steps a second that a dt [s] becomes, if they are not its own rate; else None."""
    rate = 1 / float(dt)
    steps = math.floor(rate)
    return steps if abs(rate - steps) > 1e-9 * rate else None


@finds("rate-limit-without-time-codes")
def _rate_limit(case: Case) -> Iterator[Found]:
    limit = case.spec.settings.get(keys.RATE_LIMIT_FREQUENCY)
    codes = case.spec.settings.get(keys.TIME_CODES_PER_SECOND) or case.stage.GetTimeCodesPerSecond()
    fixed = case.setting(keys.FIXED_STEPPING) or case.spec.clock.experience == "full"
    if fixed and isinstance(limit, int | float) and limit != codes:
        yield keys.RATE_LIMIT_FREQUENCY, f"it is {limit:g}, timeCodesPerSecond {codes:g}"


@finds("rate-limit-stock-frequency")
def _stock_limit(case: Case) -> Iterator[Found]:
    asked = case.spec.settings
    if asked.get(keys.RATE_LIMIT_ENABLED) and keys.RATE_LIMIT_FREQUENCY not in asked and not case.spec.clock.loop_hz:
        yield keys.RATE_LIMIT_ENABLED, "it is on without a rateLimitFrequency"


@finds("fast-mode-wall-time")
def _fast_mode(case: Case) -> Iterator[Found]:
    for node in case.links.nodes if case.setting(keys.FAST_MODE) else ():
        wall = node.type.id in WALL_TIME or ("useSystemTime" in node.type.inputs and node.get("useSystemTime"))
        if wall:
            yield node.path, "it gives wall time while useFastMode is on"
