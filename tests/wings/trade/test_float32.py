"""A trade that varies the device says how far physics in float32 there is from MuJoCo's, over time."""

import csv
import json
from fractions import Fraction

import numpy as np
import pytest

pytest.importorskip("warp", reason="pip install 'tickgraph[gpu]'")
pytest.importorskip("mujoco_warp", reason="pip install 'tickgraph[gpu]'")

from graph.session.meter import PARTS, Cost
from graph.sim import App
from tests.support.devices import DEVICES, WORLD
from tests.support.without_wing import needs_wing
from wings.trade.errors import Horizon, errors_of
from wings.trade.float32 import Float32, float32_log
from wings.trade.outcome import Outcome, Row
from wings.trade.outputs import as_csv, as_dict
from wings.trade.page import page
from wings.trade.states import StateLog
from wings.trade.study import Scene, Study
from wings.trade.trial import Timed, measure
from wings.trade.verdict import remarks

pytestmark = needs_wing("device")

TURNING = WORLD.replace("damping: 5.0", "damping: 5.0\n        drive:angular:physics:targetVelocity: 90.0")
METRICS = ("float32.position_max", "float32.position_final", "float32.orientation_max", "float32.joint_max")
END = Fraction(2, 5)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "turning.yaml"
    path.write_text(TURNING)
    return path


def row_of(file, device):
    """The row of a setting, as a trade makes it, without what it costs."""
    row, run = Row({"device": device}), measure(Scene(file), {"device": device}, END)
    row.take(run, errors_of(run, run, Horizon(float(END))))
    row.timed = [Timed({part: Cost(1.0, 1.0) for part in PARTS}, start=0.5)]
    return row


@pytest.mark.parametrize("device", DEVICES)
def test_the_difference_from_mujoco_over_time_is_in_the_table_and_the_files(device, file):
    """A falling ball and a mast that is driven to a radian: float32 rounds both by some 6e-8 a step of 24 steps."""
    rows = [row_of(file, "cpu"), row_of(file, device)]
    assert [rows[0].errors[name] for name in METRICS] == [0.0] * 4
    errors = rows[1].errors
    assert 0 < errors["float32.position_final"] <= errors["float32.position_max"] < 2e-6
    assert 0 < errors["float32.joint_max"] < 1e-5
    assert 0 < errors["float32.orientation_max"] < 1e-5
    assert errors["body.position_max"] == 0.0  # the run itself is not touched
    assert "device" in rows[0].read & rows[1].read
    assert rows[1].float32.times.tolist() == pytest.approx([step / 60 for step in range(25)])

    settings = tuple(row.setting for row in rows)
    study = Study(Scene(file), {"device": ("cpu", device)}, settings, settings[0], {}, duration=END)
    outcome = Outcome(study, rows, Horizon(float(END)), {}, tuple(rows[0].errors))
    assert set(METRICS) <= {*outcome.shown}
    [said] = [line for line in remarks(outcome) if line.startswith("physics in float32")]
    assert said.startswith(f"physics in float32 against MuJoCo, device={device}: ")
    assert [part.rpartition(" by ")[2] for part in said.split("; ")] == ["0.1 s", "0.2 s", "0.3 s", "0.4 s"]
    first, second = as_dict(outcome)["settings"]
    assert first["float32"]["times"] == []
    assert second["float32"]["times"][-1] == pytest.approx(0.4)
    assert second["float32"]["position"][-1] == errors["float32.position_max"]
    assert np.all(np.diff(second["float32"]["joint"]) >= 0)
    table = [*csv.DictReader(as_csv(outcome).splitlines())]
    assert float(table[1]["float32.joint_max"]) == pytest.approx(errors["float32.joint_max"], rel=1e-5)
    assert json.dumps(second)
    assert "Physics in float32 against MuJoCo" in page(outcome)


def test_it_ends_where_the_file_puts_a_body_elsewhere(file):
    """Six updates alike; then the ball is put elsewhere, which the device's world does not follow."""
    with App.from_file(file) as app:
        app.play()
        log = float32_log(app, "warp-cpu")
        states = StateLog(app, 1.0, log.take)
        app.update(steps=6)
        pose = np.eye(4)
        pose[:3, 3] = 4, 0, 1
        app.physics.set_poses(["/World/Ball"], pose[None])
        app.update(steps=6)
        found = log.compared(states.trajectory())
    assert found.ended == "the state, masses, gains or time step of its bodies are set while it runs"
    assert found.times.tolist() == pytest.approx([step / 60 for step in range(7)])
    assert found.apart["position"].max() < 1e-6


@needs_wing("mjcf")
def test_a_world_that_the_device_does_not_simulate_is_named_and_gives_no_figures(file, tmp_path):
    model = tmp_path / "pgs.xml"
    body = "<worldbody><body><freejoint/><geom size='0.1'/></body></worldbody>"
    model.write_text(f"<mujoco><option solver='PGS'/>{body}</mujoco>")
    with App(mjcf=model) as app:
        app.play()
        found = float32_log(app, "warp-cpu")
    assert isinstance(found, Float32)
    assert found.ended.startswith("mujoco-warp does not simulate this model: ")
    assert found.errors(1.0) == {}
    row = Row({"device": "warp-cpu"}, float32=found)
    study = Study(Scene(file), {"device": ("warp-cpu",)}, (row.setting,), {"device": "cpu"}, {})
    told = [*remarks(Outcome(study, [row], Horizon(1.0), {}, ()))]
    assert told[0].startswith("physics in float32 is not compared, device=warp-cpu: mujoco-warp does not simulate")
