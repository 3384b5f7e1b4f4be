"""Textures of MJCF models in pictures, where MuJoCo puts them: an image of four pixels, seen in the middle of each."""

import numpy as np
import pytest
from PIL import Image

from graph.sim import App
from sensors.products import render_product
from tests.support.camera_worlds import look

RED, GREEN, BLUE, WHITE = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)
MODEL = """
<mujoco>
  <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
  <asset>
    <texture name="four" type="2d" file="four.png"/>
    <texture name="around" type="cube" builtin="flat" rgb1="0.2 0.4 0.6" rgb2="0.2 0.4 0.6" width="8" height="8"/>
    <mesh name="quad" vertex="-2 -2 0  2 -2 0  2 2 0.1  -2 2 0" texcoord="0 1  1 1  1 0  0 0" face="0 1 2  0 2 3"
          inertia="shell"/>
    <material name="look" {material}/>
  </asset>
  <worldbody>
    <geom {geom} material="look"/>
    <camera name="above" pos="0 0 10" fovy="60"/>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def shown(tmp_path):
    """A function that gives the colours at places (x, y) [m] of a geom with a material, seen from above."""

    def show(material, geom, *places):
        Image.fromarray(np.array([[RED, GREEN], [BLUE, WHITE]], np.uint8)).save(tmp_path / "four.png")
        (tmp_path / "model.xml").write_text(MODEL.format(material=material, geom=geom))
        (tmp_path / "graph.yaml").write_text("tickgraph: 1\nscene: {mjcf: model.xml}\n")
        with App.from_file(tmp_path / "graph.yaml") as app:
            [camera] = [str(prim.GetPath()) for prim in app.stage.Traverse() if prim.GetTypeName() == "Camera"]
            [picture] = look(app, render_product(app, camera, (801, 801)), "rgb")
            assert not app.warnings
        pixels = 400.5 / (10 * np.tan(np.deg2rad(30)))  # of a metre
        return [tuple(picture[round(400 - y * pixels), round(400 + x * pixels), :3].tolist()) for x, y in places]

    return show


def near(found, *expected):
    return np.abs(np.array(found) - np.array(expected)).max() < 30  # a pixel beside a middle shows up to 1 / 100 more


def test_a_texture_spans_a_plane_once_with_its_first_row_at_y(shown):
    """Of a plane of 4 m by 4 m the middles of the pixels are 1 m from its axes."""
    found = shown('texture="four"', 'type="plane" size="2 2 0.1"', (-1, 1), (1, 1), (-1, -1), (1, -1))
    assert near(found, RED, GREEN, BLUE, WHITE)


def test_uniform_textures_count_in_metres_also_on_planes_without_end(shown):
    """Once in two metres; without an end from (-1, 1) on: middles are at -0.5 and 0.5, then every 2 m."""
    places = (-0.5, 0.5), (0.5, 0.5), (1.5, 0.5), (-0.5, -3.5)
    found = shown('texture="four" texuniform="true"', 'type="plane" size="0 0 0.1"', *places)
    assert near(found, RED, GREEN, RED, RED)


def test_a_mesh_shows_it_by_its_coordinates_as_often_as_said(shown):
    """Twice each way over 4 m: middles are at 0.25, 0.75 ... of 2 m, from (-2, 2) on."""
    found = shown('texture="four" texrepeat="2 2"', 'type="mesh" mesh="quad"', (-1.5, 1.5), (-0.5, 1.5), (0.5, -1.5))
    assert near(found, RED, GREEN, BLUE)


def test_elsewhere_a_surface_has_the_mean_colour(shown):
    """Of red, green, blue and white: half of each, 188 in sRGB; a cube's texture is (51, 102, 153) all over."""
    assert near(shown('texture="four"', 'type="sphere" size="1"', (0, 0)), (188, 188, 188))
    assert near(shown('texture="around"', 'type="box" size="1 1 1"', (0, 0)), (51, 102, 153))


def test_a_material_tints_its_texture(shown):
    [found] = shown('texture="four" rgba="1 0.5 0.5 1"', 'type="plane" size="2 2 0.1"', (1, -1))
    assert near([found], (255, 128, 128))
