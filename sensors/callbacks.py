"""Calls a function with the frames of a render product."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from graph.base.callables import check_callable

from .annotators.annotator import Product, only_product
from .channels import Consumer

if TYPE_CHECKING:
    from graph.sim.app import App

    from .frame import Frame


def on_frame(
    product: Product,
    callback: Callable[[Frame], object],
    *,
    channels: Iterable[str] = ("xyz",),
    once: bool = False,
    app: App | None = None,
) -> Callable[[], None]:
    """Calls `callback(frame)` with each new frame of a render product, or with the next one only (`once`).

    product: a render product or its path. channels: those that the callback reads; the sensor computes them until the
    end. app: None is the App entered last. Returns a function that ends the calls. Raises SensorValueError for a
    product that does not exist or whose sensor does not have these channels.
    """
    check_callable(callback, "on_frame(product, callback)")
    _, found = only_product(product, None if app is None else app.world, "on_frame")
    owner = Consumer("on_frame")
    found.sensor.require(owner, channels)

    def end() -> None:
        found.sensor.release(owner)
        if deliver in found.writers:
            found.writers.remove(deliver)

    def deliver(frame: Frame) -> None:
        if once:
            end()
        callback(frame)

    found.writers.append(deliver)
    return end
