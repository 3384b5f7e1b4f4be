"""An App without pruning (`App(prune=False)`): what nothing requires is computed too, and dropped.

No output changes by it. Besides what is here, `World` makes physics where nothing can move, `Standing` casts at what
no ray reaches, and `SensorRuntime` computes all channels.
"""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING

import numpy as np

from graph.base.errors import UserError
from graph.sim.scene.stage import ignore_warning

from .raycast.shared import cast_world, present_app

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.messages.message import Message


def compute_everything(app: App) -> None:
    """From the next play on: ray casting without a sensor, a copy of all poses in each update, messages as bytes.

    Not after each step: a subscriber to steps makes physics take them one by one.
    """
    weak = weakref.ref(app)

    def build() -> None:
        app = present_app(weak)
        warn, app.world.warn = app.world.warn, ignore_warning
        try:
            cast_world(app).static_scene(np.zeros(3), frozenset())
        except UserError:
            pass  # a sensor that casts rays at it refuses it
        finally:
            app.world.warn = warn
            app.forget_geometry()  # a sensor that casts rays at it gives the warnings

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
