"""`isaacsim.sensors.camera.Camera` in scripts: its frequency and its pinhole model."""

import ast
import itertools

import pytest

APP = """
from isaacsim import SimulationApp
app = SimulationApp({'headless': True})
import numpy as np
from isaacsim.core.api import World
from isaacsim.sensors.camera import Camera
world = World(physics_dt=1/60, rendering_dt=1/60)
"""
DOWN = "orientation=np.array([np.sqrt(0.5), 0, np.sqrt(0.5), 0])"
"""It looks down, with the X axis of the world upwards in its picture."""


@pytest.fixture
def printed(run_script):
    """The values that a script prints, one a line."""

    def run(text):
        code, out, err = run_script(f"{APP}{text}\napp.close()\n")
        assert code == 0, err
        return [ast.literal_eval(line) for line in out.splitlines()]

    return run


@pytest.mark.parametrize(("given", "every"), [("frequency=20", 3), ("dt=0.1", 6), ("frequency=60", 1), ("", 1)])
def test_the_frame_is_taken_at_the_camera_s_frequency(printed, given, every):
    """Rendered 60 times a second: once in 60 / frequency updates a frame is taken, whose data stay until the next."""
    (times,) = printed(f"""
camera = Camera("/World/camera", {given})
world.reset()
camera.initialize()
camera.add_distance_to_image_plane_to_frame()
seen = []
for _ in range(24):
    world.step(render=True)
    frame = camera.get_current_frame()
    seen.append((frame["rendering_time"], frame["rendering_frame"], id(frame["distance_to_image_plane"])))
print([(round(60 * time), number) for time, number, _ in sorted(set(seen)) if time])
""")
    ticks, updates = zip(*times, strict=True)
    assert {after - before for before, after in itertools.pairwise(ticks)} == {every}
    assert {after - before for before, after in itertools.pairwise(updates)} == {every}
    assert len(times) in (24 // every, 24 // every - 1)


def test_a_frequency_that_does_not_divide_the_rendering_rate_is_refused(printed):
    """So is a dt that an update does not divide, and giving both."""
    assert printed("""
told = []
for options in ({"frequency": 25}, {"dt": 0.04}, {"frequency": 0}, {"frequency": 20, "dt": 0.05}):
    try:
        Camera("/World/camera", **options)
    except Exception as error:
        told.append(str(error))
print(told)
camera = Camera("/World/camera", dt=0.05)
print((camera.get_frequency(), camera.get_dt()))
camera.set_frequency(30)
print(camera.get_frequency())
print(Camera("/World/other").get_frequency())
""") == [
        [
            "frequency 25 Hz: the rendering rate, 60 Hz, is not a whole multiple of it",
            "dt 0.04 s: the rendering rate, 60 Hz, is not a whole multiple of it",
            "frequency 0 Hz: the rendering rate, 60 Hz, is not a whole multiple of it",
            "Camera takes a frequency or a dt, not both; leave one of them out",
        ],
        (20.0, 0.05),
        30.0,
        60.0,
    ]


def test_a_resolution_set_later_is_that_of_the_frames(printed):
    assert printed("""
camera = Camera("/World/camera", resolution=(16, 8))
world.reset()
camera.initialize()
camera.add_distance_to_image_plane_to_frame()
for size in ((16, 8), (8, 4)):
    camera.set_resolution(size)
    for _ in range(2):
        world.step(render=True)
    frame = camera.get_current_frame()
    print((frame["rgba"].shape, frame["distance_to_image_plane"].shape, camera.get_resolution()))
world.reset()
camera.initialize()
for _ in range(2):
    world.step(render=True)
print(camera.get_current_frame()["rgba"].shape)
""") == [((8, 16, 4), (8, 16), (16, 8)), ((4, 8, 4), (4, 8), (8, 4)), (4, 8, 4)]


def test_points_of_the_world_and_pixels_by_the_pinhole_model(printed):
    """10 m above the ground, f = 20, aperture 40, 200 x 100 pixels: 200 * 20 / 40 / 10 = 10 pixels for a metre.

    The centre is (100, 50). With the world's X upwards in the picture and Y to the left, (1, 2, 0) is at (80, 40).
    """
    pixels, back, camera_points, view, cloud = printed(f"""
camera = Camera("/World/camera", position=np.array([0.0, 0, 10]), {DOWN}, resolution=(200, 100))
camera.set_focal_length(2.0)
camera.set_horizontal_aperture(4.0)
pixels = camera.get_image_coords_from_world_points(np.array([[0.0, 0, 0], [1, 2, 0], [1, 2, 5]]))
print(pixels.round(4).tolist())
print(camera.get_world_points_from_image_coords(pixels, np.array([10.0, 10, 5])).round(4).tolist())
print(camera.get_camera_points_from_image_coords(pixels[:2], np.array([10.0, 10])).round(4).tolist())
print((camera.get_view_matrix_ros() @ [1, 2, 0, 1]).round(4).tolist())
from isaacsim.core.api.objects import FixedCuboid
FixedCuboid("/World/cube", position=np.array([0.0, 0, -0.5]), size=1.0, scale=np.array([100.0, 100, 1]))
world.reset()
camera.initialize()
camera.get_depth()
world.step(render=True)
clouds = [camera.get_pointcloud(world_frame=frame) for frame in (True, False)]
camera.add_pointcloud_to_frame(include_unlabelled=True)
world.step(render=True)
clouds += [camera.get_pointcloud(world_frame=frame) for frame in (True, False)]
print([(len(cloud), cloud.min(axis=0).round(3).tolist(), cloud.max(axis=0).round(3).tolist()) for cloud in clouds])
""")
    assert pixels == [[100, 50], [80, 40], [60, 30]]
    assert back == [[0, 0, 0], [1, 2, 0], [1, 2, 5]]
    assert camera_points == [[0, 0, 10], [-2, -1, 10]]
    assert view == [-2, -1, 10, 1]
    world = ([-4.95, -9.95, 0.0], [4.95, 9.95, 0.0])  # of the middles of the pixels, 0.05 m inside
    optical = ([-9.95, -4.95, 10.0], [9.95, 4.95, 10.0])
    assert [count for count, *_ in cloud] == [20000] * 4
    for (_, *found), wanted in zip(cloud, (world, optical, world, optical), strict=True):
        assert found == [pytest.approx(row, abs=1e-3) for row in wanted]


def test_the_pinhole_model_refuses_another_lens(printed):
    assert printed("""
camera = Camera("/World/camera")
camera.prim.AddAppliedSchema("OmniLensDistortionFthetaAPI")
try:
    camera.get_image_coords_from_world_points(np.zeros((1, 3)))
except Exception as error:
    print([str(error)])
""") == [["/World/camera has the lens ftheta, not a pinhole"]]


def test_the_default_ground_plane_brings_its_light(printed):
    """Pictures of it are not black; the light can be addressed, and turned off."""
    lit, dark = printed(f"""
world.scene.add_default_ground_plane()
camera = Camera("/World/camera", position=np.array([0.0, 0, 5]), {DOWN}, resolution=(8, 8))
world.reset()
camera.initialize()
light = world.stage.GetPrimAtPath("/World/defaultGroundPlane/SphereLight")
for intensity in (None, 0.0):
    if intensity is not None:
        light.GetAttribute("inputs:intensity").Set(intensity)
    world.step(render=True)
    print([light.GetTypeName(), int(camera.get_rgb().min()), int(camera.get_rgb().max())])
""")
    assert lit[0] == "SphereLight"
    assert 20 < lit[1] <= lit[2] < 255
    assert dark[1:] == [0, 0]


def test_a_lens_is_set_and_read_by_its_properties(printed):
    """What is left out keeps the schema's default; OpenCV's lenses note the size of the image.

    Of an image 1920 pixels wide, a focal length of 2 and an aperture of 4: fx = 1920 * 2 / 4; its aperture down is 2.
    """
    found = printed("""
camera = Camera("/World/camera", resolution=(64, 32))
print([camera.get_lens_distortion_model(), camera.get_ftheta_properties()])
camera.set_ftheta_properties(nominal_height=240, optical_center=(24, 25), distortion_coefficients=[1, 2])
height, width, centre, field, numbers = camera.get_ftheta_properties()
print([height, width, tuple(centre), field, numbers])
camera.set_opencv_pinhole_properties(cx=30.5, pinhole=[0.5, 0.25, 0.125])
print(camera.get_opencv_pinhole_properties())
print(tuple(camera.prim.GetAttribute("omni:lensdistortion:opencvPinhole:imageSize").Get()))
camera.set_focal_length(2.0)
camera.set_horizontal_aperture(4.0)
camera.set_kannala_brandt_properties(1920, 1080, 960, 540, None, [0.5, 0, 0, 0])
print(camera.get_opencv_fisheye_properties())
camera.set_lut_properties(ray_enter_direction_texture="enter.exr")
print([str(camera.get_lut_properties()[3].path), camera.get_lens_distortion_model()])
camera.set_lens_distortion_model("pinhole")
print([camera.get_lens_distortion_model(), camera.get_lut_properties()])
""")
    assert found == [
        ["pinhole", None],
        [240.0, 1936.0, (24.0, 25.0), 200.0, [1.0, 2.0, 0.0, 0.0, 0.0]],
        (30.5, 512.0, 900.0, 800.0, [0.5, 0.25, 0.125, *[0.0] * 9]),
        (64, 32),
        (960.0, 540.0, 960.0, 1080.0, [0.5, 0.0, 0.0, 0.0]),
        ["enter.exr", "lut"],
        ["pinhole", None],
    ]


def test_pixels_stay_square_and_other_values_are_kept(printed):
    """An image twice as wide as high: either aperture sets the other. Unknown values leave the prim as it is."""
    assert printed("""
camera = Camera("/World/camera", resolution=(200, 100))
camera.set_horizontal_aperture(4.0)
print(camera.get_vertical_aperture())
camera.set_vertical_aperture(1.0)
print(camera.get_horizontal_aperture())
camera.set_resolution((100, 100))
print(camera.get_vertical_aperture())
for value in ("orthographic", "cubic"):
    camera.set_projection_mode(value)
for value in ("left", "middle"):
    camera.set_stereo_role(value)
camera.set_shutter_properties(delay_close=3.0)
print([camera.get_projection_mode(), camera.get_stereo_role(), camera.get_shutter_properties()])
""") == [2.0, 2.0, 2.0, ["orthographic", "left", (0.0, 3.0)]]


def test_a_frame_holds_what_annotators_give_until_they_are_removed(printed):
    """Colours have the key of each version; labels come with their meaning. Before a frame there is nothing."""
    before, frame, after = printed("""
camera = Camera("/World/camera", resolution=(8, 4))
world.reset()
camera.initialize()
print([camera.get_rgba(), camera.get_depth(), len(camera.get_pointcloud())])
camera.add_semantic_segmentation_to_frame()
camera.add_occlusion_to_frame()
for _ in range(2):
    world.step(render=True)
frame = camera.get_current_frame()
labels = frame["semantic_segmentation"]
print([frame["rgb"].shape, frame["rgba"].shape, labels["data"].shape, sorted(labels["info"]), len(frame["occlusion"])])
for name in ("semantic_segmentation", "occlusion"):
    getattr(camera, f"remove_{name}_from_frame")()
print(sorted(camera.get_current_frame()))
""")
    assert before == [None, None, 0]
    assert frame == [(4, 8, 4), (4, 8, 4), (4, 8), ["idToLabels"], 0]
    assert after == ["distance_to_image_plane", "rendering_frame", "rendering_time", "rgb", "rgba"]


def test_a_given_render_product_gets_the_camera_and_the_size(printed):
    """By the class Camera, and by `isaacsim.core.utils.render_product`: the pictures then have that size."""
    assert printed("""
import omni.replicator.core as rep
from isaacsim.core.utils import render_product
other = rep.create.camera()
path = rep.create.render_product("/OmniverseKit_Persp", (32, 16)).path
camera = Camera("/World/camera", resolution=(8, 4), render_product_path=path)
world.reset()
camera.initialize()
world.step(render=True)
print([camera.get_rgba().shape, camera.get_render_product_path() == path])
print([render_product.get_camera_prim_path(path), render_product.get_resolution(path)])
render_product.set_resolution(path, (6, 2))
annotator = rep.AnnotatorRegistry.get_annotator("rgb")
annotator.attach(path)
world.step(render=True)
print(annotator.get_data().shape)
""") == [[(4, 8, 4), True], ["/World/camera", (8, 4)], (2, 6, 4)]


def test_the_fisheye_polynomial_is_the_lens_ftheta_by_its_former_arguments(printed):
    found = printed("""
camera = Camera("/World/camera", resolution=(64, 32))
try:
    camera.set_fisheye_polynomial_properties(1, 2, 3, 4, 5, None)
except ValueError as error:
    print(repr(str(error)))
camera.set_projection_type("fisheyePolynomial")
camera.set_fisheye_polynomial_properties(1920, 1080, 960, 540, 180, [1, 2, 3, 4, 5])
camera.set_fisheye_polynomial_properties(None, None, 100, None, None, None)
print(camera.get_fisheye_polynomial_properties())
""")
    assert found == [
        "/World/camera: call set_projection_type('fisheyePolynomial') first",
        (1920.0, 1080.0, 100.0, 540.0, 180.0, [1.0, 2.0, 3.0, 4.0, 5.0]),
    ]


def test_a_near_distance_of_0_is_a_distance(printed):
    found = printed("""
camera = Camera("/World/camera", resolution=(64, 32))
camera.set_clipping_range(near_distance=0.0, far_distance=10.0)
camera.set_clipping_range(far_distance=20.0)
print(camera.get_clipping_range())
try:
    camera.attach_annotator("rgb")
except RuntimeError as error:
    print(repr(str(error)))
""")
    assert found == [(0.0, 20.0), "Camera.initialize() must be called before attach_annotator()"]
