"""The model itself is what is simulated: step for step MuJoCo's own result, alone and with prims added to it."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from graph.base.errors import UserError
from graph.cli.main import main
from graph.sim import App
from graph.sim.physics.mujoco.library import mujoco
from graph.sim.scene.prims import author_prims


def reference(file, steps, key=None, ctrl=None):
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    if key is not None:
        mujoco.mj_resetDataKeyframe(model, data, key)
    if ctrl is not None:
        data.ctrl[:] = ctrl
    for _ in range(steps):
        mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    return model, data


def mirrored(app, model, data):
    """Where Fabric has each body's prim, and where MuJoCo has the body: (n, 4, 4) both."""
    paths = app.mjcf.paths.bodies[1:]
    poses = np.zeros((len(paths), 4, 4))
    poses[:, 3, 3] = 1
    for number in range(len(paths)):
        poses[number, :3, :3] = data.xmat[number + 1].reshape(3, 3)
        poses[number, :3, 3] = data.xpos[number + 1]
    return app.fabric.world_matrices(paths), poses


def test_mirrored_poses_are_mujocos_after_a_thousand_steps(quadruped):
    model, data = reference(quadruped, 1000)
    with App(mjcf=quadruped) as app:
        app.play()
        app.simulation.run_steps(1000)
        ours, theirs = mirrored(app, model, data)
        assert np.abs(ours - theirs).max() <= 1e-12
        assert np.array_equal(app.physics.data.qpos, data.qpos)


def test_a_keyframe_is_where_it_starts_before_and_after_play(quadruped):
    model, data = reference(quadruped, 0, key=0)
    from wings.mjcf.scene import open_mjcf

    with App(mjcf=open_mjcf(quadruped, keyframe="home")) as app:
        assert np.abs(np.subtract(*mirrored(app, model, data))).max() <= 1e-12
        app.play()
        assert np.array_equal(app.physics.data.qpos, model.key_qpos[0])
        assert np.array_equal(app.physics.data.ctrl, model.key_ctrl[0])
        model, data = reference(quadruped, 300, key=0)
        app.simulation.run_steps(300)
        assert np.abs(np.subtract(*mirrored(app, model, data))).max() <= 1e-12


def test_an_unknown_keyframe_is_reported_with_those_there_are(quadruped):
    from wings.mjcf.scene import open_mjcf

    with pytest.raises(UserError, match=r"has no keyframe 'hme'; it has home"):
        open_mjcf(quadruped, keyframe="hme")


def test_stop_restores_the_stage_and_play_repeats_to_the_byte(quadruped):
    with App(mjcf=quadruped) as app:
        before = [layer.ExportToString() for layer in app.stage.GetUsedLayers()]
        runs = []
        for _ in range(2):
            app.play()
            app.update(steps=50)
            runs.append(app.physics.data.qpos.tobytes() + app.physics.data.qvel.tobytes())
            app.stop()
            assert [layer.ExportToString() for layer in app.stage.GetUsedLayers()] == before
        assert runs[0] == runs[1]


def test_the_models_time_step_beats_the_default_and_is_beaten_by_physics_hz(quadruped):
    with App(mjcf=quadruped) as app:
        assert app.simulation.steps_per_second == 250
    with App(mjcf=quadruped, physics_hz=100) as app:
        app.play()
        assert app.physics.model.opt.timestep == 0.01


def test_a_time_step_of_three_milliseconds_is_exactly_that(model):
    body = "<worldbody><body><freejoint/><geom size='.1'/></body></worldbody>"
    with App(mjcf=model(f"<option timestep='0.003'/>{body}")) as app:
        assert app.simulation.steps_per_second == Fraction(1000, 3)


def test_integrator_and_cone_stay_the_models_unless_a_knob_says_otherwise(quadruped):
    with App(mjcf=quadruped) as app:
        app.play()
        assert app.physics.model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        assert app.physics.model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    with App(mjcf=quadruped, fidelity={"physics.integrator": "euler"}) as app:
        app.play()
        assert app.physics.model.opt.integrator == mujoco.mjtIntegrator.mjINT_EULER
        assert app.physics.model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC


def test_prims_added_far_away_change_nothing_of_the_model(quadruped):
    """The quadruped's class defaults, degrees, total mass and masses from geoms reach nothing that is added."""
    model, data = reference(quadruped, 200)
    with App(mjcf=quadruped) as app:
        box = {"type": "Cube", "size": 1.0, "translate": [50, 0, 100], "rigid_body": True}
        author_prims(app.stage, {"/World/Box": box})
        app.play()
        own = app.physics.model
        assert own.body("/World/Box").mass[0] == pytest.approx(1000, rel=1e-12)
        geom = own.geom("/World/Box#0")
        assert geom.contype[0] == geom.conaffinity[0] == 1
        for number in range(1, model.nbody):
            name = app.mjcf.model.body(number).name
            assert own.body(name).mass[0] == pytest.approx(model.body_mass[number], rel=1e-12)
        app.simulation.run_steps(200)
        ours, theirs = mirrored(app, model, data)
        assert np.abs(ours - theirs).max() < 1e-7
        fallen = 9.81 * 0.004**2 * 200 * 201 / 2
        assert app.fabric.world_matrix("/World/Box")[2, 3] == pytest.approx(100 - fallen, abs=1e-9)


def test_what_is_added_collides_with_the_model_and_hangs_on_its_bodies(quadruped):
    """A plate rests on the post; a bob hangs from the arm by a joint with its own limits, in degrees on the stage."""
    prims = {
        "/World/Plate": {"type": "Cube", "size": 0.2, "translate": [2, 0, 1.5], "rigid_body": True},
        "/World/Bob": {"type": "Sphere", "radius": 0.05, "translate": [-1.48, 1.3, 0.8], "rigid_body": True},
        "/World/Pin": {
            "type": "PhysicsRevoluteJoint",
            "attributes": {
                "physics:body0": "/World/arm",
                "physics:body1": "/World/Bob",
                "physics:axis": "Y",
                "physics:localPos0": [0.6, 0, 0],
                "physics:localPos1": [0, 0, 0.3],
                "physics:lowerLimit": -10.0,
                "physics:upperLimit": 10.0,
            },
        },
    }
    with App(mjcf=quadruped) as app:
        author_prims(app.stage, prims)
        app.play()
        limits = app.physics.model.joint("/World/Pin").range
        assert limits == pytest.approx(np.radians([-10, 10]), rel=1e-6)
        app.simulation.run_steps(500)
        assert app.fabric.world_matrix("/World/Plate")[2, 3] == pytest.approx(1.2, abs=5e-3)
        arm, bob = app.fabric.world_matrices(("/World/arm", "/World/Bob"))
        tip = arm @ [0.6, 0, 0, 1]
        assert np.linalg.norm((bob @ [0, 0, 0.3, 1])[:3] - tip[:3]) < 1e-3


def test_a_root_that_is_placed_takes_the_whole_robot_along(quadruped):
    shifted = np.array([1.0, -2.0, 0.5])
    with App(mjcf=quadruped) as app:
        home = app.fabric.world_matrices(app.mjcf.paths.bodies[1:])
        place = {"translate": [1.0, -2.0, 1.3]}  # the model has it at 0, 0, 0.8
        post = {"translate": [-2, 1, 3]}
        author_prims(app.stage, {"/World/torso": place, "/World/post": post})
        app.play()
        now = dict(zip(app.mjcf.paths.bodies[1:], app.fabric.world_matrices(app.mjcf.paths.bodies[1:]), strict=True))
        for path, before in zip(app.mjcf.paths.bodies[1:], home, strict=True):
            root = app.mjcf.model.body_rootid[app.mjcf.paths.bodies.index(path)]
            moved = {"/World/torso": shifted, "/World/post": np.array([0, 0, 3.0])}
            expected = before[:3, 3] + moved.get(app.mjcf.paths.bodies[root], np.zeros(3))
            assert now[path][:3, 3] == pytest.approx(expected, abs=1e-12)
        assert app.physics.data.qpos[:3] == pytest.approx([1.0, -2.0, 1.3])


def test_a_body_on_a_joint_cannot_be_placed(quadruped):
    with App(mjcf=quadruped) as app:
        author_prims(app.stage, {"/World/arm": {"translate": [0, 0, 9]}})
        app.play()
        assert app.fabric.world_matrix("/World/arm")[:3, 3] == pytest.approx([-2, 1, 1.1])
        assert any(
            code == "mjcf-body-held" and where == "/World/arm"
            for code, where in ((w.code, w.where) for w in app.warnings)
        )


OVERLAPPING = """<mujoco><worldbody>
<geom name="floor" type="plane" size="5 5 .1"/>
<body name="crate" pos="0 0 0.05"><freejoint/><geom type="box" size=".2 .2 .2"/><geom name="lid" size=".1" pos="0 0 2"/>
</body></worldbody></mujoco>"""


@pytest.mark.parametrize("added", [False, True])
def test_contacts_name_the_prims_of_geoms_and_so_do_overlaps(tmp_path, added):
    # The crate's lower side is at 0.05 - 0.2 = -0.15 m. What is added comes behind the model's own geoms and bodies.
    (tmp_path / "m.xml").write_text(OVERLAPPING)
    box = "/World/Box: {type: Cube, size: 0.4, translate: [3, 0, 0.19], rigid_body: true}"
    prims = f"  prims: {{{box}}}\n" if added else ""
    (tmp_path / "m.yaml").write_text(f"tickgraph: 1\nscene:\n  mjcf: m.xml\n{prims}")
    with App.from_file(tmp_path / "m.yaml") as app:
        app.play()
        found = app.physics.contacts()
        pairs = {("/World/floor", "/World/crate/geom1")} | ({("/World/floor", "/World/Box")} if added else set())
        assert set(found.pairs) == pairs
        [told] = [one for one in app.warnings if one.code == "bodies-overlap"]
        assert (told.where, told.message.partition(" when")[0]) == (
            "/World/crate",
            "it and /World/floor overlap by 0.15 m",
        )


CROWD = "".join(
    f'<body pos="{i % 40} {i // 40} 0.2"><freejoint/><geom type="box" size=".1 .1 .1"/></body>' for i in range(1200)
)


def test_a_crowd_of_boxes_gets_memory_for_its_contacts_and_too_little_is_one_line(tmp_path, capsys):
    """MuJoCo's own estimate for 1,200 free boxes is several GiB; with 1 MiB it cannot even look for contacts."""
    (tmp_path / "g.json").write_text('{"tickgraph": 1, "scene": {"mjcf": "m.xml"}}')
    for size, code, said in (("", 0, ""), ('<size memory="1M"/>', 2, "1 MiB for the contacts of 1,200 bodies")):
        world = f'<worldbody><geom type="plane" size="50 50 1"/>{CROWD}</worldbody>'
        (tmp_path / "m.xml").write_text(f"<mujoco>{size}{world}</mujoco>")
        assert main(["run", str(tmp_path / "g.json"), "--updates", "1"]) == code
        error = capsys.readouterr().err
        assert said in error
        assert error.count("\n") == (code > 0), error
