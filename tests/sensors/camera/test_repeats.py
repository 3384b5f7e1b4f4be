"""A camera gives the same bytes in every run, after a stop, and wherever the scene is."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom

from graph.sim import App
from sensors.camera.sensor import LISTS, WIDTHS
from sensors.replicator import get_annotator
from tests.support.camera_worlds import add_camera, ahead, look
from tests.support.lidar_worlds import add_box, weightless

NAMES = (*WIDTHS, *LISTS)


def scene(app):
    """A labelled box that moves and one that stands, under a sky; the camera has noise of its depth."""
    add_box(app, "/World/Body", 1.0, ahead(-1, 0, 5), velocity=(2.0, 0, 0), spin=(30.0, 20.0, 10.0))
    box = add_box(app, "/World/Box", 1.0, ahead(1, 0, 6))
    box.AddAppliedSchema("SemanticsLabelsAPI:class")
    box.GetAttribute("semantics:labels:class").Set(["box"])
    app.stage.DefinePrim("/World/Sky", "DomeLight").GetAttribute("inputs:intensity").Set(900.0)
    product = add_camera(app, size=(48, 36))
    names = ["rgb" if name == "rgba" else name for name in NAMES]
    return [get_annotator(name, app=app).attach(product) for name in [*names, "depth_sensor_distance"]]


def frames(app, annotators):
    """Bytes of all annotators after each of five updates."""
    found = []
    for _ in range(5):
        app.update()
        data = [one.get_data() for one in annotators]
        arrays = [each["data"] if isinstance(each, dict) else each for each in data]
        found.append([array.tobytes() for array in arrays])
    return found


def test_a_camera_gives_the_same_bytes_in_every_run_and_after_a_stop():
    runs = []
    for _ in range(2):
        with weightless(physics_hz=60, loop_hz=60) as app:
            annotators = scene(app)
            for _ in range(2):
                app.play()
                runs.append(frames(app, annotators))
                app.stop()
    assert runs[1:] == runs[:1] * 3
    assert all(first != second for first, second in zip(runs[0], runs[0][1:], strict=False))


@pytest.mark.parametrize("distance", [0.0, 300.7, 1e6, 1e6 + 300.7])
def test_depth_boxes_and_numbers_are_the_same_anywhere_up_to_a_thousand_kilometres(distance):
    """A box with its near side 4.1 m ahead: +-0.5 x 500 / 4.1 = 60.98 px about (320, 240): columns 259 to 380."""
    with App(None) as app:
        place = (distance, -distance, distance)
        add_box(app, "/World/Box", 1.0, tuple(a + b for a, b in zip(ahead(0, 0, 4.6), place, strict=True)))
        prim = app.stage.GetPrimAtPath("/World/Box")
        prim.AddAppliedSchema("SemanticsLabelsAPI:class")
        prim.GetAttribute("semantics:labels:class").Set(["box"])
        product = add_camera(app)
        UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Camera")).SetTranslate(Gf.Vec3d(*place))
        plane, numbers, boxes = look(
            app, product, "distance_to_image_plane", "instance_id_segmentation", "bounding_box_2d_tight"
        )
    inside = np.zeros((480, 640), bool)
    inside[179:301, 259:381] = True
    # Between the points of the 1 km grid of scenes both ends of a ray are off by half a float32 step (3.1e-5 m).
    np.testing.assert_allclose(plane[inside], 4.1, rtol=1e-6, atol=6.2e-5 if distance % 1000 else 0.0)
    assert np.isinf(plane[~inside]).all()
    assert np.array_equal(numbers["data"] == 2, inside)
    [box] = boxes["data"]
    assert [int(box[name]) for name in ("x_min", "y_min", "x_max", "y_max")] == [259, 179, 380, 300]
