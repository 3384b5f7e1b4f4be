"""Only requested channels are measured: all others are neither computed nor allocated."""

from collections import Counter

import numpy as np
import pytest

import sensors.replicator as rep
from sensors import LidarSensor
from sensors.channels import AUXILIARY, CHANNELS, POINT_CHANNELS, AuxLevel, Consumer, Demand
from sensors.lidar import returns, scans
from sensors.lidar.authoring import Lidar
from sensors.lidar.prim import write_config
from sensors.prim import write_aux_level
from tests.support.lidar_worlds import add_box, define_lidar, rotary, weightless

SETTINGS = {"/rtx-transient/stableIds/enabled": True, "/app/sensors/nv/lidar/publishNormals": True}
TABLES = {"matId": "surface_materials", "objId": "surface_ids", "classId": "surface_classes"}


@pytest.fixture
def made(monkeypatch):
    """How often each channel was worked out: a counter on the function that makes it."""
    counts = Counter()

    def counting(name, make):
        def count(*arguments):
            counts[name] += 1
            return make(*arguments)

        return count

    for name, make in dict(returns.MAKERS).items():
        monkeypatch.setitem(returns.MAKERS, name, counting(name, make))
    for name, function in TABLES.items():
        monkeypatch.setattr(scans, function, counting(name, getattr(scans, function)))
    return counts


@pytest.fixture
def app():
    with weightless(settings=SETTINGS) as app:
        add_box(app, "/World/Room", 10.0, (0, 0, 0))
        define_lidar(app)
        yield app


@pytest.mark.parametrize("name", [channel.name for channel in POINT_CHANNELS])
def test_a_requested_channel_is_computed_once_a_frame_and_never_otherwise(app, made, name):
    product = rep.create_render_product("/World/Lidar", app=app)
    owner = Consumer("test")
    app.play()
    app.update(steps=6)
    assert (dict(made), product.frame.arrays) == ({}, {})

    product.sensor.require(owner, {name})
    app.update(steps=12)
    assert set(product.frame.arrays) == {name}
    channel = CHANNELS[name]
    assert product.frame.arrays[name].shape == ((360, channel.width) if channel.width > 1 else (360,))
    # Beam channels are one look-up in the pattern and have no maker; flags and echo ids need no measurement.
    expected = {name: 2} if name in returns.MAKERS or name in TABLES else {}
    assert {key: count for key, count in made.items() if key in expected or key in AUXILIARY} == expected

    product.sensor.release(owner)
    made.clear()
    app.update(steps=6)
    assert (dict(made), product.frame.arrays) == ({}, {})


def test_a_sensor_without_aux_allocates_no_more_than_its_output_holds(app, made):
    lidar = Lidar("/World/Lidar", aux_output_level="NONE", app=app)
    sensor = LidarSensor(lidar, annotators=["generic-model-output"])
    app.play()
    app.update(steps=6)

    arrays = sensor.render_product.frame.arrays
    assert set(arrays) == {"azimuth", "elevation", "distance", "scalar", "timeOffsetNs", "flags"}
    assert sum(array.nbytes for array in arrays.values()) == 360 * (4 * 5 + 1)
    assert not AUXILIARY & set(made)


def test_an_auxiliary_level_raised_later_is_delivered_from_the_next_play_on(app):
    lidar = Lidar("/World/Lidar", aux_output_level="NONE", app=app)
    sensor = LidarSensor(lidar, annotators=["generic-model-output"])
    write_aux_level(lidar.prim, "BASIC")
    app.play()
    app.update(steps=6)

    assert "emitterId" in sensor.render_product.frame.arrays
    assert "matId" not in sensor.render_product.frame.arrays
    assert app.warnings.codes() == []


def test_one_lidars_level_leaves_another_ones_alone(app):
    """In the original the render product that was attached last decides for all."""
    frames = {}
    for name, level in (("A", "FULL"), ("B", "NONE"), ("C", "BASIC")):
        prim = app.stage.DefinePrim(f"/World/{name}", "OmniLidar")
        write_config(prim, rotary())
        sensor = LidarSensor(
            Lidar(f"/World/{name}", aux_output_level=level, app=app), annotators="generic-model-output"
        )
        frames[name] = sensor.render_product
    app.play()
    app.update(steps=6)
    levels = {
        name: max(CHANNELS[channel].level for channel in product.frame.arrays) for name, product in frames.items()
    }

    assert levels == {"A": AuxLevel.FULL, "B": AuxLevel.NONE, "C": AuxLevel.BASIC}


def test_optional_channels_are_asked_for_as_far_as_the_level_goes_and_without_a_word():
    demand = Demand()
    first, second = Consumer("annotator"), Consumer("annotator")
    demand.require(first, {"xyz"}, optional=AUXILIARY)
    demand.require(second, {"xyz", "matId"})

    assert demand.channels(AuxLevel.NONE) == {"xyz"}
    assert demand.channels(AuxLevel.BASIC) == {
        *("xyz", "emitterId", "channelId", "tickId", "echoId", "tickStates", "rv_ms")
    }
    assert demand.above(AuxLevel.BASIC) == demand.above(AuxLevel.BASIC, second) == {"matId": AuxLevel.EXTRA}
    assert demand.above(AuxLevel.BASIC, first) == {}
    assert demand.consumers(AuxLevel.NONE) == {"xyz": ["annotator", "annotator"], "matId": ["annotator"]}
    demand.release(second)
    assert demand.above(AuxLevel.NONE) == {}
    assert demand.consumers(AuxLevel.EXTRA)["matId"] == ["annotator"]


def test_the_empty_arrays_have_the_types_of_the_full_ones(app):
    product = rep.create_render_product("/World/Lidar", app=app)
    product.sensor.require("all", {channel.name for channel in POINT_CHANNELS})
    app.play()
    app.update(steps=6)

    for name, array in product.frame.arrays.items():
        assert (array.dtype, array.ndim) == (CHANNELS[name].empty().dtype, CHANNELS[name].empty().ndim)
        assert np.isfinite(array).all()
