"""Frames of a radar, as graphs, annotators and commands get them."""

import json
import math

import numpy as np
import pytest

from graph.cli.main import main
from sensors import parse_generic_model_output_data
from sensors.annotators.annotator import Annotator
from sensors.annotators.registry import find_annotator
from tests.support.radar_scenes import RADAR, SCAN, WPM, plate, radar_world, trihedral

FACTOR = 10 * math.log10(150)
"""What the default rcsTuningCoefficients add [dB]."""


def test_a_frame_holds_the_target_in_every_field():
    with radar_world(trihedral(0.1, 20.0), attributes={f"{WPM}cfarMode": "4D"}) as (app, product):
        annotator = Annotator(find_annotator("GenericModelOutput"), app=app)
        annotator.attach(product)
        app.update(steps=6)
        gmo = parse_generic_model_output_data(annotator.get_data())
    assert (gmo.modality.name, gmo.auxType.name, gmo.elementsCoordsType.name) == ("RADAR", "BASIC", "SPHERICAL")
    assert (gmo.timestampNs, gmo.frameId, gmo.scanIdx, gmo.cycleCnt, gmo.sensorID) == (100_000_000, 5, 0, 5, 0)
    assert (gmo.maxRangeM, gmo.minVelMps, gmo.maxVelMps) == (50.0, -55.0, 55.0)
    assert gmo.maxAzRad == pytest.approx(math.radians(20), abs=0.02)
    assert gmo.minElRad == -gmo.maxElRad
    strongest = int(np.argmax(gmo.scalar))
    assert gmo.scalar[strongest] == pytest.approx(14.40 + FACTOR, abs=0.2)
    assert gmo.z[strongest] == pytest.approx(20.0, abs=2e-3)
    assert (gmo.x[strongest], gmo.y[strongest]) == (pytest.approx(0, abs=0.01), 0.0)
    assert np.all(np.diff(gmo.z) >= 0)
    assert gmo.rv_ms.tolist() == [0.0] * gmo.numElements
    assert set(gmo.flags.tolist()) == {64}


def test_an_empty_world_gives_empty_frames():
    with radar_world() as (app, product):
        app.update(steps=3)
        assert (product.frames, product.frame.count) == (3, 0)
        assert product.frame.xyz.shape == (0, 3)


def test_scans_take_turns_in_the_order_of_their_names():
    second = {f"{WPM}scan:s002:{name}": value for name, value in (("maxRangeM", 300.0), ("maxAzAngDeg", 9.0))}
    schemas = ["OmniSensorGenericRadarWpmDmatScanCfgAPI:s002"]
    with radar_world(plate(0.5, 20.0), second, schemas=schemas) as (app, product):
        seen = []
        for _ in range(4):
            app.update()
            facts = product.frame.facts
            seen.append((facts["scanIdx"], facts["cycleCnt"], round(facts["maxRangeM"]), facts["maxVelMps"]))
    assert seen == [(0, 0, 50, 50.0), (1, 0, 300, 50.0), (0, 1, 50, 55.0), (1, 1, 300, 55.0)]


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ({f"{SCAN}maxAzAngDeg": 100.0}, "scan s001: maxAzAngDeg = 100 is beyond 90 deg; it is half the field of view"),
        ({f"{SCAN}rangeResM": 0.0}, "scan s001: rangeResM must be above 0"),
        ({f"{SCAN}maxVelMpsSequence": []}, "scan s001: maxVelMpsSequence needs velocities above 0"),
        ({f"{SCAN}raysPerDeg": 1000.0}, "rays; the limit is 10,000,000 rays; raise it with --limit radar.rays=N"),
        ({f"{SCAN}velResMps": 1e-6}, "range and velocity cells; the limit is 20,000,000 cells"),
        ({f"{SCAN}boreAzResDeg": 1e-30}, "azimuth and 1 elevation cells; at most 100,000 of each"),
        ({f"{SCAN}timeOffsetUsec": 1e7}, "timeOffsetUsec = 1e+07 does not fit; in ns it has 31 bits, 2.1 s"),
        ({f"{WPM}traceTreeDepth": 256}, "traceTreeDepth = 256; at most 255 reflections are followed"),
        ({f"{WPM}customFrameOfReferenceTrafo": [1.0, 2.0]}, "customFrameOfReferenceTrafo is six finite numbers"),
        ({f"{WPM}waveLengthMm": 0.0}, "waveLengthMm = 0; give 0.01 to 1000 mm"),
        (
            {"omni:sensor:tickRate": 20.0, "omni:sensor:frameRate": [10, 1]},
            "omni:sensor:tickRate is 20 Hz, omni:sensor:frameRate 10 Hz: two words for one rate; give one",
        ),
        ({"omni:sensor:frameRate": [10, 0]}, "give n, d above 0 for n / d Hz"),
    ],
)
def test_what_no_radar_can_have_is_reported_in_a_line(tmp_path, capsys, attributes, message):
    file = tmp_path / "radar.json"
    file.write_text(
        json.dumps({"tickgraph": 1, "scene": {"prims": {RADAR: {"type": "OmniRadar", "attributes": attributes}}}})
    )
    assert main(["check", str(file)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line


@pytest.mark.parametrize("rate", [{"omni:sensor:tickRate": 12.5}, {"omni:sensor:frameRate": [25, 2]}])
def test_both_words_for_the_rate_give_the_same_ticks(tmp_path, rate):
    prims = {RADAR: {"type": "OmniRadar", "attributes": {**rate, f"{SCAN}raysPerDeg": 1}}}
    nodes = {
        "tick": "OnPlaybackTick",
        "product": {"type": "IsaacCreateRenderProduct", "inputs": {"cameraPrim": RADAR}},
    }
    graphs = {"/World/G": {"nodes": nodes, "connections": ["tick.tick -> product.execIn"]}}
    file = tmp_path / "radar.json"
    file.write_text(json.dumps({"tickgraph": 1, "scene": {"prims": prims}, "graphs": graphs, "duration": 0.4}))
    assert main(["run", str(file), "--out", str(tmp_path / "out")]) == 0
    told = json.loads((tmp_path / "out" / "report.json").read_text())["sensors"][RADAR]
    assert (told["tick_rate"], told["frames"], told["first_frame_ns"]) == (12.5, 5, 83_333_333)
