"""Writers that publish the frames of a render product, one for each kind of message."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from graph.base.exact import NANOSECONDS, nanoseconds
from graph.base.records import dataclass
from graph.sim import settings as keys
from graph.sim.messages.bus import topic_name
from graph.sim.messages.message import Cadence

from .profiles import offered_quality

if TYPE_CHECKING:
    from graph.node import Database
    from graph.sim.app import App
    from graph.sim.renderer.products import RenderProduct
    from sensors.frame import Frame


@dataclass(slots=True, eq=False)
class FrameWriter:
    """Publishes every `every`-th frame, if the topic has a listener.

    stamp: frame -> stamp of its message [ns]; make: frame and stamp -> message. gate: the annotator whose data a writer
    of a camera sends, by which a script thins its messages out (`thin`).
    """

    bus: Any
    topic: str
    type_name: str
    stamp: Callable[[Frame], int]
    make: Callable[[Frame, int], Any]
    every: int = 1
    gate: str = ""
    frames: int = 0
    product: RenderProduct | None = None
    """The product whose frames it gets, once it is attached."""
    due_before: int = 0
    """Ticks of the product that were due before it was attached."""
    cadence: Cadence | None = None

    def thin(self, every: int) -> None:
        """Publishes every `every`-th frame from now on."""
        before, self.every = self.cadence, every
        if before is not None:
            self.cadence = Cadence(before.sensor, before.rate, every, before.ticks)
            self.bus.topics[topic_name(self.topic)].refollow(before, self.cadence)

    def __call__(self, frame: Frame) -> None:
        """Takes one frame."""
        self.frames += 1
        if self.product is not None:
            assert self.cadence is not None
            self.cadence.ticks.count = self.product.due - self.due_before
        if self.frames % self.every == 0 and self.bus.has_subscribers(self.topic):
            at = self.stamp(frame)
            self.bus.publish(self.topic, self.type_name, self.make(frame, at), at)


def add_writer(db: Database, product: RenderProduct, writer: FrameWriter) -> None:
    """Announces a writer's topic with the sensor's schedule, and attaches the writer to the product."""
    writer.product, writer.due_before = product, product.due
    writer.cadence = Cadence(product.camera_path, product.sensor.rate, writer.every)
    db.app.bus.advertise(writer.topic, writer.type_name, db.path, offered_quality(db), writer.cadence)
    product.writers.append(writer)


def stamps(
    app: App,
    *,
    system_time: bool,
    reset_on_stop: bool,
    first_ray: Callable[[Frame], int] | None = None,
    from_start: bool = False,
) -> Callable[[Frame], int]:
    """Frame -> stamp [ns]: wall time of the last physics step, else the simulation time of the frame's pose, counted
    from play or so that no stop resets it. first_ray: frame -> the time [ns] of the first ray, which a LaserScan's
    header has, except where the frame shows one instant. from_start: the nominal time of the first firing, also of a
    frame of one instant. A stamp is never 0, which to tf2 is not a time but the request for the latest transform.
    """
    simulation = app.simulation
    if system_time:
        return lambda frame: round(simulation.system_time * NANOSECONDS)

    def stamp_of(frame: Frame) -> int:
        clock = simulation.time if reset_on_stop else simulation.monotonic_time
        off = clock - app.rendering.time
        if from_start:
            return max(1, frame.timestamp_ns + nanoseconds(off))
        if first_ray and not frame.one_instant and app.settings.get(keys.LIDAR_HEADER) != keys.HEADER_UPDATE:
            return max(1, first_ray(frame) + nanoseconds(off))
        return max(1, nanoseconds(frame.reference + off))

    return stamp_of
