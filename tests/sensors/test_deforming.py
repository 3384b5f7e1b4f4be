"""What a lidar sees of cloth, soft bodies and particles: the shape that physics has given them."""

from __future__ import annotations

import numpy as np
import pytest

from graph.sim import App
from sensors import Lidar, LidarSensor, parse_generic_model_output_data

G = 9.81
SHEET = [(x, y, 0.0) for x in np.linspace(-2, 2, 5) for y in np.linspace(-2, 2, 5)]
FACES = [[i * 5 + j, i * 5 + j + 5, i * 5 + j + 6, i * 5 + j + 1] for i in range(4) for j in range(4)]


def scene(prims, authored="", **options):
    """An App with prims and USD text, a lidar at 1 m looking all round in a plane."""
    app = App(physics_hz=240, loop_hz=60, **options)
    app.stage.GetRootLayer().ImportFromString(f'#usda 1.0\n(\nmetersPerUnit = 1\nupAxis = "Z"\n)\n{authored}')
    app.add_prims(prims)
    lidar = Lidar.create("/World/Lidar", config="Example_Rotary_2D", translations=[0, 0, 1], app=app)
    return app, LidarSensor(lidar, annotators=["generic-model-output"])


def mesh(kind, points, faces, more=""):
    counts, corners = [len(face) for face in faces], [corner for face in faces for corner in face]
    return f"""
def Mesh "Cloth" (prepend apiSchemas = ["{kind}"])
{{
    point3f[] points = {[tuple(map(float, point)) for point in points]}
    int[] faceVertexCounts = {counts}
    int[] faceVertexIndices = {corners}
    {more}
}}
"""


def ahead(app, sensor, updates=6):
    """The distance straight ahead [m] in the newest scan; NaN where nothing is."""
    app.update(updates)
    data = sensor.get_data("generic-model-output")[0]
    frame = parse_generic_model_output_data(data)
    azimuth, distance = np.asarray(frame.x), np.asarray(frame.z)
    close = np.flatnonzero(np.abs(azimuth) < 0.5)
    return float(distance[close[0]]) if len(close) else float("nan")


def test_a_falling_sheet_leaves_the_beam_and_a_flying_one_comes_nearer():
    """A wall of cloth 4 x 4 m at 8 m flies at the lidar with 10 m/s; gravity takes it below 1 m after 0.78 s."""
    wall = [(8.0, y, z) for y in np.linspace(-2, 2, 5) for z in np.linspace(0, 4, 5)]
    app, sensor = scene({}, mesh("PhysxDeformableSurfaceAPI", wall, FACES, "vector3f physics:velocity = (-10, 0, 0)"))
    with app:
        app.play()
        seen = [ahead(app, sensor) for _ in range(7)]
        # the scan that ends at k / 10 s is of the state at its end: 8 - k m, while the top edge is above 1 m
        for k, distance in enumerate(seen, start=1):
            assert distance == pytest.approx(8 - k, abs=0.02)
        assert np.isnan(ahead(app, sensor, 12))
        app.stop()
        app.play()
        assert ahead(app, sensor) == pytest.approx(7, abs=0.02)


def test_a_continuous_scan_sees_cloth_where_it_is_in_the_middle_of_each_span():
    """8 spans a turn of 0.1 s at 10 m/s: the first beam is 1/16 m nearer than at its own time, the last farther."""
    wall = [(8.0, y, z) for y in np.linspace(-2, 2, 5) for z in np.linspace(0, 4, 5)]
    flying = mesh("PhysxDeformableSurfaceAPI", wall, FACES, "vector3f physics:velocity = (-10, 0, 0)")
    app, sensor = scene({}, flying, fidelity={"lidar.motion": "continuous", "lidar.bins": 8})
    with app:
        app.play()
        for k in range(4):
            app.update(6)
            frame = parse_generic_model_output_data(sensor.get_data("generic-model-output")[0])
            ahead = np.abs(frame.x) < 0.11  # clockwise from 0: the first beam of a turn, and the last at 0.1 degrees
            first, last = frame.z[ahead][[0, -1]]
            assert first == pytest.approx(8 - k - 1 / 16, abs=1e-4)
            assert last == pytest.approx(7 - k + 1 / 16, abs=1e-4)


def test_a_sheet_flies_on_when_the_world_is_compiled_again():
    wall = [(8.0, y, z) for y in np.linspace(-2, 2, 5) for z in np.linspace(0, 4, 5)]
    ball = {"/World/Ball": {"type": "Sphere", "radius": 0.2, "translate": [0, 50, 9], "rigid_body": True}}
    app, sensor = scene(ball, mesh("PhysxDeformableSurfaceAPI", wall, FACES, "vector3f physics:velocity = (-10, 0, 0)"))
    with app:
        app.play()
        assert ahead(app, sensor) == pytest.approx(7, abs=0.02)
        box = {"/World/New": {"type": "Cube", "size": 1, "translate": [0, 20, 5], "rigid_body": True}}
        app.add_prims(box, when_playing="recompile")
        assert ahead(app, sensor) == pytest.approx(6, abs=0.02)


def test_a_subset_of_a_sheet_flies_with_it():
    wall = [(8.0, y, z) for y in np.linspace(-2, 2, 5) for z in np.linspace(0, 4, 5)]
    subset = 'def GeomSubset "Part" {\n uniform token elementType = "face"\n int[] indices = [5, 6, 9, 10]\n'
    subset += ' uniform token familyName = "materialBind"\n}'
    flying = mesh("PhysxDeformableSurfaceAPI", wall, FACES, f"vector3f physics:velocity = (-10, 0, 0)\n{subset}")
    app, sensor = scene({}, flying)
    with app:
        app.play()
        assert ahead(app, sensor) == pytest.approx(7, abs=0.02)


def test_particles_are_seen_where_they_are():
    grid = [(5.0, 0.05 * j, 1.0 + 0.5 * k) for j in range(-1, 2) for k in range(3)]
    sand = f"""
def Points "Sand" (prepend apiSchemas = ["PhysxParticleSetAPI"])
{{
    point3f[] points = {grid}
    float[] widths = {[0.2] * len(grid)}
}}
"""
    app, sensor = scene({"/World/Wall": {"type": "Cube", "size": 4, "translate": [12, 0, 0]}}, sand)
    with app:
        app.play()
        # balls of 0.1 m whose middles have fallen g t2 / 2 = 0.051 m at 0.1 s; at 0.2 s their rows have left the beam
        assert ahead(app, sensor) == pytest.approx(5 - np.sqrt(0.1**2 - 0.051**2), abs=5e-3)
        assert ahead(app, sensor) == pytest.approx(10, abs=0.01)
