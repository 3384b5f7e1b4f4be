"""An App without pruning (`App(prune=False)`): what nothing requires is computed too, and dropped.

No output changes by it. Besides what is here, `World` makes physics where nothing can move, `Standing` casts at what
no ray reaches, and `SensorRuntime` computes all channels.
"""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING

import numpy as np

from .raycast.shared import cast_world, present_app

if TYPE_CHECKING:
    from graph.sim import App
    from graph.sim.messages.message import Message


def compute_everything(app: App) -> None:
    """From the next play on: ray casting without a sensor, a copy of all poses in each update, messages as bytes.

    Not after each step: a subscriber to steps makes physics take them one by one.
    """
    weak = weakref.ref(app)

    def build() -> None:
        cast_world(present_app(weak)).static_scene(np.zeros(3), frozenset())

    def copy_poses() -> None:
        present_app(weak).fabric.capture()

    app.on("play", build)
    app.on("physics", copy_poses)
    app.bus.subscribe(SerialisingSink())


class SerialisingSink:
    """Turns every message into bytes."""

    def advertise(self, topic: str, type_name: str) -> None:
        """Does nothing."""

    def write(self, message: Message) -> None:
        """Serialises a message."""
        message.cdr()

    def close(self) -> None:
        """Does nothing."""
