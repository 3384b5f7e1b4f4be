import numpy as np
import pytest

from graph.sim.geometry.inside import shapes_around, winding_numbers
from graph.sim.scene.prims import author_prims
from graph.sim.scene.stage import open_stage

CORNERS = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


@pytest.fixture
def around():
    """Where a prim at a place lies in: the shapes of a scene written as in a graph file."""

    def run(place, shapes, exclude=()):
        stage = open_stage(None)
        author_prims(stage, {**shapes, "/Probe": {"type": "Xform", "translate": place}})
        [found] = shapes_around(stage, [stage.GetPrimAtPath("/Probe")], [exclude])
        return found

    return run


@pytest.mark.parametrize(
    ("shape", "inside", "outside"),
    [  # last, a box without a side: five sixths about its centre
        ({"type": "Cube", "size": 2.0, "scale": [1, 2, 3]}, [0.9, 1.9, 2.9], [0.9, 2.1, 0]),
        ({"type": "Sphere", "radius": 1.0}, [0.5, 0.5, 0.5], [0.7, 0.7, 0.7]),  # 0.87 and 1.21 from the centre
        ({"type": "Cylinder", "radius": 1.0, "height": 2.0, "axis": "X"}, [0.9, 0.6, 0.6], [0.9, 0.8, 0.8]),
        ({"type": "Mesh", "points": CORNERS, "faces": FACES}, [0.9, 0.9, 0.9], [1.1, 0, 0]),
        ({"type": "Mesh", "points": CORNERS, "faces": FACES[1:], "rotate": [0, 0, 90]}, [0, 0, 0], [0, 0, 1.1]),
    ],
)
def test_a_point_is_in_a_shape_or_beside_it(shape, inside, outside, around):
    assert around(inside, {"/Shape": shape}) == ["/Shape"]
    assert around(outside, {"/Shape": shape}) == []


def test_sheets_and_rooms_hold_nothing(around):
    floor = {"type": "Mesh", "points": [[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], "faces": [[0, 1, 2, 3]]}
    room = {"type": "Mesh", "points": CORNERS, "faces": [face[::-1] for face in FACES]}
    assert around([0, 0, 0], {"/Floor": floor, "/Plane": {"type": "Plane"}, "/Room": room}) == []


def test_what_is_hidden_or_excluded_is_passed_over(around):
    box = {"type": "Cube", "size": 2.0}
    shapes = {"/A/Box": box, "/B": {**box, "visible": False}}
    assert around([0, 0, 0], shapes) == ["/A/Box"]
    assert around([0, 0, 0], shapes, exclude=["/A"]) == []


def test_the_winding_number_is_1_inside_minus_1_inside_out_and_a_half_on_a_face():
    stage = open_stage(None)
    author_prims(
        stage,
        {
            "/Box": {"type": "Cube", "size": 2.0},
            "/Room": {"type": "Mesh", "points": CORNERS, "faces": [face[::-1] for face in FACES]},
        },
    )
    box, room = (stage.GetPrimAtPath(path) for path in ("/Box", "/Room"))
    places = np.array([[0.3, -0.2, 0.9], [0.3, -0.2, 1.1], [0.3, -0.2, 1.0]])  # inside, outside, half the sky
    assert winding_numbers(box, places) == pytest.approx([1, 0, 0.5], abs=1e-9)
    assert winding_numbers(room, places) == pytest.approx([-1, 0, -0.5], abs=1e-9)
