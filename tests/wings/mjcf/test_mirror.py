"""What stands on the stage for a model: names, types, poses, looks."""

from __future__ import annotations

import numpy as np
import pytest

from graph.sim import App
from graph.sim.physics.mujoco.library import mujoco
from graph.sim.usd import UsdGeom, UsdPhysics


def test_bodies_lie_side_by_side_and_carry_their_parts(opened, quadruped):
    from wings.mjcf.scene import open_mjcf

    scene = open_mjcf(quadruped)
    kinds = {str(prim.GetPath()): str(prim.GetTypeName()) for prim in scene.stage.Traverse()}
    expected = {
        "/World/torso": "Xform",
        "/World/torso/imu": "Xform",
        "/World/knee_1/foot_1": "Mesh",
        "/World/knee_1/knee_1": "PhysicsRevoluteJoint",
        "/World/right_hip_0": "Xform",
        "/World/hills": "Mesh",
        "/World/lift": "Xform",
        "/World/arm/swing": "PhysicsRevoluteJoint",
        "/World/Actuators/spin": "MjcActuator",
        "/World/Sensors/felt": "Scope",
        "/World/Looks/shell": "Material",
        "/World/PhysicsScene": "PhysicsScene",
    }
    assert {path: kinds.get(path) for path in expected} == expected
    assert scene.stage.GetPrimAtPath("/World/right_hip_0").GetAttribute("isaac:nameOverride").Get() == "right hip_0"


@pytest.mark.parametrize(
    ("name", "prim"), [("a b/c", "a_b_c"), ("1st", "_1st"), ("ä", "_"), ("", "body0"), ("World", "World")]
)
def test_names_become_those_that_prims_may_have(opened, name, prim):
    scene, _ = opened(f"<worldbody><body name='{name}'><geom size='1'/></body></worldbody>")
    assert scene.stage.GetPrimAtPath(f"/World/{prim}") or scene.paths.bodies[1].startswith("/World/body")


def test_equal_names_are_distinguished_bodies_first(opened):
    text = (
        "<worldbody><geom name='x' size='1'/><site name='x'/><body name='x'><joint name='x'/><geom name='xx' size='1'/>"
    )
    scene, _ = opened(text + "<site name='xx'/></body><body name='x.'/><body name='x,'/></worldbody>")
    assert scene.paths.bodies[1:] == ("/World/x", "/World/x_", "/World/x__1")
    assert scene.paths.geoms == ("/World/x_1", "/World/x/xx")
    assert scene.paths.joints == ("/World/x/x",)
    assert scene.paths.sites == ("/World/x_2", "/World/x/xx_1")


def test_what_moves_is_a_rigid_body_and_what_is_driven_by_hand_a_kinematic_one(quadruped):
    from wings.mjcf.scene import open_mjcf

    stage = open_mjcf(quadruped).stage
    moving = {p.GetName() for p in stage.Traverse() if p.HasAPI(UsdPhysics.RigidBodyAPI)}
    assert moving == {
        *("torso", "hip_0", "knee_0", "right_hip_0", "hip_1", "knee_1", "right_hip_1", "lift", "arm", "ball"),
    }
    assert stage.GetPrimAtPath("/World/lift").GetAttribute("physics:kinematicEnabled").Get() is True
    roots = {p.GetName() for p in stage.Traverse() if p.HasAPI(UsdPhysics.ArticulationRootAPI)}
    assert roots == {"torso", "post", "ball"}


def test_a_mocap_body_is_moved_by_hand(quadruped):
    with App(mjcf=quadruped) as app:
        app.play()
        matrix = np.eye(4)
        matrix[:3, 3] = 3, 2, 1
        app.fabric.set_world_matrix("/World/lift", matrix)
        app.simulation.run_steps(10)
        assert app.fabric.world_matrix("/World/lift")[:3, 3] == pytest.approx([3, 2, 1])


def test_geoms_have_the_sizes_of_usd(opened):
    scene, _ = opened(
        "<worldbody><geom name='box' type='box' size='1 2 3'/><geom name='egg' type='ellipsoid' size='1 2 3'/>"
        "<geom name='pill' type='capsule' size='.1 .5' rgba='1 0 0 .5'/><geom name='tin' type='cylinder' size='.1 .5'/>"
        "<geom name='sheet' type='plane' size='2 3 .1'/><geom name='ground' type='plane' size='0 0 .1'/></worldbody>"
    )

    def extent(name):
        prim = scene.stage.GetPrimAtPath(f"/World/{name}")
        cache = UsdGeom.BBoxCache(0, ["default"])
        return list(cache.ComputeWorldBound(prim).ComputeAlignedRange().GetSize())

    assert extent("box") == pytest.approx([2, 4, 6])
    assert extent("egg") == pytest.approx([2, 4, 6])
    assert extent("pill") == pytest.approx([0.2, 0.2, 1.2])
    assert extent("tin") == pytest.approx([0.2, 0.2, 1.0])
    assert extent("sheet") == pytest.approx([4, 6, 0])
    assert not scene.stage.GetPrimAtPath("/World/ground").GetAttribute("width").HasAuthoredValue()
    pill = scene.stage.GetPrimAtPath("/World/pill")
    assert list(pill.GetAttribute("primvars:displayColor").Get()[0]) == [1, 0, 0]
    assert list(pill.GetAttribute("primvars:displayOpacity").Get()) == [0.5]


def test_a_camera_has_the_models_angle_of_view(opened):
    """fovy 60 degrees: 2 atan(aperture / (2 focal length)) of the vertical aperture."""
    scene, _ = opened("<worldbody><camera name='eye' fovy='60' pos='1 2 3' resolution='640 480'/></worldbody>")
    camera = UsdGeom.Camera(scene.stage.GetPrimAtPath("/World/eye"))
    tall, wide = camera.GetVerticalApertureAttr().Get(), camera.GetHorizontalApertureAttr().Get()
    assert 2 * np.degrees(np.arctan(tall / 2 / camera.GetFocalLengthAttr().Get())) == pytest.approx(60, rel=1e-6)
    assert wide / tall == pytest.approx(640 / 480, rel=1e-6)


def test_joints_say_their_axis_ends_and_limits(opened):
    scene, _ = opened(
        "<worldbody><body name='a' pos='0 0 1'><geom size='.1'/><body name='b' pos='1 0 0' euler='0 0 90'>"
        "<joint name='j' type='hinge' axis='0 1 1' pos='.1 .2 .3' range='-30 60' limited='true'/><geom size='.1'/>"
        "</body></body></worldbody>"
    )
    joint = UsdPhysics.RevoluteJoint(scene.stage.GetPrimAtPath("/World/b/j"))
    assert (joint.GetLowerLimitAttr().Get(), joint.GetUpperLimitAttr().Get()) == pytest.approx((-30, 60))
    assert [str(path) for path in joint.GetBody0Rel().GetTargets()] == ["/World/a"]
    assert list(joint.GetLocalPos1Attr().Get()) == pytest.approx([0.1, 0.2, 0.3])
    assert list(joint.GetLocalPos0Attr().Get()) == pytest.approx([1 - 0.2, 0.1, 0.3])  # turned by 90 degrees
    from pxr import Gf

    turn = Gf.Rotation(Gf.Quatd(joint.GetLocalRot1Attr().Get()))
    assert list(turn.TransformDir(Gf.Vec3d(1, 0, 0))) == pytest.approx([0, np.sqrt(0.5), np.sqrt(0.5)], abs=1e-6)


def test_keys_that_the_model_decides_are_reported(quadruped, tmp_path):
    (tmp_path / "g.yaml").write_text(
        "tickgraph: 1\nscene:\n  mjcf: scene.xml\n  prims:\n    /World/torso: {mass: 3.0, rigid_body: true}\n"
        "    /World/torso/Lidar: {type: OmniLidar, config: Example_Rotary, translate: [0, 0, 0.2]}\n"
    )
    with App.from_file(tmp_path / "g.yaml") as app:
        told = {(w.code, w.where): w.message for w in app.warnings}
        assert "rigid_body, mass" in told["mjcf-key-ignored", "/World/torso"]
        app.play()
        lidar, torso = app.fabric.world_matrices(("/World/torso/Lidar", "/World/torso"))
        assert lidar[:3, 3] == pytest.approx((torso @ [0, 0, 0.2, 1])[:3])


def test_points_of_cloth_are_where_mujoco_has_its_vertices(opened, model):
    """Cloth that falls, and a block whose vertices hang on nodes: the points of now and of a state captured before."""
    text = (
        "<worldbody><flexcomp name='cloth' type='grid' dim='2' count='4 4 1' spacing='.1 .1 .1' radius='.01' mass='1' "
        "pos='0 0 1'><edge equality='true'/></flexcomp><flexcomp name='block' type='grid' dim='3' count='3 3 3' "
        "spacing='.1 .1 .1' radius='.01' mass='1' pos='2 0 1' dof='trilinear'><elasticity young='1e4' poisson='.2'/>"
        "</flexcomp></worldbody>"
    )
    scene, _ = opened(text)
    assert scene.stage.GetPrimAtPath("/World/cloth").GetTypeName() == "Mesh"
    with App(mjcf=model(text, "soft.xml")) as app:
        app.play()
        before = app.fabric.capture()
        app.simulation.run_steps(100)
        physics = app.physics
        mujoco.mj_forward(physics.model, physics.data)
        for number, path in enumerate(("/World/cloth", "/World/block")):
            first = physics.model.flex_vertadr[number]
            here = physics.data.flexvert_xpos[first : first + physics.model.flex_vertnum[number]]
            assert np.abs(app.fabric.capture().points(path) - here).max() < 1e-12
            mesh = np.array(app.stage.GetPrimAtPath(path).GetAttribute("points").Get())
            assert np.abs(before.points(path) - mesh).max() < 1e-6
            fallen = 9.81 * 0.002**2 * 100 * 101 / 2
            assert (before.points(path) - here)[:, 2].mean() == pytest.approx(fallen, rel=1e-6)


LIT = """<mujoco><visual><headlight active="0"/></visual><statistic center="0 0 0"/>
<worldbody><camera name="eye" pos="0 0 1" fovy="10" resolution="33 33"/><light {}/>
<geom type="plane" size="0 0 1" rgba="1 1 1 1"/></worldbody></mujoco>"""
WHITE = 1250.0
"""Nit that are white at 0.02 s and f/5."""


@pytest.mark.parametrize(
    ("light", "shown"),
    [
        # Diffuse 0.5, straight down: half of white, whatever the distance.
        ("name='sun' type='directional' pos='0 0 3' dir='0 0 -1' diffuse='.5 .5 .5'", 0.5),
        # Aside by 60 degrees: cos.
        ("name='sun' type='directional' pos='0 0 3' dir='1.7320508 0 -1' diffuse='1 1 1'", 0.5),
        # A point 2 m above the centre of the model, as bright there as MuJoCo's; attenuation 1 / (1 + 2^2 / 4).
        ("name='lamp' type='point' pos='0 0 2' diffuse='1 1 1'", 1.0),
        ("name='lamp' type='point' pos='0 0 2' diffuse='1 1 1' attenuation='1 0 .25'", 0.5),
        # 100 candela at 2 m: 25 lux, of which a white surface sends back 25 / pi nit.
        ("name='lamp' type='point' pos='0 0 2' diffuse='1 1 1' intensity='100'", 25 / np.pi / WHITE),
        # A spot whose axis is 30 degrees aside fades by cos^2; beyond its cone of 20 degrees it is dark.
        ("name='spot' type='spot' pos='0 0 2' dir='.57735027 0 -1' diffuse='1 1 1' exponent='2'", 0.75),
        ("name='spot' type='spot' pos='0 0 2' dir='.57735027 0 -1' diffuse='1 1 1' cutoff='20'", 0.0),
        ("name='off' type='directional' dir='0 0 -1' diffuse='1 1 1' active='false'", 0.0),
        ("name='dim' type='directional' dir='0 0 -1' diffuse='0 0 0' ambient='.25 .25 .25'", 0.25),
    ],
)
def test_lights_of_a_model_light_its_pictures_as_mujocos_would(model, light, shown):
    from sensors.replicator import get_annotator, render_product

    with App(mjcf=model(LIT.format(light))) as app:
        found = get_annotator("HdrColor", app=app).attach(render_product(app, "/World/eye", (33, 33)))
        app.play()
        app.update()
        assert found.get_data()[16, 16, 0] == pytest.approx(shown * WHITE, rel=1e-3)


def test_the_headlight_shines_from_each_camera(model):
    """Ambient 0.1 and diffuse 0.4 on a grey of 0.5, which is linear 0.21404: straight ahead (0.1 + 0.4) times that."""
    body = """<worldbody><camera name="eye" pos="0 0 1"/><camera name="aside" pos="1.7320508 0 1" euler="0 60 0"/>
    <geom type="plane" size="0 0 1" rgba=".5 .5 .5 1"/></worldbody>"""
    from sensors.replicator import get_annotator, render_product

    with App(mjcf=model(body)) as app:
        found = [
            get_annotator("HdrColor", app=app).attach(render_product(app, f"/World/{name}", (33, 33)))
            for name in ("eye", "aside")
        ]
        app.play()
        app.update()
        light = [each.get_data()[16, 16, 0] for each in found]
        assert "no-light" not in {warning.code for warning in app.warnings}
    grey = ((0.5 + 0.055) / 1.055) ** 2.4
    assert light == pytest.approx([0.5 * grey * WHITE, 0.3 * grey * WHITE], rel=2e-3)  # cos 60 degrees


def test_lights_follow_their_bodies_and_have_names(opened):
    scene, warnings = opened(
        "<worldbody><light name='sun'/><body name='b' pos='1 2 3'><geom size='1'/><light mode='targetbody' target='b'/>"
        "</body></worldbody>"
    )
    assert [str(prim.GetPath()) for prim in scene.stage.Traverse() if prim.GetTypeName() == "SphereLight"] == [
        "/World/b/light1",
        "/World/sun",
    ]
    assert [code for code, *_ in warnings] == ["mjcf-light-fixed"]
