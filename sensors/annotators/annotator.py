"""An annotator attached to a render product: requests channels of its sensor, returns the data of the newest frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.suggesting import Suggesting
from graph.sim import entered
from graph.sim.devices import same_device
from graph.sim.renderer.products import RenderProduct
from sensors.channels import AUXILIARY, Consumer
from sensors.errors import SensorValueError

from .registry import check_product
from .types import AnnotatorType, Reading

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.renderer.view import WorldView
    from sensors.frame import Frame

Product = Any
"""A render product, its path, or anything with a `path`."""

HOST = (None, "cpu", "cpu:0")
"""Devices whose memory is the host's."""


class Annotator(Suggesting):
    """`Annotator(kind).initialize(outputTimestamp=True).attach(product)`, then `get_data()` after each update.

    kind: from `sensors.annotators.types`. app: the App of the products; None is the App entered last. Options can be
    set until it is attached. owner: the consumer of its channels in `graph explain`; unset: the annotator. copies:
    whether data are the caller's own, to write on; else others may read the same arrays.
    """

    def __init__(self, kind: AnnotatorType, *, app: App | None = None, owner: str = "", copies: bool = True) -> None:
        self.kind = kind
        self.copies = copies
        self.options = kind.checked_options({})
        self._scene = None if app is None else app.world
        self._reading: Reading | None = None
        self._owner = Consumer(owner or f"annotator {kind.name}")
        self._known: tuple[Any, Any] | None = None

    @property
    def name(self) -> str:
        """Its name in the registry."""
        return self.kind.name

    def get_name(self) -> str:
        """Its name in the registry."""
        return self.kind.name

    @property
    def product(self) -> RenderProduct | None:
        """The render product it is attached to."""
        return self._reading.product if self._reading else None

    def initialize(self, **options: Any) -> Annotator:
        """Sets options. Raises SensorValueError for unknown ones, and after it is attached."""
        if self._reading is not None:
            raise SensorValueError(f"{self.name} is attached already; initialize it before attach")
        self.options = self.kind.checked_options({**self.options, **options})
        return self

    def attach(self, products: Product) -> Annotator:
        """Attaches it to a render product (or a list of one); the sensor then computes the channels that it reads.

        Raises SensorValueError for a product that does not exist, for a prim that it cannot read, and if it is already
        attached.
        """
        scene, product = only_product(products, self._scene, self.name)
        if self._reading is not None:
            raise SensorValueError(f"{self.name} is attached to {self._reading.product.path} already; detach it first")
        kind, reading = self.kind, Reading(scene, scene.times, product, self.options)
        check_product(kind, reading)
        if kind.instead:
            scene.warn("annotator-deprecated", kind.name, f"this annotator is deprecated; use {kind.instead}")
        optional = AUXILIARY if kind.optional else frozenset()
        reading.sensor.require(self._owner, kind.channels(reading), optional=optional)
        self._reading, self._known = reading, None
        return self

    def get_data(self, device: str | None = None, do_array_copy: bool | None = None) -> Any:
        """The data of the newest frame; between ticks the same object again.

        Before the first frame: empty arrays, or None for a buffer. Dictionaries have "data" and "info"; FlatScan's has
        its outputs by name. device: "cpu"; the App's device gives, for a point cloud or a GenericModelOutput, arrays
        that are still there (`graph help gpu`); None before the first frame. do_array_copy: True copies what
        an annotator without copies gives. Raises SensorValueError if it is not attached, RuntimeError after the product
        was removed.
        """
        reading = self._reading
        if reading is None:
            raise SensorValueError(f"{self.name} is not attached to a render product; attach it first")
        if reading.product.scene is None:
            raise RuntimeError(f"{reading.product.path} is gone: a stop ended it; attach to a new product")
        frame = reading.product.frame
        if device not in HOST:
            return self._on_device(device, reading, frame)
        keeps = self.kind.keeps_last and frame is not None and not frame.count
        if self._known is None or (self._known[0] is not frame and not keeps):
            reading.frame = None if keeps else frame
            found = self.kind.read(reading)
            self._known = (frame, owned(found, frame) if self.copies else found)
        found = self._known[1]
        return owned(found, frame) if do_array_copy and not self.copies else found

    def _on_device(self, device: str | None, reading: Reading, frame: Frame | None) -> Any:
        """The data as arrays on the App's device; None before the first frame."""
        arrays = frame.arrays if frame is not None else None
        there = self.kind.on_device
        if reading.scene.fidelity.device in HOST or there is None:
            check_device(device)
            return None
        if not same_device(str(device), reading.scene.fidelity.device):
            raise SensorValueError(
                f"device {device!r}: these frames are on {reading.scene.fidelity.device}; name that, or leave it out"
            )
        if frame is None:
            return None
        if not hasattr(arrays, "on_device"):
            raise SensorValueError(
                f"device {device!r}: these frames are made on the host (noise, sub-rays, glass, lidar.motion, another "
                "frame of reference than SENSOR, or a camera's); leave it out"
            )
        return there(frame)

    def detach(self, products: Product = None) -> None:
        """Withdraws its requests; harmless if it is not attached. products: as in Replicator, not needed."""
        if self._reading is not None:
            self._reading.sensor.release(self._owner)
            self._reading = self._known = None


def owned(found: Any, frame: Frame | None) -> Any:
    """Data in which no array shares its numbers with a frame: those are copied."""
    if isinstance(found, dict):
        return {name: owned(value, frame) for name, value in found.items()}
    if frame is None or not isinstance(found, np.ndarray):
        return found
    arrays = getattr(frame.arrays, "fetched", frame.arrays)  # of a frame on a device those that are on the host
    shared = (one for one in (*arrays.values(), *frame.cache.values()) if isinstance(one, np.ndarray))
    return found.copy() if any(np.may_share_memory(found, one) for one in shared) else found


def check_device(device: str | None) -> None:
    """Raises SensorValueError for anything but the host."""
    if device not in HOST:
        raise SensorValueError(f"device {device!r}: annotators are in host memory; leave it out")


def only_product(products: Product, scene: WorldView | None, name: str) -> tuple[WorldView, RenderProduct]:
    """The world and the single render product given by a product, a path, or a list of one.

    scene: the world of the product; None: its own, or for a path that of the App entered last. Raises SensorValueError,
    starting with `name`, for zero or several products, and for one that does not exist.
    """
    listed = list(products) if isinstance(products, (list, tuple)) else [products]
    if len(listed) != 1:
        raise SensorValueError(f"{name}: attach it to one render product, not {len(listed)}")
    [given] = listed
    path = str(getattr(given, "path", given))
    if isinstance(given, RenderProduct):
        product: RenderProduct | None = given
    else:
        product = (scene or entered.current().world).rendering.products.get(path)
    if product is None or product.scene is None or scene not in (None, product.scene):
        raise SensorValueError(f"{name}: there is no render product {path}; make one with create_render_product")
    return product.scene, product


def split_data(found: Any) -> tuple[Any, Mapping[str, Any]]:
    """(data, info) of an annotator's result: of a dictionary, "data" and the rest; of anything else, itself and {}."""
    if not isinstance(found, dict):
        return found, {}
    rest = {name: value for name, value in found.items() if name not in ("data", "info")}
    return found.get("data"), {**rest, **found.get("info", {})}
