"""Apps without pruning: what nothing requires is computed too, and dropped; no output changes by it."""

import math
import weakref
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from graph.base.errors import UserError
from graph.sim.app import App
from graph.sim.physics import MUJOCO, build_physics
from graph.sim.physics.read_forces import start_surfaces
from graph.sim.physics.read_world import read_world
from graph.sim.scene.scan import scan_stage
from graph.sim.scene.stage import ignore_warning
from sensors.camera.channels import CROSS, LIT
from sensors.raycast.shared import cast_world
from sensors.raycast.standing import Standing
from sensors.raycast.triangles import TriangleScene
from sensors.runtime import SensorRuntime

ON_REQUEST = LIT | {CROSS}
"""Channels that read more, and may warn of it."""


@contextmanager
def unpruned():
    """Within it there is always physics, rays are cast at the whole world on structures of one App, and sensors compute
    all their channels; Apps that are made in it also cast rays without a sensor, copy all poses in each update (not
    after each step: a subscriber to steps makes physics take them one by one), and turn messages into bytes.
    """
    scene, channels, render, init = Standing.scene, SensorRuntime.channels, SensorRuntime.render, App.__init__

    def all_channels(self):
        return channels(self) | {one.name for one in self.kind.channels if not one.setting} - ON_REQUEST

    def rendered(self, tick):
        frame, requested = render(self, tick), channels(self)
        if frame is None:
            return None
        arrays = {name: array for name, array in frame.arrays.items() if name in requested}
        return replace(frame, arrays=arrays, count=frame.count if requested or frame.modality == "CAMERA" else 0)

    def made(self, *arguments, **options):
        init(self, *arguments, **options)
        compute_everything(self)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("graph.sim.physics.build_physics", always_built)
        patch.setattr(Standing, "build", lambda self, vertices, triangles: TriangleScene(vertices, triangles))
        patch.setattr(Standing, "scene", lambda self, *place: scene(self, *place[:-1], math.inf))
        patch.setattr(SensorRuntime, "channels", all_channels)
        patch.setattr(SensorRuntime, "render", rendered)
        patch.setattr(App, "__init__", made)
        yield


def always_built(stage, dt, fidelity=None, *, engine=MUJOCO, mjcf=None, **options):
    """As `build_physics`, but there is an engine where nothing can move, too."""
    physics = build_physics(stage, dt, fidelity, engine=engine, mjcf=mjcf, **options)
    if physics is not None:
        return physics
    scan = scan_stage(stage)
    try:
        world = read_world(scan, ignore_warning)
        how = {"meters_per_unit": scan.meters_per_unit, "fidelity": fidelity, "warn": ignore_warning, "mjcf": mjcf}
        physics = engine(world, dt, **how)
        start_surfaces(physics, ignore_warning)
    except UserError:
        return None  # whatever is wrong with it, nothing requires it
    return physics


def compute_everything(app):
    """From the next play on: ray casting without a sensor, a copy of all poses in each update, messages as bytes."""
    weak = weakref.ref(app)

    def build():
        app = weak()
        warn, app.world.warn = app.world.warn, ignore_warning
        try:
            cast_world(app.world).static_scene(np.zeros(3), frozenset())
        except UserError:
            pass  # a sensor that casts rays at it refuses it
        finally:
            app.world.warn = warn
            app.forget_geometry()  # a sensor that casts rays at it gives the warnings

    app.on("play", build)
    app.on("physics", lambda: weak().fabric.capture())
    app.bus.subscribe(SerialisingSink())


class SerialisingSink:
    """Turns every message into bytes."""

    def advertise(self, topic, type_name):
        """Does nothing."""

    def write(self, message):
        """Serialises a message."""
        message.cdr()

    def close(self):
        """Does nothing."""
