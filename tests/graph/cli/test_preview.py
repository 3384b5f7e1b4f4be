"""`graph run --preview`: pictures of what the sensors see."""

from fractions import Fraction

import numpy as np
import pytest
from PIL import Image

from graph.cli.main import main
from graph.sim import App
from sensors.writers.preview import Previews

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
