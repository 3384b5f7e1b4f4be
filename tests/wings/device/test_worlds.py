"""Many worlds: each is what one alone would be, scans by the exact schedule, and begins again after a reset."""

import numpy as np
import pytest

pytest.importorskip("warp", reason="pip install 'tickgraph[gpu]'")
pytest.importorskip("mujoco_warp", reason="pip install 'tickgraph[gpu]'")

from graph.base.errors import UserError
from graph.sim import App, Worlds
from graph.spec.distributions import Stream, parse
from sensors import render_product
from sensors.annotators.annotator import Annotator
from sensors.annotators.registry import find_annotator
from tests.support.devices import DEVICES, WORLD

LIDAR = "/World/Mast/lidar"
SPEEDS = [[5], [0], [-5]]


RANDOM = """\
randomize:
  /World/Ball.translate: uniform([1.5, -0.5, 0.4], [2.5, 0.5, 0.4])
  /World/Ball.mass: uniform(0.5, 2)
  /World/Wall.translate: uniform([3, 1, 0.5], [4, 2, 0.5])
  /World/Mast/lidar.mount_translate: normal([0, 0, 0], 0.01)
  /World/Mast/lidar.mount_rotate: normal([0, 0, 0], 1)
  /World/turn.drive:angular:physics:damping: uniform(3, 9)
"""


GATE = """\
#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "World"
{
    def Cube "Gate" (prepend apiSchemas = ["PhysicsRigidBodyAPI"])
    {
        bool physics:kinematicEnabled = 1
        double3 xformOp:translate.timeSamples = { 0: (9, 0, 0), 48: (9, 5, 0) }
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
"""


def seen_by_an_app(file, seed):
    """Ranges [m] of the first scan of the file in an App."""
    with App.from_file(file, seed=seed) as app:
        cloud = Annotator(find_annotator("IsaacExtractRTXSensorPointCloud"), app=app).attach(render_product(app, LIDAR))
        app.play()
        app.update(steps=6)
        return cloud.get_data()["distance"]


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("worlds") / "mast.yaml"
    path.write_text(WORLD)
    return path


@pytest.fixture(scope="module", params=DEVICES)
def device(request):
    return request.param


@pytest.fixture(scope="module")
def opened(device, file):
    with Worlds(file, count=3, device=device, channels=["distance"]) as worlds:
        yield worlds


@pytest.fixture
def worlds(opened):
    """Three worlds at their start, whose masts turn at `SPEEDS`."""
    opened.reset()
    opened.drive(velocities=np.array(SPEEDS, np.float32))
    return opened


def run(worlds, updates):
    """Steps the worlds; returns each world's ranges and joint positions."""
    for _ in range(updates):
        worlds.step()
    return worlds.lidars[LIDAR].channels.distance.numpy().copy(), worlds.coordinates.numpy().copy()


def test_a_world_of_many_is_the_world_alone_and_repeats(worlds, file, device):
    """On the processor to the bit; on a card to 1e-4, for it adds in no fixed order."""
    most = 1e-4 if worlds.device.is_cuda else 0.0
    ranges, places = run(worlds, 13)
    with Worlds(file, count=1, device=device, channels=["distance"]) as alone:
        alone.drive(velocities=np.array(SPEEDS[:1], np.float32))
        one, place = run(alone, 13)
    assert one[0].max() > 1
    assert np.abs(one[0] - ranges[0]).max() <= most
    assert np.abs(place[0] - places[0]).max() <= most
    assert not np.array_equal(ranges[0], ranges[1])
    assert not np.array_equal(ranges[1], ranges[2])
    worlds.reset()
    worlds.drive(velocities=np.array(SPEEDS, np.float32))
    again, there = run(worlds, 13)
    assert np.abs(again - ranges).max() <= most
    assert np.abs(there - places).max() <= most


def test_scans_come_at_their_exact_times_and_begin_again_after_a_reset(worlds):
    """10 Hz at 60 updates a second: the scan of tick k covers [(k - 1) / 10, k / 10), in update 6 k. World 1, reset
    after update 9, is at its first scan after update 15, when the others are at their second."""
    lidar = worlds.lidars[LIDAR]
    run(worlds, 5)
    assert lidar.frame_id.tolist() == [-1, -1, -1]
    run(worlds, 1)
    assert (lidar.frame_id.tolist(), lidar.stamp_ns.tolist()) == ([0, 0, 0], [0, 0, 0])
    _, driven = run(worlds, 3)
    worlds.reset([False, True, False])
    places = worlds.coordinates.numpy()
    assert not np.array_equal(places[1], driven[1])
    assert np.array_equal(places[[0, 2]], driven[[0, 2]])
    run(worlds, 6)
    assert lidar.frame_id.tolist() == [1, 0, 1]
    assert lidar.stamp_ns.tolist() == [100_000_000, 0, 100_000_000]
    assert worlds.steps.tolist() == [15, 6, 15]


def test_masks_and_targets_are_taken_from_other_libraries_and_lists(worlds):
    """A mask like a tensor of torch on a card: NumPy cannot read it, its method `cpu` copies it. Targets: a list."""

    class Tensor:
        def cpu(self):
            return np.array([True, False, True])

        def __array__(self, *_):
            raise TypeError("it is on a card")

    run(worlds, 2)
    worlds.reset(Tensor())
    assert worlds.steps.tolist() == [0, 2, 0]
    worlds.drive(velocities=SPEEDS)
    wide = np.array(SPEEDS, np.float64)
    members = {name: getattr(wide, name) for name in ("shape", "__dlpack__", "__dlpack_device__")}
    with pytest.raises(UserError, match="float32"):
        worlds.drive(velocities=type("Shared", (), members)())


def test_the_first_scan_is_that_of_an_app(worlds, file):
    """The world whose mast stands against the same file in an App: a ball that falls for 0.1 s, to a millimetre."""
    ranges, _ = run(worlds, 6)
    seen = seen_by_an_app(file, 0)
    assert len(seen) == np.count_nonzero(ranges[1])
    assert np.abs(ranges[1][ranges[1] > 0] - seen).max() < 1e-3


def test_wrong_shapes_counts_and_rates_are_refused_in_a_line(worlds, file, device):
    with pytest.raises(UserError, match="count 0 is not above 0"):
        Worlds(file, count=0, device=device)
    with pytest.raises(UserError, match="for one world on the processor use App"):
        Worlds(file, count=2, device="cpu")
    with pytest.raises(UserError, match="must be a multiple of the loop's"):
        Worlds(file, count=2, device=device, fidelity={"physics.hz": 100})
    with pytest.raises(UserError, match=r"shape \(3, 3\); give \(3, 1\)"):
        worlds.drive(velocities=np.zeros((3, 3), np.float32))
    with pytest.raises(UserError, match="one value for each of 3 worlds"):
        worlds.reset([True])


def test_each_world_is_the_file_run_with_its_own_seed(device, tmp_path):
    """Poses of a body and of what stands, a mass, a mounting error and a drive's gain differ by world."""
    file = tmp_path / "random.yaml"
    file.write_text(WORLD + RANDOM)
    with Worlds(file, count=3, seed=5, device=device, channels=["distance"]) as worlds:
        assert [one["/World/Ball.mass"] for one in worlds.drawn] == [
            parse("uniform(0.5, 2)").draw(Stream(seed, "randomize /World/Ball.mass")) for seed in (5, 6, 7)
        ]
        ball = worlds.app.physics.body_paths.index("/World/Ball") + 1
        masses = worlds.physics.model.body_mass.numpy()[:, ball]
        assert masses == pytest.approx([one["/World/Ball.mass"] for one in worlds.drawn])
        ranges, places = run(worlds, 6)
        for world in range(3):
            seen = seen_by_an_app(file, 5 + world)
            assert len(seen) == np.count_nonzero(ranges[world])
            assert np.abs(ranges[world][ranges[world] > 0] - seen).max() < 1e-3
        worlds.reset()
        again, there = run(worlds, 6)
        assert np.abs(again - ranges).max() < 1e-4
        assert np.abs(there - places).max() < 1e-4


def test_what_hangs_on_bodies_that_nothing_moves_stands_where_the_app_has_it(device, tmp_path):
    """Without a dynamic body there is no physics: a kinematic wall, drawn by world, before a kinematic mast."""
    file = tmp_path / "still.yaml"
    held = "attributes: {'physics:kinematicEnabled': true}"
    text = f"""\
tickgraph: 1
scene:
  prims:
    /World/Wall: {{type: Cube, translate: [3, 1, 0.5], rotate: [0, 0, 20], rigid_body: true, {held}}}
    /World/Mast: {{translate: [0.5, 0, 0.25], rotate: [0, 0, 45], rigid_body: true, {held}}}
    /World/Mast/lidar: {{type: OmniLidar, config: Example_Rotary_2D, translate: [0.2, 0, 0]}}
randomize:
  /World/Wall.translate: uniform([3, 1, 0.5], [4, 2, 0.5])
  /World/Mast.translate: uniform([0, 0, 0.25], [0.5, 0, 0.25])
"""
    file.write_text(text)
    with Worlds(file, count=2, device=device, channels=["distance"]) as worlds:
        assert worlds.physics is None
        for _ in range(6):
            worlds.step()
        ranges = worlds.lidars[LIDAR].channels.distance.numpy()
    for world in range(2):
        seen = seen_by_an_app(file, world)
        assert len(seen) == np.count_nonzero(ranges[world]) > 100
        assert np.abs(ranges[world][ranges[world] > 0] - seen).max() < 1e-5


def test_lidars_that_worlds_would_measure_otherwise_are_refused(tmp_path):
    file = tmp_path / "other.yaml"
    keys = "config: Example_Rotary_2D, attributes: {'omni:sensor:Core:outputFrameOfReference': WORLD}"
    for text, why in (
        (WORLD.replace("config: Example_Rotary_2D", keys), "its frame of reference is WORLD"),
        (WORLD.replace("translate: [3, 1, 0.5]", "translate: [3, 1, 0.5], material: clear_glass"), "glass"),
    ):
        file.write_text(text)
        with pytest.raises(UserError, match=f"worlds: {LIDAR} cannot be scanned in many worlds: .*{why}"):
            Worlds(file, count=2, device="warp-cpu")


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("/World/Ball.copies: integers(1, 9)", "worlds share their bodies and shapes"),
        ("/World/Ball.radius: uniform(0.1, 0.3)", "it changes the shape of /World/Ball"),
        ("/World/Wall.scale: uniform(1, 2)", "it changes the shape of /World/Wall"),
        ("/World/Wall.material: choice(steel, concrete, wood, glass)", "it changes the material of surfaces"),
        ("/World/Mast/lidar.config: choice(Example_Rotary_2D, RPLIDAR_S2E)", "it changes the lidar /World/Mast/lidar"),
    ],
)
def test_what_cannot_differ_between_worlds_is_refused_by_name(line, why, tmp_path):
    file = tmp_path / "random.yaml"
    file.write_text(f"{WORLD}randomize:\n  {line}\n")
    name = line.partition(":")[0]
    with pytest.raises(UserError) as caught:
        Worlds(file, count=8, seed=1, device="warp-cpu")
    assert str(caught.value).startswith(f"{file}:{len(WORLD.splitlines()) + 2}:3: randomize: {name}: {why}")


def test_what_worlds_do_not_do_is_named_once(tmp_path):
    """A graph, a camera, a ball of limited speed, a gate with time samples, and a drawn value that only the camera
    would show."""
    file = tmp_path / "more.yaml"
    more = "    /World/Eye: {type: Camera, translate: [0, 0, 1]}\n"
    text = WORLD.replace("clock:", f"{more}clock:").replace(
        "mass: 1.0}", "mass: 1.0, attributes: {'physxRigidBody:maxLinearVelocity': 3.0}}"
    )
    gate = tmp_path / "gate.usda"
    gate.write_text(GATE)
    text = text.replace("scene:\n", "scene:\n  usd: gate.usda\n")
    graph = "graphs:\n  /World/G:\n    nodes:\n      tick: OnPlaybackTick\n"
    file.write_text(f"{text}randomize:\n  /World/Eye.translate: uniform([0, 0, 1], [1, 1, 2])\n{graph}")
    with Worlds(file, count=2, device="warp-cpu", channels=["distance"]) as worlds:
        told = {one.code: one.where for one in worlds.app.warnings if one.code.endswith("-in-worlds")}
    assert told == {
        "randomize-not-in-worlds": "/World/Eye.translate",
        "graphs-not-in-worlds": "/World/G",
        "sensors-not-in-worlds": "/World/Eye",
        "animations-not-in-worlds": "/World/Gate",
        "physics-not-in-worlds": "greatest speeds",
    }
