"""What an acoustic sensor hears of walls whose echoes are known on paper.

A hard infinite wall mirrors its source: the echo is that of the image source, A / L after L / c, where L is the whole
way. So do plates as long as the first Fresnel zones lie on them. Sound travels at 343 m/s; the default wave is
51.2 kHz, 6.7 mm long, and a pulse swells and fades as sin^2 within 2.5 ms, so it is strongest 1.25 ms after it begins.
"""

import math

import numpy as np
import pytest
from pxr import Gf, UsdGeom

import sensors.replicator as rep
from graph.base.errors import UserError
from graph.sim import App
from graph.sim.scene.stage import open_stage
from sensors import parse_generic_model_output_data, render_product
from sensors.prim import write_aux_level
from wings.acoustic.config import SAMPLES
from wings.acoustic.waves import Membrane, absorption, envelope

PATH = "/World/Sonar"
C, SAMPLE, PULSE, FREQUENCY = 343.0, 1.024e-4, 2.5e-3, 51200.0
PREFIX = "omni:sensor:WpmAcoustic:"
EVENT = "eventTimeNs", "txSensorId", "rxGroupId", "channel"


def loss(length):
    """Amplitude left by spreading and absorption."""
    return math.exp(-absorption(FREQUENCY) * length) / length


@pytest.fixture
def sonar():
    """A function that puts a sensor at the origin, with these attributes and schema instances, before these walls."""
    opened = []

    def make(walls=(), attributes=None, mounts=(), groups=(), firing=None, rate=25.0, **options):
        stage = open_stage(None)
        for number, (center, size) in enumerate(walls):
            wall = UsdGeom.Cube.Define(stage, f"/World/Wall{number}")
            wall.GetSizeAttr().Set(1.0)
            wall.AddTranslateOp().Set(Gf.Vec3d(*center))
            wall.AddScaleOp().Set(Gf.Vec3f(*size))
        prim = stage.DefinePrim(PATH, "OmniAcoustic")
        prim.GetAttribute("omni:sensor:tickRate").Set(rate)
        for number, position in enumerate(mounts, 1):
            prim.AddAppliedSchema(f"OmniSensorWpmAcousticSensorMountAPI:m{number:03}")
            prim.GetAttribute(f"{PREFIX}sensorMount:m{number:03}:position").Set(Gf.Vec3f(*position))
        for number, indices in enumerate(groups, 1):
            prim.AddAppliedSchema(f"OmniSensorWpmAcousticRxGroupAPI:g{number:03}")
            prim.GetAttribute(f"{PREFIX}rxGroup:g{number:03}:receiverIndices").Set(indices)
        for name, values in (firing or {}).items():
            prim.GetAttribute(f"{PREFIX}firingSeq:seq001:{name}").Set(values)
        for name, value in (attributes or {}).items():
            prim.GetAttribute(PREFIX + name).Set(value)
        write_aux_level(prim, "BASIC")
        app = App(stage, physics_hz=100, loop_hz=50, **options)
        opened.append(app)
        return app

    yield make
    for app in opened:
        app.close()


def heard(app, updates=2):
    """The newest GenericModelOutput."""
    product = render_product(app, PATH)
    annotator = rep.get_annotator("GenericModelOutput", app=app).attach(product)
    app.play()
    app.update(updates)
    return parse_generic_model_output_data(annotator.get_data())


WALL_3_M = ((3.5, 0, 0), (1, 8, 8))


def test_a_wall_echoes_as_its_image_source_after_its_time_of_flight(sonar):
    """2 x 3 m: 17.493 ms, sample 170.8; the pulse is strongest 1.25 ms later, at sample 183.0."""
    gmo = heard(sonar([WALL_3_M], {"raysPerDeg": 8.0}))
    amplitude = gmo.scalar
    onset, peak = 6 / C / SAMPLE, (6 / C + PULSE / 2) / SAMPLE
    assert onset == pytest.approx(170.83, abs=0.01)
    assert amplitude[: int(onset)].max() < 0.002 * loss(6)
    strongest = int(np.argmax(amplitude[:200]))
    assert strongest == pytest.approx(peak, abs=1)
    assert amplitude[strongest] == pytest.approx(loss(6), rel=0.01)
    # sin^2 of a quarter of the pulse: half the amplitude.
    assert amplitude[round((6 / C + PULSE / 4) / SAMPLE)] == pytest.approx(loss(6) / 2, rel=0.1)


@pytest.mark.parametrize("place", [1.0, 2.0, 2.7, 3.5, 4.6])
def test_the_default_fan_is_right_to_2_5_percent(sonar, place):
    """Where a tube's phase turns whole times over its width, what is left out of it adds up."""
    assert heard(sonar([((place + 0.5, 0, 0), (1, 20, 20))])).scalar.max() == pytest.approx(loss(2 * place), rel=0.025)


def test_mounts_apart_hear_the_mirrored_way_and_each_other(sonar):
    """1 m apart, the wall 2 m ahead: sqrt(4^2 + 1^2) = 4.123 m, 12.021 ms; straight 1 m, 2.915 ms."""
    app = sonar([((2.5, 0, 0), (1, 8, 8))], mounts=[(0, -0.5, 0), (0, 0.5, 0)], groups=[[1]])
    amplitude = heard(app).scalar
    way = math.hypot(4, 1)
    assert way / C == pytest.approx(12.021e-3, abs=1e-6)
    for length in (1.0, way):
        peak = (length / C + PULSE / 2) / SAMPLE
        around = amplitude[int(peak) - 12 : int(peak) + 13]
        assert int(peak) - 12 + int(np.argmax(around)) == pytest.approx(peak, abs=1)
        assert around.max() == pytest.approx(loss(length), rel=0.025)


def test_a_plate_between_mounts_keeps_the_direct_wave_away(sonar):
    app = sonar([((0, 0, 0), (0.02, 0.02, 0.02))], mounts=[(0, -0.5, 0), (0, 0.5, 0)], groups=[[1]])
    assert heard(app).scalar.max() == 0


def test_a_wall_in_front_hides_the_one_behind_it_and_excluded_prims_are_not_met(sonar):
    from sensors import exclude

    walls = [((2.05, 0, 0), (0.1, 8, 8)), WALL_3_M]
    near, far = (round((2 * d / C + PULSE / 2) / SAMPLE) for d in (2, 3))
    amplitude = heard(sonar(walls)).scalar
    assert amplitude[near] == pytest.approx(loss(4), rel=0.025)
    assert amplitude[far] < 0.02 * loss(6)
    app = sonar(walls)
    exclude(PATH, "/World/Wall0", app=app)
    amplitude = heard(app).scalar
    assert amplitude[near] < 0.002
    assert amplitude[far] == pytest.approx(loss(6), rel=0.025)


def test_a_small_plate_scatters_by_its_area(sonar):
    """Far away, a plate of area S facing the sensor scatters A S / (lambda R^2): 2 cm x 2 cm at 2 m.

    Its Fresnel number a^2 / (lambda R) is 0.03, so it is far. At 200 rays a degree 115 x 115 of them meet it: its area
    is met to 2 x 1 / 115.
    """
    app = sonar([((2.005, 0, 0), (0.01, 0.02, 0.02))], {"raysPerDeg": 200.0, "azSpanDeg": 2.0, "elSpanDeg": 2.0})
    area, wavelength = 4e-4, C / FREQUENCY
    expected = area / (wavelength * 2**2) * math.exp(-absorption(FREQUENCY) * 4)
    assert heard(app).scalar.max() == pytest.approx(expected, rel=0.03)


def test_the_power_of_the_pulse_is_its_squared_amplitude(sonar):
    once, fourfold = (heard(sonar([WALL_3_M], {"pulsePower": power})).scalar.max() for power in (1.0, 4.0))
    assert fourfold == pytest.approx(2 * once, rel=1e-6)


def test_a_frame_is_the_firing_sequence_way_by_way(sonar):
    """Two events: mount 2 for group 0 (mounts 0, 1) on channel 7, and 30 ms later mount 0 for group 1 on channel 8."""
    app = sonar(
        mounts=[(0, -0.05, 0), (0, 0, 0), (0, 0.05, 0)],
        groups=[[0, 1], [2]],
        firing={"eventTimeNs": [30_000_000, 0], "txSensorId": [0, 2], "rxGroupId": [1, 0], "channel": [8, 7]},
    )
    gmo = heard(app)
    assert gmo.modality.name == "ACOUSTIC"
    assert gmo.elementsCoordsType.name == "NOT_APPLICABLE"
    assert (gmo.numSgws, gmo.numSamplesPerSgw, gmo.numElements) == (3, SAMPLES, 3 * SAMPLES)
    first = slice(None, None, SAMPLES)
    assert gmo.x[first].tolist() == [2, 2, 0]
    assert gmo.y[first].tolist() == [0, 1, 2]
    assert gmo.z[first].tolist() == [7, 7, 8]
    assert gmo.timeOffsetNs[first].tolist() == [0, 0, 30_000_000]
    assert (gmo.x.reshape(3, -1) == gmo.x[first][:, None]).all()
    # The sequence lasts to the end of its last record: 30 ms + 320 x 0.1024 ms.
    assert gmo.frameStart.timestampNs == 40_000_000
    assert gmo.frameEnd.timestampNs == 40_000_000 + 30_000_000 + 32_768_000
    assert gmo.timestampNs == gmo.frameStart.timestampNs
    assert (gmo.flags != 0).all()


def test_without_a_level_the_number_of_ways_is_not_told(sonar):
    app = sonar([WALL_3_M])
    write_aux_level(app.stage.GetPrimAtPath(PATH), "NONE")
    gmo = heard(app)
    assert (gmo.numSgws, gmo.numSamplesPerSgw, gmo.numElements) == (0, 0, SAMPLES)


def test_noise_is_within_its_bounds_and_the_same_in_every_run(sonar):
    """Uniform from 0.1 to 0.3: mean 0.2, of 320 samples to within 5 x 0.2 / sqrt(12 x 320) = 0.016."""
    noise = {"noiseMin": 0.1, "noiseMax": 0.3}
    first, second = (heard(sonar([], noise)).scalar for _ in range(2))
    assert first.tobytes() == second.tobytes()
    assert first.min() >= 0.1
    assert first.max() <= 0.3
    assert first.mean() == pytest.approx(0.2, abs=0.016)
    assert heard(sonar([], noise, seed=7)).scalar.tobytes() != first.tobytes()


def test_nobody_asks_nothing_is_cast(sonar, monkeypatch):
    from sensors.raycast.world import CastWorld

    app = sonar([WALL_3_M])
    product = render_product(app, PATH)
    monkeypatch.setattr(CastWorld, "cast", lambda *rest, **more: pytest.fail("cast"))
    app.play()
    app.update(4)
    assert product.frames == 2


@pytest.mark.parametrize("place", [(0, 0, 0), (0, 2, 0), (700_000.3, -400_000.7, 0)])
def test_echoes_are_those_of_the_sensors_place_and_axes(sonar, place):
    """Turned to the left and moved, with the wall 3 m to the world's left of it."""
    x, y, _ = place
    app = sonar([((x, y + 3.5, 0), (8, 1, 8))])
    prim = UsdGeom.Xformable(app.stage.GetPrimAtPath(PATH))
    prim.AddTranslateOp().Set(Gf.Vec3d(*place))
    prim.AddRotateZOp().Set(90.0)
    assert heard(app).scalar[:200].max() == pytest.approx(loss(6), rel=0.02)


def test_a_membrane_hears_off_its_axis_as_a_piston_does():
    """The first zero of J1 is 3.8317: with k a = 7.66 it lies at 30 deg. At half of it J1 is 0.580724."""
    piston = Membrane(2.0, 2 * 3.831706)
    cosines = np.array([1.0, math.cos(math.asin(0.25)), math.cos(math.radians(30))])
    assert piston.gain(cosines) == pytest.approx([1, 2 * 0.580724 / 1.915853, 0], abs=2e-5)
    assert (Membrane(0.0, 900.0).gain(cosines) == 1).all()


def test_of_a_pulse_longer_than_the_record_its_begin_is_heard():
    """sin^2(pi t / T) of T = 1e6 s after 1 ms: 1e-17. It takes no more time than a short one."""
    heard = envelope(np.array([0.0]), np.array([1.0 + 0j]), 320, 1e-4, 1e6)
    assert heard[10] == pytest.approx(math.sin(math.pi * 1e-9) ** 2, rel=0.02)


@pytest.mark.parametrize(
    ("frequency", "humidity", "decibels"), [(1000.0, 0.7, 5.0e-3), (1000.0, 0.5, 4.66e-3), (10_000.0, 0.5, 0.159)]
)
def test_absorption_is_that_of_the_standards_tables(frequency, humidity, decibels):
    """ISO 9613-1, 20 degC: dB/m."""
    assert absorption(frequency, 20.0, humidity) * 20 / math.log(10) == pytest.approx(decibels, rel=0.01)


@pytest.mark.parametrize(
    ("attributes", "wrong"),
    [
        ({"pulseDuration": 0.0}, "pulseDuration is 0.0; give a number above 0"),
        ({"azSpanDeg": 200.0}, "give at most 180"),
        ({"noiseMin": -1.0}, "give a number from 0 on"),
        ({"noiseMin": 0.5, "noiseMax": 0.25}, "noiseMax is 0.25; give at least noiseMin, 0.5"),
        ({"raysPerDeg": 100.0}, "81,000,000 rays; the limit is 1,000,000 rays; raise it with --limit acoustic.rays=N"),
        ({"rxGroup:g001:receiverIndices": [1]}, "mounts are numbered from 0 to 0"),
        ({"firingSeq:seq001:channel": [1]}, "have 0, 0, 0, 1 elements"),
        ({"rxGroup:g001:receiverIndices": []}, "no mount listens"),
        (
            {f"firingSeq:seq001:{name}": [2**31 if name == "eventTimeNs" else 0] for name in EVENT},
            "2,147,483,648 ns does not fit, it has 31 bits: 2.147 s",
        ),
    ],
)
def test_what_no_sensor_has_is_told_in_a_line(sonar, attributes, wrong):
    with pytest.raises(UserError, match=wrong):
        render_product(sonar([], attributes), PATH)


def test_attributes_without_effect_are_told_when_they_are_authored(sonar):
    app = sonar([], {"closeRange": 1.0, "enableInterference": True})
    render_product(app, PATH)
    assert [(one.code, one.where) for one in app.warnings] == [("acoustic-attribute-ignored", PATH)]
    assert "closeRange, enableInterference" in next(iter(app.warnings)).message
