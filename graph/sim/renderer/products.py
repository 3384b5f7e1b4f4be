"""Render products: each joins a sensor, its schedule and its frames; and the list of them."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from graph.base.errors import UserError
from graph.base.suggesting import Suggesting

from .schedule import EveryUpdate, TickSchedule
from .sensor import Sensor, SensorFrame

if TYPE_CHECKING:
    from .view import WorldView


class RenderProduct(Suggesting):
    """One sensor's output at one size; exists from external time `created_at` [s]."""

    def __init__(
        self,
        path: str,
        camera_path: str,
        resolution: tuple[int, int],
        sensor: Sensor,
        created_at: Fraction | None = None,
    ) -> None:
        self.path = path
        self.camera_path = camera_path
        self.resolution = resolution
        self.sensor = sensor
        self.created_at = created_at
        self.writers: list[Callable[[Any], object]] = []
        """Called with each new frame, in order, before the post-render graphs."""
        self.on_enabled: Callable[[RenderProduct], None] = lambda product: None
        self._enabled, self._lost = True, False
        self.scene: WorldView | None = None
        """The world that it belongs to; None before it is added and after it is removed."""
        self.advanced_to = Fraction(0)
        """External time [s] up to which a sensor that wants updates has been advanced."""
        self.capture: Any = None
        self.captured_at = Fraction(0)
        """External time [s] of the state that the next tick uses; it is in `capture` if anything moves."""
        self.capture_index = 0
        self.clear()

    def clear(self) -> None:
        """Drops frames and counts."""
        self.frame: Any = None
        self.new_frame = False
        self.stepped = False
        """Whether a step of the orchestrator rendered the newest frame."""
        self.frames = 0
        self.elements = 0
        self.first_frame_ns: int | None = None
        self.last_frame_ns: int | None = None
        self._missed_before = 0

    @property
    def enabled(self) -> bool:
        """A disabled product renders nothing; enabling it again counts as creating it. One that is `lost` is not."""
        return self._enabled and not self._lost

    @enabled.setter
    def enabled(self, enabled: bool) -> None:
        self._switch(enabled, self._lost)

    @property
    def lost(self) -> bool:
        """Whether its sensor's prim is gone."""
        return self._lost

    @lost.setter
    def lost(self, lost: bool) -> None:
        self._switch(self._enabled, lost)

    def _switch(self, enabled: bool, lost: bool) -> None:
        before = self.enabled
        self._enabled, self._lost = enabled, lost
        if self.enabled != before:
            self.on_enabled(self)

    @property
    def missed(self) -> int:
        """Grid times that were skipped because an update rendered a newer one."""
        return self._missed_before + self.sensor.schedule.missed

    @property
    def due(self) -> int:
        """Ticks that fell due: frames delivered and ticks missed."""
        return self.frames + self.missed

    @property
    def is_frozen(self) -> bool:
        """Whether a tick uses the captured state of its own grid time."""
        return self.sensor.schedule.accumulates and not self.sensor.wants_updates

    def restart(self, moment: Fraction) -> None:
        """Restarts the schedule at external time `moment`; counts stay."""
        self._missed_before = self.missed
        self.created_at = self.advanced_to = moment
        self.sensor.schedule.restart(moment)
        self.capture, self.capture_index = None, 0

    def deliver(self, frame: SensorFrame, *, stepped: bool = False) -> None:
        """Stores and counts a new frame."""
        self.frame, self.stepped = frame, stepped
        self.new_frame = True
        self.frames += 1
        self.elements += frame.count
        self.last_frame_ns = frame.timestamp_ns
        if self.first_frame_ns is None:
            self.first_frame_ns = frame.timestamp_ns


class ProductList:
    """Render products in the order of their creation."""

    def __init__(self) -> None:
        self.products: dict[str, RenderProduct] = {}
        """All products, by path."""
        self.scheduled: list[RenderProduct] = []
        """Products that render at ticks."""
        self.eager: list[RenderProduct] = []
        """Products with work in every update."""
        self._history: dict[str, RenderProduct] = {}
        self._at_play: list[tuple[RenderProduct, list[Callable[[Any], object]]]] = []

    @property
    def history(self) -> tuple[RenderProduct, ...]:
        """Every product made so far, including removed ones; the newest one of each path."""
        return tuple(self._history.values())

    def add(self, product: RenderProduct) -> RenderProduct:
        """Adds a product. Raises UserError if its path is taken."""
        if product.path in self.products:
            raise UserError(f"render product {product.path} already exists; use it or give the new one another path")
        self.products[product.path] = product
        self._history[product.path] = product
        self.sort()
        return product

    def remove(self, path: str) -> None:
        """Removes a product; its counts stay in `history`. An unknown path is ignored."""
        product = self.products.pop(path, None)
        if product is not None:
            product.scene = None
            product.writers.clear()
            self.sort()

    def begin_play(self) -> None:
        """Records the present products and writers; only they outlive the next stop."""
        self._at_play = [(product, list(product.writers)) for product in self.products.values()]

    def end_play(self) -> None:
        """Stop: removes products and writers made since play."""
        kept, self._at_play = self._at_play, []
        removed = [path for path, product in self.products.items() if all(product is not kept_ for kept_, _ in kept)]
        for path in removed:
            self.products[path].new_frame = False
            self.remove(path)
        for product, writers in kept:
            if self.products.get(product.path) is product:
                product.writers[:] = writers

    def sort(self) -> None:
        """Updates which products render at ticks and which in every update, after products or their sensors changed."""
        enabled = [product for product in self.products.values() if product.enabled]
        self.scheduled = [product for product in enabled if isinstance(product.sensor.schedule, TickSchedule)]
        self.eager = [
            product
            for product in enabled
            if isinstance(product.sensor.schedule, EveryUpdate) or product.sensor.wants_updates
        ]
