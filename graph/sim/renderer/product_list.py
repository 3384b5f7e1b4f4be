"""The render products of an App: all of them, those that render, and those that outlive a stop."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graph.base.errors import UserError

from .products import RenderProduct
from .schedule import EveryUpdate, TickSchedule


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

    def check_free(self, path: str) -> None:
        """Raises UserError if a product has this path."""
        if path in self.products:
            raise UserError(f"render product {path} already exists; use it or give the new one another path")

    def add(self, product: RenderProduct) -> None:
        """Adds a product whose path is free."""
        self.products[product.path] = product
        self._history[product.path] = product
        self.sort()

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
