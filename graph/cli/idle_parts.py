"""Parts without an effect: what nothing reads or hears, what never ran, triggers that a wait ignores.

`graph explain`, `graph run` and `graph exec` share these sentences.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from graph.session.graph_links import nobody_consumes
from graph.session.missed_ticks import missed_in_run
from graph.sim.scene.prim_paths import prim_at

from .explain_topics import shared_topics
from .printing import tell

if TYPE_CHECKING:
    from graph.evaluate import Node
    from graph.session.runner import GraphRunner
    from graph.sim.app import App

    from .frames import FrameSink

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
    """The warnings of a run that is about to end: products never made or never read, ignored triggers."""
    nodes = [node for graph in runner.graphs.values() for node in graph.nodes.values()]
    made: dict[str, list[str]] = {}
    for node in product_makers(nodes):
        if path := product_of(node):
            made.setdefault(path, []).append(node.path)
        elif app.update_index and (app.timeline.is_playing() or not node.computes):  # a stop empties outputs
            yield product_not_made(node, app.update_index)
    for product in app.rendering.products.values():
        if product.frames and not (product.sensor.consumers() or product.writers):
            yield nobody_consumes(product.camera_path, made.get(product.path, [product.path]))
    for node in nodes:
        if ignored := node.ignored:
            yield latent_retriggered(node, ignored, node.triggered, app.update_index)


def warn_at_end(app: App, runner: GraphRunner, frames: FrameSink) -> list[Trap]:
    """Warns of what a run that is about to end missed, left idle, or published ambiguously.

    frames: of the transforms that the run published. Returns the warnings of missed ticks.
    """
    missed = [*missed_in_run(app)]
    for warning in (*missed, *idle_in_run(app, runner), *frames.warnings(app.bus), *shared_topics(app.bus)):
        app.warn(*warning)
    return missed


def _is_enabled(node: Node) -> bool:
    return "enabled" not in node.type.inputs or bool(node.get("enabled"))


def wired_sensors(app: App, runner: GraphRunner) -> Iterator[str]:
    """Paths of the sensor prims that nodes name, in file order, rendered or not."""
    named = [path for node in _nodes(runner) for name in node.type.inputs_as("sensor") for path in node.get(name) or ()]
    if not named:  # the types of all sensors would be loaded for nothing
        return
    from sensors.sensor_types import sensor_types

    known = sensor_types()
    for path in named:
        prim = prim_at(app.stage, path)
        if prim and str(prim.GetTypeName()) in known:
            yield str(path)


def silent_parts(app: App, runner: GraphRunner) -> list[str]:
    """A line for each used sensor without a frame or without any return, and each publisher without a message."""
    rendered = {product.camera_path for product in app.rendering.history if product.frames}
    blind = blind_sensors(app)
    lines = [
        f"sensor {path} rendered {blind[path]} frames without a single return"
        if path in blind
        else f"sensor {path} rendered no frame"
        for path in dict.fromkeys((*wired_sensors(app, runner), *blind))
        if path in blind or path not in rendered
    ]
    heard: dict[str, int] = {}
    for topic in app.bus.topics.values():
        for owner in topic.owners:
            heard[owner] = heard.get(owner, 0) + topic.messages
    lines += [
        f"publisher {node.path} sent no message" + ("" if node.computes else "; it never computed")
        for node in _nodes(runner)
        if node.type.inputs_as("topic") and not heard.get(node.path)
    ]
    return lines


def strict_code(silent: Iterable[str], missed: Iterable[tuple[str, str, str]]) -> int:
    """What `--strict` makes of a run: prints each silent part and each sensor with missed ticks; 1 if there are any."""
    faults = [*silent, *(f"sensor {where}: {message}" for _, where, message in missed)]
    for line in faults:
        tell(f"strict: {line}")
    return 1 if faults else 0


def blind_sensors(app: App) -> dict[str, int]:
    """Path -> number of frames, of each sensor that has readers and saw nothing in any frame."""
    frames: dict[str, int] = {}
    seen: set[str] = set()
    for product in app.rendering.history:
        if not (product.sensor.consumers() or product.writers):
            continue
        path = product.camera_path
        frames[path] = frames.get(path, 0) + product.frames
        if product.elements:
            seen.add(path)
    return {path: count for path, count in frames.items() if count and path not in seen}


def warn_of_blind_sensors(app: App) -> None:
    """Warns of each sensor that rendered and saw nothing in any of its frames."""
    from sensors.sensor_types import sensor_types

    for path, count in blind_sensors(app).items():
        prim = app.stage.GetPrimAtPath(path)
        kind = sensor_types().get(str(prim.GetTypeName())) if prim else None
        asks = "is something within its range, in its view and not excluded?"
        why = kind.blind(app.world, prim) if kind else ""
        app.warn("sensor-saw-nothing", path, f"no return in any of its {count} frames; {asks} {why}".rstrip())


def _nodes(runner: GraphRunner) -> Iterator[Any]:
    for graph in runner.graphs.values():
        yield from graph.nodes.values()
