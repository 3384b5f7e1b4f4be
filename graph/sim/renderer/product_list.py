"""The render products of an App: which there are, which render, and which outlive a stop."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

from graph.base.errors import UserError

from .products import RenderProduct
from .schedule import EveryUpdate, TickSchedule


class ProductList:
    """Render products in the order of their creation; the ground that the scheduler stands on."""

    def __init__(self) -> None:
        self.products: dict[str, RenderProduct] = {}
        self._history: dict[str, RenderProduct] = {}
        self._scheduled: list[RenderProduct] = []
        self._eager: list[RenderProduct] = []
        self._at_play: list[tuple[RenderProduct, list[Callable[[Any], object]]]] | None = None

    @property
    def time(self) -> Fraction:
        """The external time [s] that schedules follow."""
        raise NotImplementedError

    @property
    def moment(self) -> Fraction:
        """The external time [s] at which a product made now begins to exist."""
        raise NotImplementedError

    @property
    def history(self) -> tuple[RenderProduct, ...]:
        """Every product made so far, those removed or gone with a stop included; of one path the newest."""
        return tuple(self._history.values())

    def add(self, product: RenderProduct) -> RenderProduct:
        """Takes a product from now on. Raises UserError if its path is taken."""
        if product.path in self.products:
            raise UserError(f"render product {product.path} already exists; use it or give the new one another path")
        moment = self.moment
        product.restart(moment if product.created_at is None else max(moment, product.created_at))
        product.on_enabled = self._enabled_changed
        self.products[product.path] = product
        self._history[product.path] = product
        self._sort_products()
        return product

    def remove(self, path: str) -> None:
        """Takes a product away; its counts stay in `history`. An unknown path is ignored."""
        product = self.products.pop(path, None)
        if product is not None:
            product.writers.clear()
            self._sort_products()

    def begin_play(self) -> None:
        """Remembers the products and writers there are; only they outlive the next stop."""
        self._at_play = [(product, list(product.writers)) for product in self.products.values()]

    def end_play(self) -> None:
        """Stop: products and writers made since play are gone, the others begin anew at external time 0."""
        kept = self._at_play or []
        self._at_play = None
        self._forget_frames()
        removed = [path for path, product in self.products.items() if all(product is not kept_ for kept_, _ in kept)]
        for path in removed:
            self.products[path].new_frame = False
            self.remove(path)
        for product, writers in kept:
            if self.products.get(product.path) is product:
                product.writers[:] = writers
        self._begin_anew()

    def restart(self) -> None:
        """The external time is 0 again: every product begins anew."""
        self._forget_frames()
        self._begin_anew()

    def _begin_anew(self) -> None:
        for product in self.products.values():
            product.clear()
            product.restart(self.time)
            product.sensor.reset()
        self._sort_products()

    def _forget_frames(self) -> None:
        """Frames that wait, and what was rendered so far, are no more."""

    def _bind(self) -> None:
        """The products that render are others."""

    def _enabled_changed(self, product: RenderProduct) -> None:
        if product.enabled:
            product.restart(self.moment)
            product.sensor.reset()
        self._sort_products()

    def _sort_products(self) -> None:
        enabled = [product for product in self.products.values() if product.enabled]
        self._scheduled = [product for product in enabled if isinstance(product.sensor.schedule, TickSchedule)]
        self._eager = [
            product
            for product in enabled
            if isinstance(product.sensor.schedule, EveryUpdate) or product.sensor.wants_updates
        ]
        self._bind()
