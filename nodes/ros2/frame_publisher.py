"""What the helpers share that publish a sensor's frames: they attach writers to a render product once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass, field
from graph.node import Attribute, Database
from nodes.fitting_sensors import misfit

from .frame_writers import FrameWriter, add_writer

if TYPE_CHECKING:
    from graph.sim.renderer.products import RenderProduct
    from sensors.annotators.annotator import Annotator

STAMP_INPUTS = {
    "resetSimulationTimeOnStop": Attribute(
        "bool", "stamp with the time since play; if not, with the time that no stop resets", default=True
    ),
    "useSystemTime": Attribute("bool", "stamp with the wall time of the last physics step", default=False),
}


@dataclass(slots=True)
class FramePublisher:
    """The memory of a helper from attaching to detaching: the product, the writers each with the product whose frames
    it gets, and the writer of the debug view.

    What the writers read is requested only while a topic has a subscriber, so that nothing is computed without need.
    """

    product: RenderProduct | None = None
    writers: list[tuple[RenderProduct, FrameWriter]] = field(default_factory=list)
    view: Any = None

    def request(self, wanted: bool) -> None:
        """Requests what the writers read, or withdraws the request; what is so already stays."""

    def listen(self, bus: Any) -> None:
        """Requests what the writers read while there are subscribers, and only then."""
        self.request(any(bus.has_subscribers(writer.topic) for _, writer in self.writers))

    def detach(self) -> None:
        """Removes the writers from their products and withdraws the request."""
        self.request(False)
        for product, writer in self.writers:
            product.writers[:] = [one for one in product.writers if one is not writer]
        if self.view is not None:
            self.view.detach()
        self.product, self.writers, self.view = None, [], None


@dataclass(slots=True)
class PointPublisher(FramePublisher):
    """Of points: the writers read channels of the sensor.

    demand: owner -> the channels to request, and whether also those above the prim's auxiliary level.
    """

    demand: dict[object, tuple[frozenset[str], bool]] = field(default_factory=dict)
    requested: bool = False

    def request(self, wanted: bool) -> None:
        """Requests the channels, or withdraws the request."""
        if self.product is None or wanted == self.requested:
            return
        sensor = self.product.sensor
        for owner, (channels, ignore_aux) in self.demand.items():
            if wanted:
                sensor.require(owner, channels, ignore_aux=ignore_aux)
            else:
                sensor.release(owner)
        self.requested = wanted


@dataclass(slots=True)
class CameraPublisher(FramePublisher):
    """Of a camera: the writers read an annotator; None: they read the lens."""

    annotator: Annotator | None = None

    def request(self, wanted: bool) -> None:
        """Attaches the annotator, or detaches it."""
        if self.annotator is None or self.product is None:
            return
        if wanted and self.annotator.product is None:
            self.annotator.attach(self.product)
        elif not wanted:
            self.annotator.detach()


def detach(db: Database) -> None:
    """Ends what a helper has attached."""
    db.memory.detach()


def publish_with(db: Database, product: RenderProduct, writer: FrameWriter) -> None:
    """Attaches a writer to the product, and notes it in the node's memory."""
    add_writer(db, product, writer)
    db.memory.writers.append((product, writer))


def product_of(db: Database, prim_type: str, code: str, path_input: str = "renderProductPath") -> RenderProduct | None:
    """The render product that a helper's input names; None, with a warning, without a path or for another sensor.

    prim_type: that of the sensor; code: of the warning of another sensor. Fails the node for a path without a product.
    """
    from graph.sim.scene.prim_paths import prim_at

    path = getattr(db.inputs, path_input)
    if not path:
        db.warn("render-product-missing", f"{path_input} is empty; connect it to a render product")
        return None
    product: RenderProduct | None = db.app.rendering.products.get(path)
    if any(product is attached for attached, _ in db.memory.writers):
        return product
    if product is None:
        detach(db)
        db.lack(f"there is no render product {path}; connect {path_input} to one")
    if problem := misfit(prim_at(db.app.stage, product.camera_path), product.camera_path, prim_type):
        detach(db)
        db.warn(code, f"{problem}; nothing is published")
        return None
    return product


def stamp_notes(db: Database) -> Iterator[tuple[str, str, str]]:
    """Input, code and message of inputs that are deprecated or contradict each other."""
    inputs = db.inputs
    if getattr(inputs, "frameSkipCount", 0):
        message = "frameSkipCount is deprecated; lower the sensor's tickRate instead"
        yield "frameSkipCount", "frame-skip-deprecated", message
    if inputs.useSystemTime and inputs.resetSimulationTimeOnStop:
        message = "useSystemTime stamps with wall time, which resetSimulationTimeOnStop cannot reset"
        yield "useSystemTime", "system-time-never-resets", message


def warn_of_inputs(db: Database, notes: Iterable[tuple[str, str, str]]) -> None:
    """Warns as the notes of a node say."""
    for _, code, message in notes:
        db.warn(code, message)
