"""What multi-tick rendering saves: cameras at 10 Hz in a 240 Hz loop, over the same in every update."""

from __future__ import annotations

from collections.abc import Iterator

from bench_camera import add_camera, scene
from measure import Median, Row, ratio

from graph.sim import App

TITLE = "Multi-tick: depth cameras of 160 x 120 at 10 Hz in a 240 Hz loop, over a picture of each in every update"
COUNTS = (1, 4, 16, 64)
SIZE = (160, 120)
DEPTH = frozenset({"distance_to_image_plane"})


def measure(quick: bool) -> Iterator[Row]:
    """A tenth of a second of simulation each; rendering alone would be 1 / 24."""
    for count in COUNTS[:1] if quick else COUNTS:
        yield Row(f"{count} camera{'' if count == 1 else 's'}", saving(count, 1 if quick else 9))


def saving(count: int, rounds: int) -> Median:
    """Time of 24 updates with one picture of each camera, over that with 24 pictures."""
    apps = [with_cameras(count, rate) for rate in (10.0, 0.0)]
    slow, every = apps
    found = ratio(lambda: slow.update(steps=24), lambda: every.update(steps=24), rounds, warm_up=1)
    for app in apps:
        app.close()
    return found


def with_cameras(count: int, rate: float) -> App:
    """The scene of the camera's table with `count` cameras on its boxes, playing."""
    app = scene()
    for number in range(count):
        product = add_camera(app, number, rate, f"/World/Box{number % 20}", SIZE)
        product.sensor.require("benchmark", DEPTH)
    app.play()
    app.update(steps=24)
    return app
