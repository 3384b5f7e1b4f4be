"""The sensors and publishers that a graph uses, and those of them that produced nothing."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from graph.sim.scene.prim_paths import prim_at

from .printing import tell

if TYPE_CHECKING:
    from graph.session.runner import GraphRunner
    from graph.sim.app import App


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
    """How many frames each sensor that is read rendered, if it saw nothing in any of them."""
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
