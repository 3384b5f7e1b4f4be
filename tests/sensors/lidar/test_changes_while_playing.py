"""A lidar when the physics rate, or an attribute of its own, changes while the App plays."""

import pytest

from graph.sim import App
from sensors import Lidar
from sensors.errors import SensorValueError
from sensors.products import render_product


def lidar(app):
    """The render product of a 10 Hz lidar over a falling ball."""
    app.add_prims({"/World/Ball": {"type": "Sphere", "radius": 0.2, "translate": [0, 0, 2], "rigid_body": True}})
    return render_product(app, Lidar.create("/World/Lidar", config="Example_Rotary", app=app).path, (1, 1))


def test_sensors_start_again_where_a_new_rate_moves_the_time():
    """60 steps at 60 Hz are 1 s, and 0.25 s at 240 Hz. The first whole turn from there is [0.3, 0.4): step 96, which is
    36 steps or 9 updates later; from there on a turn takes 6 updates."""
    with App(physics_hz=60, loop_hz=60) as app:
        product = lidar(app)
        app.play()
        app.update(60)
        assert (product.frames, product.last_frame_ns) == (10, 900_000_000)
        app.simulation.setup_simulation(dt=1 / 240)
        (told,) = [warning for warning in app.warnings if warning.code == "simulation-time-moved"]
        assert "from 60 to 240 Hz" in told.message
        assert "from 1 to 0.25 s" in told.message
        app.update(8)
        assert product.frames == 10
        app.update()
        assert (product.frames, product.last_frame_ns) == (11, 300_000_000)
        app.update(12)
        assert (product.frames, product.last_frame_ns, product.missed) == (13, 500_000_000, 0)


def test_a_lower_rate_misses_no_tick():
    """240 steps at 240 Hz are 1 s, and 4 s at 60 Hz: turn [4.0, 4.1) comes 6 steps, 6 updates, later."""
    with App(physics_hz=240, loop_hz=60) as app:
        product = lidar(app)
        app.play()
        app.update(60)
        app.simulation.setup_simulation(dt=1 / 60)
        app.update(6)
        assert (product.frames, product.last_frame_ns, product.missed) == (11, 4_000_000_000, 0)


def test_a_tick_rate_written_while_playing_counts_from_the_next_update():
    """10 Hz for 1 s are 10 frames; the 20 Hz scan from then on ends every 3 updates."""
    with App(physics_hz=60, loop_hz=60) as app:
        product = lidar(app)
        app.play()
        app.update(60)
        prim = app.stage.GetPrimAtPath("/World/Lidar")
        prim.GetAttribute("omni:sensor:tickRate").Set(20.0)
        prim.GetAttribute("omni:sensor:Core:scanRateBaseHz").Set(20)
        app.update(30)
        assert product.sensor.rate == 20
        assert product.frames == 10 + 10
        app.stop()
        app.play()
        assert product.sensor.rate == 10  # stop has put the stage back


@pytest.mark.parametrize("rate", ["abc", True, -1, float("nan")])
def test_a_tick_rate_that_is_not_a_rate_is_refused_in_a_line(rate):
    with App() as app, pytest.raises(SensorValueError, match=r"^tick_rate .*: give a rate in Hz, or 0"):
        Lidar.create("/World/Lidar", config="Example_Rotary", tick_rate=rate, app=app)
