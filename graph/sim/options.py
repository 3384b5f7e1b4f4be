"""The options of an App: rates, experience, and which of them cannot be run yet."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from types import ModuleType
from typing import Any

from graph.base import exact
from graph.base.errors import UserError
from graph.base.plugins import BACKENDS, required

from . import settings as keys
from .devices import HOST, plugin_of
from .fidelity import Fidelity
from .settings import PARITIES, Settings
from .timing.clocks import checked_rate

EXPERIENCES = ("base", "full", "zero_delay")
DEFAULT_RATE = Fraction(60)
RAYS = "rays"
"""The value of the knob `camera.backend` that needs no plug-in."""
RENDER_ORDER = 30
"""Order of rendering among the steps of an update, as `/app/updateOrder/...` counts them."""


def refuse_unavailable(experience: str, parity: str, fidelity: Fidelity) -> None:
    """Raises UserError for an unknown or unavailable option (as `Fidelity.from_mapping` does for knobs)."""
    if experience not in EXPERIENCES:
        raise UserError(f"experience {experience!r} is not one of {', '.join(EXPERIENCES)}")
    if parity not in PARITIES:
        raise UserError(f"parity {parity!r} is not one of {', '.join(PARITIES)}")
    changed = {name: value for name, value in fidelity.as_dict().items() if value != Fidelity()[name]}
    Fidelity.from_mapping(changed)
    if fidelity.camera_backend != RAYS:
        required(BACKENDS, fidelity.camera_backend, ModuleType, "camera backend").require()
    if fidelity.device != HOST:
        plugin_of(fidelity.device).device_of(fidelity.device)


def clock_rates(
    physics_hz: float | str | Fraction | None,
    loop_hz: float | str | Fraction | None,
    experience: str,
    authored: Fraction | None,
    knob: Fraction | None,
    *,
    whole: bool = False,
    warn: Callable[[str, str, str], None] = lambda code, where, message: None,
) -> tuple[Fraction, Fraction]:
    """Physics and loop rate [Hz], from the first of: the knob, the argument, the stage, 60.

    `zero_delay` runs both at one rate. `whole`: a physics rate is rounded down to a whole number of steps, at least 1,
    with a warning. Raises UserError for rates that cannot be run or that contradict each other.
    """
    asked = knob if knob is not None else _rate(physics_hz, "physics_hz")
    loop = _rate(loop_hz, "loop_hz")
    if experience != "zero_delay":
        physics = checked_rate(asked or authored or DEFAULT_RATE, "physics_hz")
        return (_whole(physics, warn) if whole else physics), loop or DEFAULT_RATE
    if asked and loop and asked != loop:
        raise UserError(
            f"physics_hz {float(asked):g} and loop_hz {float(loop):g} differ; experience zero_delay runs both at one "
            "rate: give one of them"
        )
    both = checked_rate(asked or loop or authored or DEFAULT_RATE, "physics_hz")
    if whole:
        both = _whole(both, warn)
    return both, both


def experience_settings(settings: Settings, experience: str, loop_rate: Fraction | None, stage: Any) -> None:
    """Defaults by the experience, an explicit loop rate and the stage; values that the user has set stay."""
    if experience == "full":
        settings.set_default(keys.FIXED_STEPPING, True)
        settings.set_default(keys.RATE_LIMIT_ENABLED, True)
        settings.set_default(keys.MANUAL_MODE, False)  # on while the timeline plays
    if experience == "zero_delay":
        settings.set_default("/app/hydraEngine/waitIdle", True)
        settings.set_default(keys.RENDER_COMPLETE_ORDER, 1000)
    if loop_rate is not None:
        settings.set_default(keys.RATE_LIMIT_FREQUENCY, loop_rate)
        settings.set_default(keys.TARGET_FRAMERATE, loop_rate)
    if stage.GetRootLayer().HasTimeCodesPerSecond():
        settings.set_default(keys.TIME_CODES_PER_SECOND, stage.GetTimeCodesPerSecond())


def _rate(value: float | str | Fraction | None, what: str) -> Fraction | None:
    if value is None:
        return None
    try:
        rate = exact.rate(value)
    except (ValueError, TypeError):
        raise UserError(
            f"{what}: {value!r} is not a rate; give a number of Hz or a fraction such as 60000/1001"
        ) from None
    return checked_rate(rate, what)


def frames_come_later(settings: Settings) -> bool:
    """Whether a frame is delivered at the beginning of the update after the one that rendered it."""
    return bool(settings.get(keys.FRAMES_LATER)) and settings.get(keys.RENDER_COMPLETE_ORDER) < RENDER_ORDER


def _whole(rate: Fraction, warn: Callable[[str, str, str], None]) -> Fraction:
    steps = max(1, int(rate))
    if steps != rate:
        warn(
            "physics-rate-truncated",
            "physics_hz",
            f"{float(rate):g} Hz is not a whole number of steps per second; physics runs at {steps} Hz, as in the "
            "profile's product; give a whole rate",
        )
    return Fraction(steps)
