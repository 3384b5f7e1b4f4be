"""Apps in several threads of a process: whatever is loaded at first use is loaded whole, for all of them."""

import subprocess
import sys
import threading

import pytest

from graph.cli.main import main
from tests.support.places import ROOT

FILE = """
tickgraph: 1
scene:
  prims:
    /World/Ground: {type: Plane}
    /World/Lidar: {type: OmniLidar, config: Example_Rotary, translate: [0, 0, 1]}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      cloud: {type: ROS2RtxLidarHelper, inputs: {topicName: points, type: point_cloud}}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath
"""
PROGRAM = """
import sys, threading
sys.setswitchinterval(1e-5)
from graph.sim import App
together, failures, frames = threading.Barrier(2), [], []
def play():
    together.wait()
    try:
        with App.from_file(sys.argv[1]) as app:
            app.play()
            app.update(12)
            frames.append([one.frames for one in app.rendering.history])
    except BaseException as error:
        failures.append(f"{type(error).__name__}: {error}")
threads = [threading.Thread(target=play) for _ in range(2)]
for one in threads: one.start()
for one in threads: one.join()
print(failures, frames)
"""


def test_the_first_two_apps_of_a_process_may_load_in_two_threads(tmp_path):
    """12 updates of 1/60 s are two turns of 0.1 s."""
    (tmp_path / "g.yaml").write_text(FILE)
    command = [sys.executable, "-c", PROGRAM, str(tmp_path / "g.yaml")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stdout == "[] [[2], [2]]\n", done.stderr


@pytest.mark.parametrize("command", [["run", "--updates", "2", "--out", "{}/out"], ["check"]])
def test_the_command_runs_outside_of_the_main_thread(tmp_path, command, capsys):
    (tmp_path / "g.yaml").write_text("tickgraph: 1\n")
    codes = []
    arguments = [command[0], str(tmp_path / "g.yaml"), *(one.format(tmp_path) for one in command[1:])]
    thread = threading.Thread(target=lambda: codes.append(main(arguments)))
    thread.start()
    thread.join()
    assert codes == [0], capsys.readouterr().err
