"""How a notebook shows frames and recordings."""

import base64
import io
import re
import subprocess
import sys

import numpy as np
from PIL import Image

from graph.recording.run_reader import RunReader
from sensors.frame import Frame, FramePose
from sensors.gmo import GenericModelOutput

POSE = FramePose(0, np.eye(4))


def frame(count, **arrays):
    return Frame(0, 3, POSE, POSE, count, arrays, sensor_path="/World/<S>")


def picture(html):
    data = re.search(r'src="data:image/png;base64,([^"]+)"', html)[1]
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(data))))


def test_a_frame_says_its_channels_and_their_shapes_in_one_line():
    assert repr(frame(2, xyz=np.zeros((2, 3), np.float32))) == "<Frame 3 of /World/<S> at 0 ns: xyz (2, 3)>"


def test_the_frame_of_a_camera_is_shown_as_its_image():
    image = np.zeros((4, 6, 3), np.uint8)
    image[1, 2] = 200, 100, 50
    html = frame(24, rgb=image)._repr_html_()
    assert np.array_equal(picture(html), image)
    assert "/World/&lt;S&gt;" in html
    assert "<S>" not in html


def test_the_frame_of_a_lidar_is_shown_from_above_whether_in_angles_or_in_points():
    """A point 2 m ahead: (2, 0, 0), or azimuth 0, elevation 0, distance 2."""
    zero = np.zeros(1, np.float32)
    points = frame(1, xyz=np.array([[2, 0, 0]], np.float32))
    angles = frame(1, azimuth=zero, elevation=zero, distance=np.array([2], np.float32))
    shown = picture(points._repr_html_())
    assert len(np.unique(shown.reshape(-1, 3), axis=0)) > 3
    assert np.array_equal(shown, picture(angles._repr_html_()))


def test_a_frame_without_a_picture_is_text():
    html = frame(0)._repr_html_()
    assert html.startswith("<code>&lt;Frame 3 of /World/&lt;S&gt; at 0 ns: no channels")


def test_an_empty_model_output_is_told_in_one_line():
    output = GenericModelOutput()
    assert ": 0 elements, " in repr(output)
    assert output._repr_html_().startswith("<code>&lt;GenericModelOutput")


def test_a_recording_is_shown_as_the_table_of_its_topics():
    run = RunReader("run", (), None, ())
    assert repr(run) == "<recording run: 0 messages on 0 topics>"
    assert "<th>topic</th><th>type</th><th>messages</th>" in run._repr_html_()


def test_nothing_that_draws_is_imported_until_something_is_shown():
    drawing = "[name for name in sys.modules if name.startswith(('PIL', 'sensors.writers'))]"
    code = f"import sys, sensors.frame, sensors.gmo; print({drawing})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
