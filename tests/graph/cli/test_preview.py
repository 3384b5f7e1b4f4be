"""`graph run --preview`: pictures of what the sensors see."""

import json
from fractions import Fraction

import numpy as np
import pytest
from PIL import Image

from graph.cli.main import main
from graph.sim import App
from sensors.writers.palette import NOTHING, palette
from sensors.writers.preview import Previews
from sensors.writers.scale import BAR_HEIGHT, MARK, RING, ring_step

TEXT = """
tickgraph: 1
scene:
  prims:
    /World/Wall: {type: Cube, size: 2.0, translate: [4, 0, 0], color: [1, 0, 0]}
    /World/Sun: {type: DistantLight, rotate: [0, -90, 0], attributes: {"inputs:intensity": 3000}} # shines along +x
    /World/Camera: {type: Camera, rotate: [90, 0, -90]}
    /World/Lidar: {type: OmniLidar, config: RPLIDAR_S2E}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      camera: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Camera, width: 32, height: 24}}
      lidar: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
    connections:
      - tick.tick -> [camera.execIn, lidar.execIn]
"""


@pytest.fixture
def file(tmp_path):
    """A graph file of a camera and a lidar that nobody reads."""
    file = tmp_path / "two.yaml"
    file.write_text(TEXT)
    return file


def test_each_sensor_gets_a_picture_at_the_rate_asked_for(tmp_path, file, capsys):
    assert main(["run", str(file), "--updates", "60", "--out", str(tmp_path / "out"), "--preview", "2"]) == 0
    folder = tmp_path / "out" / "preview"
    # Camera: the first frames at or after 0, 0.5 and 1 s; frame f shows the time (f + 1) / 60 s. Lidar: scan f of 10 Hz
    # is rendered (and shown) at (f + 1) / 10 s.
    assert sorted(path.name for path in folder.iterdir()) == [
        *(f"World_Camera_{number:06d}.png" for number in (0, 29, 59)),
        *(f"World_Lidar_{number:06d}.png" for number in (0, 4, 9)),
    ]
    red = np.asarray(Image.open(folder / "World_Camera_000000.png"))
    assert red.shape == (24, 32, 3)
    assert red[12, 16, 0] > 100 > red[12, 16, 1]
    assert f"wrote 6 pictures into {folder}" in capsys.readouterr().out


def test_pictures_of_an_earlier_run_are_replaced_and_other_files_stay(tmp_path, file):
    folder = tmp_path / "out" / "preview"
    folder.mkdir(parents=True)
    for name in ("World_Camera_000123.png", "mine.png"):
        (folder / name).write_bytes(b"")
    assert main(["run", str(file), "--updates", "6", "--out", str(tmp_path / "out"), "--preview"]) == 0
    names = {path.name for path in folder.iterdir()}
    assert names == {"World_Camera_000000.png", "World_Lidar_000000.png", "mine.png"}


def test_a_product_that_is_made_again_after_a_stop_is_followed_and_its_frames_count_on(tmp_path, file):
    """Two plays of half a second, a picture a second from the start of each; each makes the products again."""
    with App.from_file(file) as app:
        pictures = Previews(app, tmp_path, Fraction(1))
        for _ in range(2):
            app.play()
            app.update(30)
            app.stop()
        pictures.close()
    # A play has 30 frames of the camera and 5 scans of the lidar.
    assert sorted(path.name for path in tmp_path.glob("*.png")) == [
        "World_Camera_000000.png",
        "World_Camera_000030.png",
        "World_Lidar_000000.png",
        "World_Lidar_000005.png",
    ]


@pytest.mark.parametrize(("options", "said"), [(["--preview"], "--out DIR"), (["--preview", "2"], "--out DIR")])
def test_a_preview_needs_a_folder(file, options, said, capsys):
    assert main(["run", str(file), *options]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("rate", ["0", "-1", "often", "nan"])
def test_a_rate_that_cannot_be_is_refused(tmp_path, file, rate, capsys):
    assert main(["run", str(file), "--out", str(tmp_path / "out"), f"--preview={rate}"]) == 2
    assert "--preview" in capsys.readouterr().err


DEPTH = """
tickgraph: 1
scene:
  prims:
    /World/Wall: {type: Cube, size: 2.0, translate: [4, 0, 0]}
    /World/Camera: {type: Camera, rotate: [90, 0, -90], attributes: {focalLength: 18}}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      camera: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Camera, width: 320, height: 240}}
      out: {type: ROS2CameraHelper, inputs: {type: KIND, topicName: seen, frameId: Camera}}
    connections:
      - tick.tick -> camera.execIn
      - camera.execOut -> out.execIn
      - camera.renderProductPath -> out.renderProductPath
"""


@pytest.mark.parametrize(("kind", "warned"), [("depth", 0), ("rgb", 1)])
def test_a_camera_of_which_only_depth_is_read_shows_depth_and_needs_no_light(tmp_path, kind, warned):
    """The wall's front is 3 m away; its whole image has one depth, between sky of none. No light: rgb is black."""
    file = tmp_path / "camera.yaml"
    file.write_text(DEPTH.replace("KIND", kind))
    out = tmp_path / "out"
    assert main(["run", str(file), "--updates", "4", "--out", str(out), "--preview"]) == 0
    picture = np.asarray(Image.open(out / "preview" / "World_Camera_000000.png"))
    report = json.loads((out / "report.json").read_text())
    dark = [one for one in report["warnings"] if one["code"] == "no-light"]
    assert [one.get("count", 1) for one in dark] == [1] * warned
    if kind == "depth":
        assert picture.shape == (240 + BAR_HEIGHT, 320, 3)
        assert (picture[0, 0] == NOTHING).all()
        assert (picture[120, 160] != NOTHING).any()
        assert len(np.unique(picture[245:250].reshape(-1, 3), axis=0)) > 50  # the bar's colours
    else:
        assert picture.max() == 0


def test_rings_are_a_round_number_of_metres_apart():
    """At 20 pixels a metre 90 pixels are 4.5 m, so rings are 5 m apart; at 1000 pixels 0.09 m, so 0.1 m."""
    assert [ring_step(pixels) for pixels in (20, 45, 90, 1000)] == pytest.approx([5, 2, 1, 0.1])


def test_a_cloud_is_drawn_with_rings_and_the_mark_of_the_sensor(tmp_path, file):
    assert main(["run", str(file), "--updates", "6", "--out", str(tmp_path / "out"), "--preview"]) == 0
    picture = np.asarray(Image.open(tmp_path / "out" / "preview" / "World_Lidar_000000.png")).astype(int)
    colours = {tuple(one) for one in np.unique(picture.reshape(-1, 3), axis=0).tolist()}
    assert {RING, MARK} <= colours
    rows, columns = np.nonzero((picture == MARK).all(axis=2))
    assert np.ptp(columns) > np.ptp(rows)  # it points along +x, to the right


def test_the_palette_is_turbo():
    """It is within 2 % of the table that matplotlib ships."""
    from matplotlib import colormaps

    away = np.abs(palette()[1:] / 255 - colormaps["turbo"](np.linspace(0, 1, 255))[:, :3]).max(axis=1)
    assert away.max() < 0.02
