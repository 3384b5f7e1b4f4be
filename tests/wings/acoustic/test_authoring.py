"""Acoustic and AcousticSensor: created, wrapped, refused; inspected and explained."""

import json

import numpy as np
import pytest

from graph.cli.main import main
from graph.sim import App
from sensors import SUPPORTED_ACOUSTIC_CONFIGS, Acoustic, AcousticSensor, parse_generic_model_output_data

PREFIX = "omni:sensor:WpmAcoustic:"
TARGETS = {f"/World/Target{n}": {"type": "Cube", "translate": list(at)} for n, at in enumerate(((3, 0, 0), (5, 2, 0)))}
ARRAY = {
    f"{PREFIX}centerFrequency": 40000.0,
    f"{PREFIX}sensorMount:m001:position": (0.0, -0.05, 0.0),
    f"{PREFIX}sensorMount:m002:position": (0.0, 0.05, 0.0),
    f"{PREFIX}rxGroup:g001:receiverIndices": [0, 1],
    f"{PREFIX}rxGroup:g002:receiverIndices": [1],
}


@pytest.fixture
def app():
    with App(None, physics_hz=60, loop_hz=60) as app:
        app.add_prims(TARGETS)
        yield app


def test_names_of_attributes_bring_their_mounts_and_groups(app):
    acoustic = Acoustic("/World/Car/Sonar", aux_output_level="BASIC", tick_rate=30.0, attributes=ARRAY, app=app)
    config = acoustic.config
    assert [mount.position for mount in config.mounts] == [(0.0, -0.05, 0.0), (0.0, 0.05, 0.0)]
    assert [(way.sender, way.receiver) for way in config.ways] == [(0, 0), (0, 1)]
    assert (config.center_frequency, acoustic.tick_rate, acoustic.aux_output_level) == (40000.0, 30, "BASIC")
    applied = acoustic.prim.GetAppliedSchemas()
    assert {"OmniSensorWpmAcousticSensorMountAPI:m002", "OmniSensorWpmAcousticRxGroupAPI:g002"} <= set(applied)


def test_a_firing_sequence_beyond_the_first_needs_its_schema(app):
    event = {f"{PREFIX}firingSeq:seq002:{part}": [0] for part in ("eventTimeNs", "txSensorId", "rxGroupId")}
    event[f"{PREFIX}firingSeq:seq002:channel"] = [5]
    assert Acoustic("/World/Bare", attributes=event, app=app).config.ways[0].channel == 0
    schemas = ["OmniSensorWpmAcousticFiringSeqAPI:seq002"]
    assert Acoustic("/World/Full", schemas=schemas, attributes=event, app=app).config.ways[0].channel == 5


def test_the_sensor_measures_at_its_rate(app):
    sensor = AcousticSensor(
        Acoustic("/World/Sonar", aux_output_level="BASIC", tick_rate=30.0, attributes=ARRAY, app=app),
        annotators=["generic-model-output"],
    )
    assert sensor.authoring_object is sensor.acoustic
    assert sensor.get_data("generic-model-output")[0] is None
    app.play()
    app.update(steps=4)
    gmo = parse_generic_model_output_data(sensor.get_data("generic-model-output")[0])
    assert (gmo.modality.name, gmo.frameId, gmo.timestampNs) == ("ACOUSTIC", 1, 66_666_667)
    assert gmo.numElements == gmo.numSgws * gmo.numSamplesPerSgw == 640
    assert gmo.frameStart.timestampNs < gmo.frameEnd.timestampNs
    assert np.isfinite(gmo.scalar).all()
    assert gmo.scalar.max() > 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"aux_output_level": "FULL"}, "aux_output_level 'FULL' is not one of NONE, BASIC"),
        ({"config": "Any"}, "there is no acoustic sensor configuration 'Any'"),
        ({"attributes": {f"{PREFIX}sensorMount:m001:position": "far"}}, "its type is float3"),
    ],
)
def test_what_cannot_be_is_a_value_error_in_a_line(app, options, message):
    assert SUPPORTED_ACOUSTIC_CONFIGS == {}
    with pytest.raises(ValueError, match=message):
        Acoustic.create("/World/Sonar", app=app, **options)


def test_a_sensor_in_a_file_is_inspected_and_explained(tmp_path, capsys):
    file = tmp_path / "sonar.json"
    prims = {
        **TARGETS,
        "/World/Sonar": {
            "type": "OmniAcoustic",
            "aux_output_level": "BASIC",
            "attributes": {"omni:sensor:tickRate": 20, f"{PREFIX}raysPerDeg": 1.0},
        },
    }
    file.write_text(json.dumps({"tickgraph": 1, "scene": {"prims": prims}}))
    assert main(["inspect", str(file), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["header"]["modality"] == "ACOUSTIC"
    assert (told["header"]["numSgws"], told["header"]["numSamplesPerSgw"]) == (1, 320)
    assert told["channels"]["scalar"]["max"] > 0
    assert [told["channels"][name]["unit"] for name in "xyz"] == ["", "", ""]
    assert main(["explain", str(file)]) == 0
    text = capsys.readouterr().out
    assert "tick 20 Hz" in text
    assert "1 of 320 samples, mounts: 1, 8,100 rays each, to 5.62 m" in text
