"""The sensor scheduler: who renders in which update, from which captured state."""

from __future__ import annotations

from fractions import Fraction

import pytest

from graph.base.errors import UserError
from graph.sim.renderer.scheduler import SensorScheduler
from graph.sim.timing.clocks import PhysicsClock
from tests.support.noting_sensor import NotingLidar, NotingSensor, add


class World:
    """A physics clock and, as an App's rendering, a scheduler; a captured state is the step count it was taken at."""

    def __init__(self, physics=240, per_update=4):
        self.clock = PhysicsClock(Fraction(physics))
        self.per_update = per_update
        self.updates = 0
        self.captures = []
        self.rendering = SensorScheduler(self.clock, self.capture, lambda: Fraction(self.updates, 60))
        self.rendering.scene = self

    def capture(self):
        self.captures.append(self.clock.count)
        return self.clock.count

    def steps(self, count, *, renders_there=False):
        self.rendering.plan(self.clock.count + count, renders_there=renders_there)
        for _ in range(count):
            self.clock.advance()
            if self.clock.count == self.rendering.next_capture:
                self.rendering.capture()

    def update(self, steps=None, inside=lambda: None):
        self.updates += 1
        self.rendering.begin_update(Fraction(1, 60))
        self.steps(self.per_update if steps is None else steps, renders_there=True)
        inside()
        self.rendering.render_due()
        self.rendering.end_update()


def test_ten_hertz_at_sixty_renders_every_sixth_update():
    world, sensor = World(), NotingLidar(10)
    product = add(world, sensor).product
    rendered = []
    for update in range(1, 19):
        world.update()
        if product.new_frame:
            rendered.append(update)
    assert rendered == [6, 12, 18]
    assert [(tick.start, tick.end) for tick in sensor.ticks] == [
        (Fraction(k - 1, 10), Fraction(k, 10)) for k in (1, 2, 3)
    ]
    assert (product.frames, product.missed, product.due) == (3, 0, 3)


def test_a_grid_time_on_the_last_substep_needs_no_capture():
    world = World()
    add(world, NotingLidar(10))
    for _ in range(12):
        world.update()
    assert world.captures == []


def test_a_frozen_sensor_gets_the_first_state_at_or_after_its_grid_time():
    world, sensor = World(), NotingLidar(7)
    add(world, sensor)
    for _ in range(30):
        world.update()
    # ceil(240 k / 7) = 35, 69, 103; updates end on multiples of 4
    assert world.captures == [35, 69, 103]
    assert [tick.poses for tick in sensor.ticks] == [35, 69, 103]


def test_sensors_of_one_rate_share_one_capture():
    world, sensors = World(), [NotingLidar(7), NotingLidar(7)]
    for number, sensor in enumerate(sensors):
        add(world, sensor, str(number))
    for _ in range(9):
        world.update()
    assert world.captures == [35]
    assert [sensor.ticks[0].poses for sensor in sensors] == [35, 35]


def test_cameras_and_advancing_lidars_see_the_state_of_the_update():
    world = World()
    camera, moving = NotingSensor(7), NotingLidar(7, wants_updates=True)
    add(world, camera, "camera")
    add(world, moving, "moving")
    for _ in range(9):
        world.update()
    assert world.captures == []
    assert camera.ticks[0].poses is None
    assert camera.ticks[0].time == Fraction(36, 240)


def test_tlas_frame_takes_no_captures():
    world, sensor = World(), NotingLidar(7)
    world.rendering.capture_at_ticks = False
    add(world, sensor)
    for _ in range(9):
        world.update()
    assert world.captures == []
    assert sensor.ticks[0].poses is None


def test_direct_steps_past_a_grid_time_keep_its_state_for_the_next_render():
    world, sensor = World(), NotingLidar(10)
    add(world, sensor)
    world.steps(24)  # ends on the grid time itself
    world.steps(3)
    world.update()
    assert [(tick.index, tick.poses) for tick in sensor.ticks] == [(1, 24)]


def test_a_newer_tick_replaces_the_state_kept_for_an_older_one():
    world, sensor = World(), NotingLidar(10)
    add(world, sensor)
    world.steps(30)
    world.steps(30)
    world.update()
    assert [(tick.index, tick.poses) for tick in sensor.ticks] == [(2, 48)]


def test_nothing_renders_in_an_update_without_a_physics_step():
    world = World()
    auto, moving = NotingSensor(), NotingLidar(10, wants_updates=True)
    add(world, auto, "auto")
    add(world, moving, "moving")
    for _ in range(5):
        world.update(steps=0)
    assert auto.asked == []
    assert moving.asked == []


def test_a_sensor_of_rate_zero_renders_whenever_time_moved():
    world, sensor = World(), NotingSensor()
    add(world, sensor)
    for steps in (4, 0, 8):
        world.update(steps)
    assert [(tick.start, tick.end) for tick in sensor.ticks] == [
        (Fraction(0), Fraction(4, 240)),
        (Fraction(4, 240), Fraction(12, 240)),
    ]


def test_an_advancing_sensor_hears_of_every_update_before_its_tick():
    world, sensor = World(), NotingLidar(30, wants_updates=True)
    add(world, sensor)
    for _ in range(4):
        world.update()
    slices = [entry if isinstance(entry, tuple) else entry.index for entry in sensor.asked]
    sixtieths = [Fraction(n, 60) for n in range(5)]
    assert slices == [
        (sixtieths[0], sixtieths[1]),
        (sixtieths[1], sixtieths[2]),
        1,
        (sixtieths[2], sixtieths[3]),
        (sixtieths[3], sixtieths[4]),
        2,
    ]


def test_a_product_made_by_a_graph_exists_from_the_start_of_its_update():
    world, sensor = World(), NotingLidar(60)
    world.update(inside=lambda: add(world, sensor))
    assert [tick.index for tick in sensor.ticks] == [1]


def test_the_countdown_of_the_documentation():
    world, sensor = World(), NotingLidar(20)
    for _ in range(5):
        world.update()
    world.update(inside=lambda: add(world, sensor))
    for _ in range(294):
        world.update()
    assert len(sensor.ticks) == 98
    assert sensor.ticks[0].start == Fraction(1, 10)


def test_products_render_in_the_order_of_their_creation():
    world = World()
    for name, rate in (("a", 30), ("b", 0), ("c", 60)):
        add(world, NotingLidar(rate), name)
    world.update()
    world.update()
    assert [product.path for product in world.rendering.new_frames] == ["/Render/a", "/Render/b", "/Render/c"]


def test_a_new_frame_is_new_for_one_update():
    world = World()
    product = add(world, NotingLidar(10)).product
    for _ in range(6):
        world.update()
    assert product.new_frame
    world.update(steps=0)
    assert not product.new_frame
    assert product.frame.tick is product.sensor.ticks[0]


def test_a_render_that_delivers_nothing_counts_no_frame():
    world = World()
    product = add(world, NotingLidar(60, silent=True)).product
    world.update()
    assert (product.frames, product.new_frame, world.rendering.new_frames) == (0, False, [])


def test_a_disabled_product_renders_nothing_and_misses_nothing():
    world, sensor = World(), NotingLidar(10)
    product = add(world, sensor).product
    for _ in range(7):
        world.update()
    product.enabled = False
    for _ in range(20):
        world.update()
    product.enabled = True  # at 27/60 s: the next whole scan is [0.5, 0.6)
    for _ in range(10):
        world.update()
    assert [tick.index for tick in sensor.ticks] == [1, 6]
    assert product.missed == 0


def test_a_removed_product_stays_in_the_history():
    world, sensor = World(), NotingLidar(60)
    product = add(world, sensor).product
    world.update()
    world.rendering.remove(product.path)
    world.rendering.remove(product.path)
    world.update()
    assert len(sensor.ticks) == 1
    assert world.rendering.history == (product,)


def test_two_products_cannot_share_a_path():
    world = World()
    add(world, NotingLidar(10))
    with pytest.raises(UserError, match="/Render/sensor already exists"):
        add(world, NotingLidar(10))


def test_a_sensor_faster_than_the_loop_misses_grid_times():
    world, sensor = World(), NotingLidar(100)
    product = add(world, sensor).product
    for _ in range(60):
        world.update()
    assert product.frames == 60
    assert product.missed == 40
    assert sensor.ticks[0].poses == 3  # ceil(240 / 100)


def test_stop_keeps_what_was_there_at_play_and_restarts_it():
    world, before, during = World(), NotingLidar(10), NotingLidar(10)
    kept = add(world, before, "before").product
    written = []
    kept.writers.append(written.append)
    world.rendering.begin_play()
    add(world, during, "during")
    kept.writers.append(print)
    for _ in range(7):
        world.update()
    world.clock.reset()
    world.rendering.end_play()
    assert list(world.rendering.products) == ["/Render/before"]
    assert kept.writers == [written.append]
    assert (kept.frames, kept.frame, before.resets) == (0, None, 1)
    for _ in range(6):
        world.update()
    assert [tick.index for tick in before.ticks] == [1, 1]
    assert len(world.rendering.history) == 2


def test_a_change_of_the_physics_rate_keeps_the_grid_and_starts_with_a_whole_turn():
    world, sensor = World(physics=60, per_update=1), NotingLidar(10)
    add(world, sensor)
    world.update()
    world.clock.set_rate(Fraction(120))  # the step done is 1 / 120 s then; the first whole turn is [0.1, 0.2)
    for _ in range(22):
        world.update()
    assert sensor.ticks == []
    world.update()  # step 24 at 120 Hz
    assert [tick.end for tick in sensor.ticks] == [Fraction(1, 5)]


def test_without_multi_tick_sensors_follow_the_run_loop():
    world = World()
    world.rendering.multi_tick = False
    lidar, camera, auto = NotingLidar(20), NotingSensor(10), NotingSensor()
    for name, sensor in (("lidar", lidar), ("camera", camera), ("auto", auto)):
        add(world, sensor, name)
    for _ in range(6):
        world.update(steps=0)
    assert [tick.index for tick in lidar.ticks] == [1, 2]
    assert [tick.time for tick in camera.ticks] == [Fraction(n, 60) for n in range(1, 7)]
    assert [(tick.start, tick.end) for tick in auto.ticks] == [(Fraction(n, 60), Fraction(n + 1, 60)) for n in range(6)]


def test_without_multi_tick_a_product_exists_from_the_loop_time_at_the_start_of_its_update():
    world, sensor = World(), NotingLidar(60)
    world.rendering.multi_tick = False
    world.update()
    world.update(inside=lambda: add(world, sensor))
    assert [(tick.start, tick.end) for tick in sensor.ticks] == [(Fraction(1, 60), Fraction(2, 60))]
