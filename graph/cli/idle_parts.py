"""Parts without an effect: sensors that nothing reads, products that are never made, triggers that a wait ignores.

`graph explain` and `graph run` share these sentences.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from graph.session.link_checks import nobody_consumes

if TYPE_CHECKING:
    from graph.evaluate import Node
    from graph.session.runner import GraphRunner
    from graph.sim.app import App

Trap = tuple[str, str, str]
"""Code, where, message."""


def product_makers(nodes: Iterable[Node]) -> list[Node]:
    """The nodes that should make render products."""
    return [node for node in nodes if node.type.outputs_as("product") and _is_enabled(node)]


def product_of(node: Node) -> str:
    """The path of the render product that a node gives; "" before it has given one."""
    return str(node.get(f"outputs:{node.type.outputs_as('product')[0]}") or "")


def product_not_made(node: Node, updates: int) -> Trap:
    """The message about a node that has made no product in so many updates."""
    return "product-not-made", node.path, f"it makes no render product in the first {updates:,} updates"


def latent_retriggered(node: Node, ignored: int, triggered: int, updates: int) -> Trap:
    """The message about a node that ignored triggers while it slept."""
    return (
        "latent-retriggered",
        node.path,
        f"{node.type.short_name} sleeps through {ignored:,} of its {triggered:,} triggers in the first {updates:,} "
        "updates, and starts over when it ends; to wait once, put Once before it",
    )


def idle_in_run(app: App, runner: GraphRunner) -> Iterator[Trap]:
    """All such warnings of a run that is about to end."""
    nodes = [node for graph in runner.graphs.values() for node in graph.nodes.values()]
    made: dict[str, list[str]] = {}
    for node in product_makers(nodes):
        if path := product_of(node):
            made.setdefault(path, []).append(node.path)
        elif app.update_index:
            yield product_not_made(node, app.update_index)
    for product in app.rendering.products.values():
        if product.frames and not (product.sensor.consumers() or product.writers):
            yield nobody_consumes(product.camera_path, made.get(product.path, [product.path]))
    for node in nodes:
        if ignored := node.ignored:
            yield latent_retriggered(node, ignored, node.triggered, app.update_index)


def _is_enabled(node: Node) -> bool:
    return "enabled" not in node.type.inputs or bool(node.get("enabled"))
