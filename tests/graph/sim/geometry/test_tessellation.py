import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graph.sim.geometry import tessellation
from graph.sim.geometry.polygons import triangles_of, usable_faces
from tests.support.collected_meshes import volume_within


def triangulate(points, counts, indices, holes=(), flip=False, complain=lambda message: None):
    """Triangles (m, 3) of polygons, in face order, and the face that each comes from."""
    faces = usable_faces(points, counts, indices, complain)
    return triangles_of(points, faces.only(~np.isin(faces.source, holes)), flip)


def planes(vertices, triangles):
    """Distance of each triangle's plane from the origin, positive if it faces away from it."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    return np.einsum("ij,ij->i", normals, a) / np.linalg.norm(normals, axis=1)


def closed(triangles):
    """Every edge is walked once in each direction."""
    edges = np.concatenate([triangles[:, (0, 1)], triangles[:, (1, 2)], triangles[:, (2, 0)]]).tolist()
    walked = {tuple(edge) for edge in edges}
    return len(walked) == len(edges) and all((b, a) in walked for a, b in walked)


@pytest.mark.parametrize("tolerance", [0.1, 0.01, 1e-3, 1e-4])
@pytest.mark.parametrize("radius", [0.05, 1.0, 3.0])
def test_a_sphere_stays_within_the_tolerance_and_inside_itself(radius, tolerance):
    parts = tessellation.sphere_parts(radius, tolerance)
    vertices, triangles = tessellation.sphere(radius, parts)
    assert np.allclose(np.linalg.norm(vertices, axis=1), radius, rtol=1e-12)
    nearest = planes(vertices, triangles).min()
    # The middle of a facet at the equator: both its arcs, of 2 pi / parts, lower it.
    bound = radius * (1 - math.sqrt(math.cos(2 * math.pi / parts)))
    assert radius - bound <= nearest <= radius - 0.6 * bound
    assert bound <= tolerance or parts == tessellation.FEWEST_PARTS
    assert closed(triangles)


def test_a_circle_has_the_fewest_parts_that_keep_its_sagitta():
    # r (1 - cos(pi / n)) <= 1e-3 for r = 1: n >= pi / acos(0.999) = 70.25
    assert tessellation.circle_parts(1.0, 1e-3) == 71
    assert 1 - math.cos(math.pi / 71) <= 1e-3 < 1 - math.cos(math.pi / 70)


def test_a_tolerance_beyond_reach_is_capped():
    assert tessellation.sphere_parts(1000.0, 1e-6) == tessellation.MOST_PARTS


def test_the_cube_is_closed_faces_out_and_is_exact():
    vertices, triangles = tessellation.cube(2.0)
    assert volume_within(vertices, triangles) == 8.0
    assert closed(triangles)
    assert (planes(vertices, triangles) == 1.0).all()


@pytest.mark.parametrize("axis", ["X", "Y", "Z"])
def test_solids_of_revolution_are_closed_face_out_and_lie_along_their_axis(axis):
    along = "XYZ".index(axis)
    for vertices, triangles, true in (
        (*tessellation.cylinder(0.5, 0.5, 4.0, axis, 64), math.pi * 0.25 * 4),
        (*tessellation.cylinder(0.5, 0.0, 4.0, axis, 64), math.pi * 0.25 * 4 / 3),
        (*tessellation.capsule(0.5, 0.5, 3.0, axis, 64), math.pi * 0.25 * 3 + math.pi / 6),
    ):
        assert closed(triangles)
        assert 0.99 * true < volume_within(vertices, triangles) < true
        assert np.ptp(vertices[:, along]) == 4.0
    assert tessellation.cylinder(0.5, 0.0, 4.0, axis, 64)[0][1, along] == 2.0  # the tip of the cone points along +axis


@pytest.mark.parametrize(("axis", "extent"), [("X", (0, 3, 2)), ("Y", (2, 0, 3)), ("Z", (2, 3, 0))])
def test_a_rectangle_lays_out_width_and_length_as_usd_does(axis, extent):
    vertices, triangles = tessellation.rectangle(2.0, 3.0, axis)
    assert tuple(np.ptp(vertices, axis=0)) == extent
    a, b, c = (vertices[triangles[0]][i] for i in range(3))
    normal = np.cross(b - a, c - a)
    assert (normal / np.linalg.norm(normal) == tessellation.axis_vector(axis)).all()


L_SHAPE = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0]], dtype=np.float64)


@pytest.mark.parametrize("start", range(6))
@pytest.mark.parametrize("backwards", [False, True])
def test_a_concave_polygon_keeps_its_area_from_any_corner(start, backwards):
    corners = np.roll(L_SHAPE, start, axis=0)[:: -1 if backwards else 1]
    triangles, faces = triangulate(corners, np.array([6]), np.arange(6))
    areas = [np.cross(corners[b] - corners[a], corners[c] - corners[a])[2] / 2 for a, b, c in triangles]
    assert sum(areas) == (-3.0 if backwards else 3.0)
    assert all((area < 0) == backwards for area in areas)
    assert faces.tolist() == [0, 0, 0, 0]


def test_a_concave_quad_is_cut_at_its_hollow_corner():
    arrow = np.array([[0, 0, 0], [1, -1, 0], [0, 2, 0], [-1, -1, 0]], dtype=np.float64)
    triangles, _ = triangulate(arrow, np.array([4]), np.array([0, 1, 2, 3]))
    assert sorted(map(sorted, triangles.tolist())) == [[0, 1, 2], [0, 2, 3]]


def areas_of(corners, triangles):
    """Signed areas in the xy plane."""
    a, b, c = (corners[triangles[:, i], :2] for i in range(3))
    return ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2


@st.composite
def stars(draw):
    """A star-shaped polygon on a grid of 1/8, its outline with corners on straight edges, and its area by shoelace."""
    size = draw(st.integers(4, 12))
    radii = draw(st.lists(st.integers(8, 40), min_size=size, max_size=size))
    angles = [2 * math.pi * number / size for number in range(size)]
    outline = [(round(r * math.cos(a)), round(r * math.sin(a))) for r, a in zip(radii, angles, strict=True)]
    corners = []
    for (x, y), (u, v) in zip(outline, outline[1:] + outline[:1], strict=True):
        between = draw(st.integers(0, 2))
        corners += [(x + (u - x) * k / (between + 1), y + (v - y) * k / (between + 1)) for k in range(between + 1)]
    area = sum(x * v - y * u for (x, y), (u, v) in zip(outline, outline[1:] + outline[:1], strict=True)) / 2
    return np.array([(x, y, 0.0) for x, y in corners]), area


@given(stars(), st.booleans(), st.integers(0, 40))
def test_any_polygon_is_covered_once_and_meets_its_neighbours_at_every_corner(star, backwards, start):
    """Areas add up and have one sign; each edge of the outline is an edge of one triangle, straight corners or not."""
    outline, area = star
    corners = np.roll(outline, start, axis=0)[:: -1 if backwards else 1]
    size = len(corners)
    triangles, _ = triangulate(corners, np.array([size]), np.arange(size))
    assert len(triangles) == size - 2
    areas = areas_of(corners, triangles) * (-1 if backwards else 1)
    assert areas.sum() == pytest.approx(area, rel=1e-12)
    assert areas.min() >= -1e-9
    edges = {(t[i], t[(i + 1) % 3]) for t in triangles.tolist() for i in range(3)}
    assert {(corner, (corner + 1) % size) for corner in range(size)} <= edges


def test_a_hole_that_a_bridge_joins_to_the_outline_stays_open():
    """As modellers export holes: in along a bridge, round the hole the other way, back. 8 x 8 minus 2 x 2 is 60."""
    outline = [(0, 0), (3, 3), (3, 4), (3, 5), (5, 5), (5, 3), (3, 3), (0, 0), (4, 0), (8, 0), (8, 8), (0, 8)]
    corners = np.array([(x, y, 0.0) for x, y in outline])
    areas = areas_of(corners, triangulate(corners, np.array([12]), np.arange(12))[0])
    assert areas.sum() == 60
    assert areas.min() >= 0


def test_two_corners_at_one_place_leave_a_triangle_without_area():
    corners = np.array([(x, y, 0.0) for x, y in [(0, 0), (2, 0), (2, 0), (2, 2), (1, 1), (0, 2)]])
    areas = areas_of(corners, triangulate(corners, np.array([6]), np.arange(6))[0])
    assert len(areas) == 4
    assert areas.sum() == 3  # the square of 4 minus the notch of 1
    assert areas.min() == 0


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e9])
def test_a_comb_of_20_002_corners_keeps_its_area(scale):
    """10,000 teeth of base 2 and height 1 on a back of height 1: areas 10,000 + 20,000."""
    teeth = [(2 * k + odd, 2 - odd) for k in range(10_000) for odd in (0, 1)]
    corners = np.array([(x * scale, y * scale, 0.0) for x, y in [*teeth, (20_000, 2), (20_000, 0), (0, 0)]])
    triangles, _ = triangulate(corners, np.array([len(corners)]), np.arange(len(corners)))
    assert len(triangles) == len(corners) - 2
    assert np.abs(areas_of(corners, triangles)).sum() == pytest.approx(30_000 * scale**2, rel=1e-9)


def test_a_polygon_that_crosses_itself_a_thousand_times_is_cut_all_the_same():
    """Its triangles count as any polygon's; the same ones each time."""
    corners = np.random.default_rng(1).uniform(size=(1000, 3))
    first, _ = triangulate(corners, np.array([1000]), np.arange(1000))
    again, _ = triangulate(corners, np.array([1000]), np.arange(1000))
    assert len(first) == 998
    assert first.max() < 1000
    assert first.tobytes() == again.tobytes()


def test_faces_keep_their_order_holes_are_left_out_and_the_winding_turns():
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=np.float64)
    counts, indices = np.array([3, 4, 3]), np.array([0, 1, 2, 0, 1, 2, 3, 0, 2, 3])
    triangles, faces = triangulate(points, counts, indices)
    assert faces.tolist() == [0, 1, 1, 2]
    triangles, faces = triangulate(points, counts, indices, holes=np.array([1, 99]), flip=True)
    assert triangles.tolist() == [[2, 1, 0], [3, 2, 0]]
    assert faces.tolist() == [0, 2]


@pytest.mark.parametrize(
    ("counts", "indices", "said"),
    [
        ([3, 3], [0, 1, 2, 0, 1, 9], "1 faces have points that do not exist"),
        ([3, 3], [0, 1, 2, 0, 1, -1], "1 faces have points that do not exist"),
        ([3, 2, 1], [0, 1, 2, 0, 1, 0], "2 faces have fewer than 3 corners"),
        ([3, 3, 3], [0, 1, 2, 0, 1], "faceVertexCounts asks for 9 indices, there are 5"),
        ([3, 3], [0, 1, 2, 0, 1, 3], "1 faces have points that are not finite"),
        ([3, -3], [0, 1, 2], "faceVertexCounts holds negative numbers"),
    ],
)
def test_bad_faces_are_left_out_and_said(counts, indices, said):
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 0]])
    complaints = []
    triangles, _ = triangulate(points, np.array(counts), np.array(indices), complain=complaints.append)
    assert triangles.tolist() == [[0, 1, 2]]
    assert any(said in complaint for complaint in complaints)


def test_a_circle_beyond_all_measure_has_the_most_parts():
    # 1 - tolerance / radius rounds to 1, so the angle of a part to 0.
    assert tessellation.circle_parts(1e38, 1e-3) == tessellation.sphere_parts(1e38, 1e-3) == tessellation.MOST_PARTS
