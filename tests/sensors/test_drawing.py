"""Pictures of point clouds: where points land, and that the same cloud gives the same bytes."""

import numpy as np
import pytest
from PIL import Image

import sensors.replicator as rep
from graph.base.errors import RunError
from sensors import Lidar, LidarSensor
from sensors.frame import Frame, FramePose
from sensors.lidar.prim import write_config
from sensors.writers.drawing import BACKGROUND, SENSOR, PointCloudDrawing, RayDrawing
from tests.support.lidar_worlds import add_box, rotary, weightless

DARK = np.rint(BACKGROUND).astype(np.uint8)
WHITE = (1.0, 1.0, 1.0, 1.0)


def frame_of(points, pose=None, frame_of_reference="SENSOR", number=0):
    points = np.asarray(points, np.float32).reshape(-1, 3)
    at = FramePose(0, np.eye(4) if pose is None else pose)
    return Frame(
        timestamp_ns=0,
        frame_id=number,
        start=at,
        end=at,
        count=len(points),
        arrays={"xyz": points},
        sensor_path="/World/Lidar",
        frame_of_reference=frame_of_reference,
    )


def drawn(points, **options):
    """Which pixels (row, column) hold points: 100 x 100 pixels, 10 m, about the origin; the sensor far off."""
    pose = np.eye(4)
    pose[:3, 3] = 900.0
    options = {"color": WHITE, "center": (0, 0, 0), "span": 10.0, "resolution": (100, 100), **options}
    picture = PointCloudDrawing(**options).draw(frame_of(points, pose, "WORLD"))
    rows, columns = np.nonzero((picture == 255).all(axis=2))
    return sorted(zip(rows.tolist(), columns.tolist(), strict=True))


@pytest.mark.parametrize(
    ("view", "pixel"),
    [
        # 10 pixels a metre; the centre lies between pixels 49 and 50, rows count down.
        ("top", (50 - 21, 50 + 10)),  # x 1.05 to the right, y 2.05 up
        ("front", (50 - 31, 50 - 21)),  # along +x: +y is left, z 3.05 up
        ("side", (50 - 31, 50 + 10)),  # along +y: x to the right, z up
    ],
)
def test_a_point_lands_where_the_view_puts_it(view, pixel):
    assert drawn([[1.05, 2.05, 3.05]], view=view) == [pixel]


def test_the_oblique_view_looks_down_at_45_degrees():
    up, right = drawn([[0, 0, 1.0]], view="oblique"), drawn([[1.0, -1.0, 0]], view="oblique")

    assert up == [(50 - 8, 50)]  # cos 45 deg = 0.707 m up
    assert right == [(50, 50 + 14)]  # sqrt 2 m to the right


def test_size_is_the_side_of_a_square_and_at_least_a_pixel():
    assert len(drawn([[0, 0, 0]], size=0.02)) == 1
    assert len(drawn([[0, 0, 0]], size=0.5)) == 25


def test_do_transform_puts_the_sensors_points_into_the_world():
    pose = np.eye(4)
    pose[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]  # a quarter turn to the left
    pose[:3, 3] = 1.05, 0.05, 0.0
    options = {"color": WHITE, "center": (0, 0, 0), "span": 10.0, "resolution": (100, 100)}

    def pixel(frame, **more):
        picture = PointCloudDrawing(**options, **more).draw(frame)
        return np.argwhere((picture == 255).all(axis=2)).tolist()

    ahead = [[2.0, 0.0, 0.0]]
    assert pixel(frame_of(ahead, pose)) == [[50 - 21, 60]]  # the world's (1.05, 2.05)
    assert pixel(frame_of(ahead, pose), doTransform=False) == [[50, 70]]
    assert pixel(frame_of(ahead, pose, "WORLD")) == [[50, 70]]


def test_color_is_mixed_with_the_background_by_its_alpha():
    picture = PointCloudDrawing(color=(1, 0.5, 0, 0.5), center=(0, 0, 0), span=10, resolution=(100, 100)).draw(
        frame_of([[3.05, 3.05, 0]])
    )

    assert picture[50 - 31, 50 + 30].tolist() == [132, 68, 6]  # half of (255, 127.5, 0) and of (8, 8, 12)


def test_the_first_points_decide_what_all_pictures_show():
    drawing = PointCloudDrawing(color=WHITE, resolution=(100, 100))
    empty = drawing.draw(frame_of([]))
    assert (empty == SENSOR).all(axis=2).any()

    square = [[-4, -4, 0], [4, 4, 0], [-4, 4, 0], [4, -4, 0]]
    first = drawing.draw(frame_of(square))
    assert (first == 255).all(axis=2).sum() == 4
    assert np.array_equal(first, drawing.draw(frame_of([*square, [1000, 1000, 0]])))


def test_equal_frames_give_equal_files_named_by_sensor_and_frame(tmp_path):
    points = np.random.default_rng(0).normal(size=(1000, 3)) * 5
    files = [
        PointCloudDrawing(output_dir=tmp_path / name)(frame_of(points, number=number))
        for name, number in (("a", 3), ("b", 3))
    ]

    assert [file.name for file in files] == ["World_Lidar_000003.png"] * 2
    assert files[0].read_bytes() == files[1].read_bytes()
    with Image.open(files[0]) as image:
        assert (image.size, image.mode) == ((960, 720), "RGB")


def test_no_two_sensors_share_a_picture(tmp_path):
    draw = PointCloudDrawing(output_dir=tmp_path)
    names = []
    for path in ("/World/A_B", "/World/A/B"):
        frame = frame_of([[1, 1, 1]])
        frame.sensor_path = path
        names.append(draw(frame).name)

    assert names == ["World_A__B_000000.png", "World_A_B_000000.png"]


def test_the_older_names_of_the_writer_draw_alike(tmp_path):
    frame = frame_of([[3.0, 1.0, 0.5]])
    files = {
        name: rep.WriterRegistry.get(name).spec.factory(output_dir=tmp_path / name)(frame)
        for name in ("RtxSensorDebugDrawPointCloud", "RtxLidarDebugDrawPointCloud", "RtxLidarDebugDrawPointCloudBuffer")
    }
    assert len({file.read_bytes() for file in files.values()}) == 1
    assert rep.writers.get("RtxRadarDebugDrawPointCloud").options["size"] == 0.2


def test_in_test_mode_nothing_is_written(tmp_path):
    file = PointCloudDrawing(output_dir=tmp_path / "none", testMode=True)(frame_of([[1, 1, 1]]))
    assert not file.exists()


def test_a_folder_that_cannot_be_written_ends_the_run_in_one_line(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(RunError, match=r"draw-point-cloud: .*give an output_dir that can be written"):
        PointCloudDrawing(output_dir=tmp_path / "taken" / "in")(frame_of([[1, 1, 1]]))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"view": "tpo"}, 'did you mean "top"'),
        ({"size": 0}, "above 0 m"),
        ({"span": float("nan")}, "above 0 m"),
        ({"color": (1, 1, 1)}, "is not r, g, b, a"),
        ({"color": (255, 0, 0, 1)}, "from 0 to 1"),
        ({"resolution": (0, 5)}, "width and height"),
        ({"center": (1, 2)}, "is not x, y, z"),
    ],
)
def test_wrong_arguments_are_named(options, message):
    with pytest.raises(ValueError, match=message):
        PointCloudDrawing(**options)


def test_an_argument_that_the_writer_does_not_have_is_reported_with_what_is_near():
    with weightless() as app:
        lidar = Lidar.create("/World/Lidar", config="RPLIDAR_S2E", app=app)
        writer = rep.writers.get("RtxSensorDebugDrawPointCloud").initialize(colour=WHITE)

        with pytest.raises(ValueError, match=r"it has no option 'colour'; did you mean \"color\"\?"):
            writer.attach(rep.create_render_product(lidar.path))


def test_a_sensor_draws_each_of_its_frames(tmp_path):
    with weightless() as app:
        add_box(app, "/World/Room", 10.0, (0, 0, 0))
        write_config(app.stage.DefinePrim("/World/Lidar", "OmniLidar"), rotary())
        sensor = LidarSensor(Lidar("/World/Lidar", app=app))
        sensor.attach_writer("draw-point-cloud", output_dir=tmp_path / "a", size=0.1)
        writer = rep.writers.get("RtxSensorDebugDrawPointCloud").initialize(output_dir=tmp_path / "b", size=0.1)
        writer.attach([sensor.render_product])
        app.play()
        app.update(steps=12)
    names = ["World_Lidar_000000.png", "World_Lidar_000001.png"]
    for folder in ("a", "b"):
        assert sorted(file.name for file in (tmp_path / folder).iterdir()) == names
    assert (tmp_path / "a" / names[1]).read_bytes() == (tmp_path / "b" / names[1]).read_bytes()


def test_a_ray_is_a_straight_line_from_its_start_to_its_end():
    """10 pixels a metre about the origin: from (-2, 0.05) to (3, 0.05) in the row just above the middle."""
    drawing = RayDrawing("/World/Graph/draw", "unused", center=(0, 0, 0), span=10, resolution=(100, 100))
    ray = np.array([[-2.0, 0.05, 7.0]]), np.array([[3.0, 0.05, -7.0]])
    picture = drawing.draw(*ray, (1.0, 1.0, 1.0, 1.0), 0.02)
    rows, columns = np.nonzero((picture == 255).all(axis=2))
    assert set(rows.tolist()) == {49}
    assert columns.tolist() == list(range(30, 81))


def test_pictures_of_rays_are_numbered_and_rays_that_are_not_finite_left_out(tmp_path):
    drawing = RayDrawing("/World/Graph/my_rays", tmp_path, resolution=(50, 50))
    nothing = np.array([[np.nan, 0, 0]]), np.array([[1.0, 0, 0]])
    files = [drawing(*nothing, WHITE, 0.1) for _ in range(2)]
    assert [file.name for file in files] == ["World_Graph_my__rays_000000.png", "World_Graph_my__rays_000001.png"]
    assert not (np.asarray(Image.open(files[0])) == 255).any()
    with pytest.raises(ValueError, match="is not r, g, b, a"):
        drawing.draw(*nothing, (2.0, 0, 0, 1), 0.1)
