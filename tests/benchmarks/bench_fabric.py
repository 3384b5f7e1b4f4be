"""What Fabric saves: updates with prims that move, with Fabric off over on; and what a state per sensor tick costs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from measure import Row, ratio

from graph.sim import App
from sensors import Lidar, LidarSensor

TITLE = "Fabric and tlas"
COUNTS = (10, 100, 1_000, 10_000)
UPDATES = 4
BODIES = 1_000
"""Most bodies of a world; the engine takes a minute and a half to compile 10,000."""
LOOP_HZ = 24
"""Of the worlds with a lidar."""


def measure(quick: bool) -> Iterator[Row]:
    """Updates of 240 Hz physics in a 60 Hz loop; all bodies fall freely, so that physics itself costs little."""
    for count in COUNTS[:2] if quick else COUNTS:
        rounds = 1 if quick else max(3, 25 // max(1, count // 1000))
        yield Row(f"update with {count:,} moving prims, Fabric off / on", off_over_on(count, rounds, False))
        yield Row(
            f"the same with {count:,}, all world transforms read in each update", off_over_on(count, rounds, True)
        )
    rounds = 1 if quick else 25
    for hz in (240, 960):
        yield Row(
            f"tlas sensor / frame, a 10 Hz lidar, {hz // LOOP_HZ} steps per update", sensor_over_frame(hz, rounds)
        )


def off_over_on(count: int, rounds: int, read: bool) -> float:
    """How much longer updates take with Fabric off."""
    with falling(count, "on") as on, falling(count, "off") as off:
        return ratio(lambda: run(off, count, read), lambda: run(on, count, read), rounds)


def run(app: App, count: int, read: bool) -> None:
    """Some updates; read: then look where every prim is."""
    paths = list(prims(count))
    for _ in range(UPDATES):
        app.update()
        if read:
            app.fabric.world_matrices(paths)


def falling(count: int, fabric: str) -> App:
    """An App in which so many prims fall, far from each other."""
    app = App(physics_hz=240, loop_hz=60, fidelity={"fabric": fabric})
    app.add_prims(prims(count))
    app.play()
    app.update(2)
    return app


def prims(count: int) -> dict[str, dict[str, Any]]:
    """Bodies without colliders, so that what is measured is the writing; above `BODIES` each carries more prims."""
    bodies = min(count, BODIES)
    out: dict[str, dict[str, Any]] = {}
    for number in range(bodies):
        path = f"/World/Ball{number}"
        out[path] = {
            "type": "Sphere", "radius": 0.1, "translate": [number % 100, number // 100, 1e4], "rigid_body": True,
            "collision": False, "mass": 1.0, "attributes": {"physics:diagonalInertia": [0.004, 0.004, 0.004]},
        }  # fmt: skip
        for part in range(count // bodies - 1):
            out[f"{path}/Part{part}"] = {"translate": [0.1 * part, 0, 0]}
    return out


def sensor_over_frame(hz: int, rounds: int) -> float:
    """How much longer updates take when a lidar sees the state of its own tick, not the update's last one."""
    with scanned("sensor", hz) as sensor, scanned("frame", hz) as frame:
        return ratio(lambda: sensor.update(12), lambda: frame.update(12), rounds)


def scanned(tlas: str, hz: int) -> App:
    """Twenty moving boxes around a lidar of 10 Hz, two of whose three ticks are in the middle of updates of 24 Hz."""
    app = App(physics_hz=hz, loop_hz=LOOP_HZ, fidelity={"tlas": tlas})
    boxes = {
        f"/World/Box{number}": {
            "type": "Cube", "size": 0.5, "translate": [3 + number % 5, number // 5 - 2, 0.3], "rigid_body": True,
            "velocity": [0.1 * number, 1, 0],
        }
        for number in range(20)
    }  # fmt: skip
    app.add_prims({"/World/Ground": {"type": "Plane"}, **boxes})
    lidar = Lidar.create("/World/Lidar", config="Example_Rotary", translations=[0, 0, 1], tick_rate=10.0, app=app)
    app.play()
    sensors[app] = LidarSensor(lidar, annotators=["generic-model-output"])
    app.update(12)
    return app


sensors: dict[App, LidarSensor] = {}
"""Keeps the sensors at work."""
