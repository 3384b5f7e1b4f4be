"""Attributes of PhysX, Newton and MuJoCo can be written in a graph file, and act as those of a USD file do."""

import pytest

from graph.base.errors import UserError
from graph.sim import App
from graph.sim.scene import unregistered
from graph.sim.scene.physics_settings import SIMULATED
from graph.sim.scene.prims import author_prims
from graph.sim.scene.stage import open_stage
from tests.stability.case import NO_GRAVITY, world

SOLVER = "physxRigidBody:solverPositionIterationCount"
BALL = {"type": "Sphere", "radius": 0.1, "rigid_body": True, "collision": False, "mass": 2.0}


def speed(attributes, hz=240, prims=NO_GRAVITY, **keys):
    """The velocity of a ball after 1 s."""
    physics = world({**prims, "/Ball": {**BALL, "attributes": attributes, **keys}}, hz, {})
    physics.step(hz)
    return physics.velocities()[0]


def test_damping_of_a_body():
    """v' = -d v, implicit: (1 + d dt)^-n."""
    motion = speed({"physxRigidBody:linearDamping": 2.0}, velocity=[3.0, 0, 0])
    assert motion[0] == pytest.approx(3 * (1 + 2 / 240) ** -240, rel=1e-6)


def test_a_force_on_a_body_and_a_limit_of_its_speed():
    """6 N on 2 kg for 1 s: 3 m/s; at most 1.5 m/s."""
    force = {"physxForce:force": [6.0, 0, 0], "physxForce:worldFrameEnabled": True, "physxForce:mode": "force"}
    assert speed(force)[0] == pytest.approx(3.0)
    assert speed({**force, "physxRigidBody:maxLinearVelocity": 1.5})[0] == pytest.approx(1.5)


def test_a_body_without_gravity_and_a_locked_axis():
    assert speed({"physxRigidBody:disableGravity": True}, prims={})[2] == 0
    motion = speed({"physxRigidBody:lockedPosAxis": 1}, velocity=[3.0, 2.0, 0])
    assert motion[:2] == pytest.approx([0, 2])


def test_a_belt_carries_what_lies_on_it():
    belt = {"type": "Cube", "size": 1, "scale": [4, 1, 0.2], "rigid_body": True}
    velocity = {"physxSurfaceVelocity:surfaceVelocity": [0.5, 0, 0]}
    belt |= {"attributes": {"physics:kinematicEnabled": True, **velocity}}
    box = {"type": "Cube", "size": 0.2, "rigid_body": True, "translate": [-1, 0, 0.2]}
    physics = world({"/Belt": belt, "/Box": box}, 240, {})
    physics.step(240)
    assert physics.velocities()[physics.body_paths.index("/Box"), 0] == pytest.approx(0.5, abs=1e-3)


def test_dry_friction_of_a_joint_with_an_instance_and_a_follower():
    axle = {"physics:body1": "/A", "physics:axis": "Z", "physxJointAxis:angular:viscousFrictionCoefficient": 0.0}
    gear = {"physics:body1": "/B", "physics:axis": "Z", "physics:localPos0": [1, 0, 0]}
    gear |= {"physxMimicJoint:rotZ:referenceJoint": "/Axle", "physxMimicJoint:rotZ:gearing": 2.0}
    wheel = {**BALL, "attributes": {"physics:diagonalInertia": [0.01, 0.01, 0.01]}}
    prims = {"/A": {**wheel, "angular_velocity": [0, 0, 90]}, "/B": {**wheel, "translate": [1, 0, 0]}}
    prims["/Axle"] = {"type": "PhysicsRevoluteJoint", "attributes": axle}
    prims["/Gear"] = {"type": "PhysicsRevoluteJoint", "attributes": gear}
    assert world(NO_GRAVITY | prims, 240, {}).world.mimics[0].leader == "/Axle"


def test_settings_of_the_scene():
    scene = {"type": "PhysicsScene", "schemas": "PhysxSceneAPI", "attributes": {"physxScene:timeStepsPerSecond": 120}}
    with App() as app:
        app.add_prims({"/Scene": scene, "/Ball": BALL})
        counted = []
        app.on("physics_post_step", lambda: counted.append(1))
        app.play()
        app.update(steps=60)
        assert len(counted) == 120


def test_an_attribute_brings_its_schema_and_the_type_of_a_usd_file():
    stage = open_stage()
    author_prims(stage, {"/Ball": {**BALL, "attributes": {"physxRigidBody:linearDamping": 1}}})
    prim = stage.GetPrimAtPath("/Ball")
    assert "PhysxRigidBodyAPI" in prim.GetPrimTypeInfo().GetAppliedAPISchemas()
    attribute = prim.GetAttribute("physxRigidBody:linearDamping")
    assert (str(attribute.GetTypeName()), attribute.IsCustom()) == ("float", False)


@pytest.mark.parametrize("name", sorted(name for name in SIMULATED if not name.startswith("physics:")))
def test_every_simulated_name_can_be_written(name):
    assert unregistered.value_type(name.replace("*", "angular"), 1.0)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("physxRigidBody:linearDampin", "physxRigidBody:linearDamping"),
        ("physxScene:timeStepPerSecond", "physxScene:timeStepsPerSecond"),
        ("physxSurfaceVelocity:surfaceVelocities", "physxSurfaceVelocity:surfaceVelocity"),
        ("newton:velocityLimits", "newton:velocityLimit"),
    ],
)
def test_an_unknown_name_is_refused_with_the_one_that_was_meant(name, meant):
    with pytest.raises(UserError, match=f'has no attribute .*did you mean "{meant}"'):
        author_prims(open_stage(), {"/Ball": {**BALL, "attributes": {name: 1.0}}})


@pytest.mark.parametrize("schema", ["PhysxRigidBodyAPIs", "PhysxNoneAPI", "PhysxJointAxisAPI", "PhysxSceneAPI:a"])
def test_an_unknown_schema_and_a_wrong_instance_are_refused(schema):
    with pytest.raises(UserError, match=r"schema|applied"):
        author_prims(open_stage(), {"/Ball": {**BALL, "schemas": schema}})


def test_a_value_of_the_wrong_kind_is_refused():
    with pytest.raises(UserError, match="physxForce:force"):
        author_prims(open_stage(), {"/Ball": {**BALL, "attributes": {"physxForce:force": 3.0}}})


def test_what_is_known_and_not_simulated_is_kept_with_a_warning():
    with App() as app:
        app.add_prims({"/Ball": {**BALL, "collision": True, "attributes": {SOLVER: 8}}})
        app.play()
        assert [warning.code for warning in app.warnings] == ["physics-setting-stored"]
