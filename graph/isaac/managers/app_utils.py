"""Isaac Sim's `app_utils` for the current App: each function calls the App's, or timeline's, function of that name."""

from __future__ import annotations

from collections.abc import Iterable

from graph.sim.driver import StepCallback

from .app import App


def play(*, commit: bool | None = True) -> None:
    """As `App.play`."""
    App.current().play(commit=commit)


def pause(*, commit: bool | None = True) -> None:
    """As `App.pause`."""
    App.current().pause(commit=commit)


def stop(*, commit: bool | None = True) -> None:
    """As `App.stop`."""
    App.current().stop(commit=commit)


def is_playing() -> bool:
    """Whether the timeline plays."""
    return App.current().timeline.is_playing()


def is_paused() -> bool:
    """Whether the timeline is paused."""
    return App.current().timeline.is_paused()


def is_stopped() -> bool:
    """Whether the timeline is stopped."""
    return App.current().timeline.is_stopped()


def update_app(*, steps: int = 1, callback: StepCallback | None = None) -> None:
    """As `App.update_app`."""
    App.current().update_app(steps=steps, callback=callback)


async def next_update_async() -> float:
    """As `App.next_update_async`."""
    return await App.current().next_update_async()


async def update_app_async(*, steps: int = 1, callback: StepCallback | None = None) -> None:
    """As `App.update_app_async`."""
    await App.current().update_app_async(steps=steps, callback=callback)


async def next_render_simulation_async(
    render_product_paths: str | Iterable[str], num_simulation_frames: int = 1
) -> None:
    """As `App.next_render_simulation_async` (deprecated)."""
    await App.current().next_render_simulation_async(render_product_paths, num_simulation_frames)
