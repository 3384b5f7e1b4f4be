"""Runs the first updates of a graph file without casting rays, and records what its graphs do."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from graph.sim.renderer.wrapper import SensorWrapper

from .explain_topics import named_frames
from .frames import FrameSink
from .idle_parts import product_makers, product_of

if TYPE_CHECKING:
    from graph.evaluate import Node
    from graph.session.open import Session
    from graph.sim.app import App
    from graph.sim.renderer.products import RenderProduct
    from graph.sim.renderer.schedule import Tick
    from graph.sim.renderer.sensor import Sensor

SHOWN_UPDATES = 12
MOST_UPDATES = 120
"""Most updates to wait for the render products that a graph makes late."""


class Blindfold(SensorWrapper):
    """Wraps a sensor: records the ticks that it should render, with their updates, and measures nothing."""

    def __init__(self, app: App, sensor: Sensor, ticks: list[tuple[int, Tick]]) -> None:
        super().__init__(sensor)
        self._app = app
        self._ticks = ticks

    def advance(self, start: Fraction, end: Fraction, poses: Any) -> None:
        """Casts nothing."""

    def render(self, tick: Tick) -> None:
        """Records the tick; returns no frame."""
        self._ticks.append((self._app.update_index, tick))


@dataclass(slots=True)
class Observed:
    """What happened in the first updates."""

    substeps: list[int] = field(default_factory=list)
    updates: int = 0
    products: dict[str, RenderProduct] = field(default_factory=dict)
    made_in: dict[str, int] = field(default_factory=dict)
    """The update in which each product was created."""
    ticks: dict[str, list[tuple[int, Tick]]] = field(default_factory=dict)
    """By product: each update that would render it, and the tick."""
    makers: dict[str, list[str]] = field(default_factory=dict)
    """The paths of the nodes that name each product."""
    unmade: list[Node] = field(default_factory=list)
    """Enabled product nodes that created no product."""
    channels: dict[str, list[str]] = field(default_factory=dict)
    """What each product's sensor computes while every topic has a listener."""
    demand: dict[str, dict[str, list[str]]] = field(default_factory=dict)
    """By product: consumer to the channels that it requests."""
    unheard: dict[str, set[str]] = field(default_factory=dict)
    """By product: the consumers that request nothing while their topic has no listener."""
    ignored: dict[Node, tuple[int, int]] = field(default_factory=dict)
    """By node that ignored triggers in the first updates because it slept: how many of how many."""
    frames: FrameSink = field(default_factory=FrameSink)
    """The frames of the published transforms."""


def observe(session: Session) -> Observed:
    """Plays a session for twelve updates, or longer while a render product is still missing."""
    from graph.session.step_limit import check_steps
    from graph.sim.messages.bus import CountingSink

    app, seen = session.app, Observed()
    nodes = [node for graph in session.runner.graphs.values() for node in graph.nodes.values()]
    makers = product_makers(nodes)
    app.on("render", lambda: _blindfold(app, seen), order=-1)
    heard = CountingSink()  # as in `graph run`, which records every topic
    app.bus.subscribe(heard)
    app.bus.subscribe(seen.frames)
    app.play()
    check_steps(app)
    while seen.updates < SHOWN_UPDATES or (seen.updates < MOST_UPDATES and any(map(_is_unmade, makers))):
        _update(app, nodes, seen)
        if app.exit_requested:
            break
    for node in makers:
        if _is_unmade(node):
            seen.unmade.append(node)
        else:
            seen.makers.setdefault(product_of(node), []).append(node.path)
    for path, product in seen.products.items():
        seen.demand[path] = demand_of(product)
        computed = product.sensor.channels()
        seen.channels[path] = [name for name in product.sensor.consumers() if name in computed]
    app.bus.unsubscribe(heard)
    app.bus.unsubscribe(seen.frames)
    # Sensors render nothing here, so no message of theirs names its frame.
    for topic, path, frame in named_frames(session, (node for node in nodes if node.computes)):
        if topic in app.bus.topics and path in app.bus.topics[topic].owners:
            seen.frames.expect(topic, frame)
    if not app.exit_requested:
        app.update(seen.updates)
    seen.products = {path: seen.products[path] for path in seen.demand}  # without products that were created since
    for path, product in seen.products.items():
        seen.unheard[path] = set(seen.demand[path]) - set(demand_of(product))
    return seen


def demand_of(product: RenderProduct) -> dict[str, list[str]]:
    """Consumer to the channels that it requests; several requests of one consumer are joined."""
    asked: dict[str, list[str]] = {}
    for channel, owners in product.sensor.consumers().items():
        for owner in dict.fromkeys(owners):
            asked.setdefault(owner, []).append(channel)
    return asked


def _is_unmade(node: Node) -> bool:
    return not product_of(node)


def _blindfold(app: App, seen: Observed) -> None:
    for path, product in app.rendering.products.items():
        if not isinstance(product.sensor, Blindfold):
            seen.products[path], seen.ticks[path] = product, []
            product.sensor = Blindfold(app, product.sensor, seen.ticks[path])
            seen.made_in[path] = app.update_index


def _update(app: App, nodes: list[Node], seen: Observed) -> None:
    steps = app.simulation.get_num_physics_steps()
    app.update()
    seen.updates += 1
    if seen.updates > SHOWN_UPDATES:
        return
    seen.substeps.append(max(0, app.simulation.get_num_physics_steps() - steps))
    seen.ignored = {node: (node.ignored, node.triggered) for node in nodes if node.ignored}
