"""How a node polls a sensor: shared with its other readers, its channels withdrawn at a stop."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from graph.base.errors import UserError
from graph.base.records import dataclass
from graph.node import Database, NodeAtLoad
from nodes.fitting_sensors import misfit
from nodes.sensing.imu import sensor_prim

if TYPE_CHECKING:
    from sensors.frame import Frame
    from sensors.polled import PolledSensor


@dataclass(slots=True)
class Poll:
    """Memory of a node that polls a sensor: the sensor, and the last frame that it gave."""

    path: str = ""
    polled: PolledSensor | None = None
    frame: Frame | None = None


def check_polled(node: NodeAtLoad, name: str, prim_type: str) -> Iterator[tuple[str, str]]:
    """What `misfit` says of the prim in a target input, before anything runs."""
    from graph.sim.scene.prim_paths import prim_at

    for path in getattr(node.db.inputs, name) if name in node.given else ():
        prim = prim_at(node.stage, str(path))
        if prim and (problem := misfit(prim, str(path), prim_type)):
            yield name, problem


def release(db: Database) -> None:
    """Withdraws the request, at a stop."""
    _withdraw(db)
    db.memory.frame = None


def _withdraw(db: Database) -> None:
    memory: Poll = db.memory
    if memory.polled is not None:
        memory.polled.release(db.path)
    memory.path, memory.polled = "", None


def poll(db: Database, name: str, prim_type: str, channels: Iterable[str]) -> Frame | None:
    """The newest frame of the sensor that a target input names; None before the first, when stopped, and while nobody
    reads what the node gives.

    Fails the node for a prim of another type and for an invalid sensor prim.
    """
    from sensors.polled import polled_sensor

    memory: Poll = db.memory
    if db.app.timeline.is_stopped():
        return None
    if not db.is_read():
        _withdraw(db)
        return None
    targets: Any = getattr(db.inputs, name)
    path = str(targets[0]) if len(targets) == 1 else ""
    if memory.polled is None or path != memory.path:
        _withdraw(db)
        prim = sensor_prim(db, targets, name)
        try:
            memory.polled = polled_sensor(db.app.world, str(prim.GetPath()), prim_type)
        except UserError as error:
            db.fail(str(error))
        memory.path = path
        memory.polled.require(db.path, channels)
    return memory.polled.read()
