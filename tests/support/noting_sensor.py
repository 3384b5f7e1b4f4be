"""A sensor for tests of clocks and schedules: it measures nothing and notes what the scheduler asks of it."""

from fractions import Fraction

from graph.base.exact import nanoseconds
from graph.sim.renderer.products import RenderProduct
from graph.sim.renderer.schedule import EveryUpdate, Tick, TickSchedule


class Instant(Tick):
    """The frame of a tick: the tick again, without elements, stamped with the time of the update that renders it."""

    count = 0

    def __init__(self, tick):
        super().__init__(tick.index, tick.rate, tick.time, tick.start, tick.end, tick.poses)
        self.tick = tick
        self.timestamp_ns = nanoseconds(tick.time)
        self.reference = tick.time


class NotingSensor:
    """Renders the instant of each tick, as a camera does; of rate 0 [Hz], in every update in which the time moved.

    Its frames are `Instant`s; a silent sensor delivers none. `ticks` holds all it rendered, `asked` those and the
    (start, end) of each `advance`, in order; both outlive a reset, which is counted.
    """

    accumulates = False
    latency = Fraction(0)

    def __init__(self, rate=0, *, wants_updates=False, silent=False):
        self.rate = Fraction(rate)
        self.schedule = TickSchedule(self.rate, accumulates=self.accumulates) if rate else EveryUpdate()
        self.wants_updates = wants_updates
        self.silent = silent
        self.ticks = []
        self.asked = []
        self.resets = 0
        self.product = None

    def render(self, tick):
        self.ticks.append(tick)
        self.asked.append(tick)
        return None if self.silent else Instant(tick)

    def advance(self, start, end, poses):
        self.asked.append((start, end))

    def reset(self):
        self.resets += 1


class NotingLidar(NotingSensor):
    """Renders all that was between two ticks, as a lidar does."""

    accumulates = True


def add(app, sensor, name="sensor"):
    """Gives an App this sensor with the render product /Render/<name>; returns the sensor."""
    sensor.product = app.rendering.add(RenderProduct(f"/Render/{name}", "/World/Sensor", (1, 1), sensor))
    return sensor
