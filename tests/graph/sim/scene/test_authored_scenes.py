"""Scenes as users of Isaac Sim author them, applied schemas of PhysX and Newton included."""

from __future__ import annotations

import math

import numpy as np
import pytest

from graph.sim import App

ARM = """#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    upAxis = "Z"
    kilogramsPerUnit = 1
)
def Xform "World"
{
    def PhysicsScene "physicsScene" (prepend apiSchemas = ["PhysxSceneAPI"])
    {
        vector3f physics:gravityDirection = (0, 0, -1)
        float physics:gravityMagnitude = 9.81
        token physxScene:solverType = "TGS"
        token physxScene:broadphaseType = "MBP"
        uint physxScene:timeStepsPerSecond = 120
    }
    def Plane "Ground" (prepend apiSchemas = ["PhysicsCollisionAPI", "MaterialBindingAPI"])
    {
        uniform token axis = "Z"
        rel material:binding:physics = </World/Rubber>
    }
    def Material "Rubber" (prepend apiSchemas = ["PhysicsMaterialAPI", "PhysxMaterialAPI"])
    {
        float physics:staticFriction = 1
        float physics:dynamicFriction = 0.8
        float physics:restitution = 0.5
        uniform token physxMaterial:frictionCombineMode = "max"
        uniform token physxMaterial:restitutionCombineMode = "max"
    }
    def Xform "Robot" (prepend apiSchemas = ["PhysicsArticulationRootAPI", "PhysxArticulationAPI"])
    {
        bool physxArticulation:enabledSelfCollisions = 0
        int physxArticulation:solverPositionIterationCount = 32
        def Xform "base_link" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysxRigidBodyAPI", "PhysicsMassAPI"])
        {
            float physics:mass = 4
            double3 xformOp:translate = (0, 0, 0.1)
            uniform token[] xformOpOrder = ["xformOp:translate"]
            def Cube "collisions" (prepend apiSchemas = ["PhysicsCollisionAPI"])
            {
                double size = 0.2
            }
        }
        def Xform "link1" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
        {
            float physics:mass = 1
            float3 physics:diagonalInertia = (0.01, 0.01, 0.002)
            point3f physics:centerOfMass = (0, 0, 0.15)
            double3 xformOp:translate = (0, 0, 0.2)
            uniform token[] xformOpOrder = ["xformOp:translate"]
            def Capsule "collisions" (prepend apiSchemas = ["PhysicsCollisionAPI"])
            {
                double radius = 0.04
                double height = 0.25
                double3 xformOp:translate = (0, 0, 0.15)
                uniform token[] xformOpOrder = ["xformOp:translate"]
            }
        }
        def Xform "left" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
        {
            float physics:mass = 0.05
            double3 xformOp:translate = (0, 0, 0.55)
            uniform token[] xformOpOrder = ["xformOp:translate"]
            def Cube "c" (prepend apiSchemas = ["PhysicsCollisionAPI"])
            {
                double size = 0.03
            }
        }
        def Xform "right" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
        {
            float physics:mass = 0.05
            double3 xformOp:translate = (0, 0, 0.55)
            uniform token[] xformOpOrder = ["xformOp:translate"]
            def Cube "c" (prepend apiSchemas = ["PhysicsCollisionAPI"])
            {
                double size = 0.03
            }
        }
        def PhysicsFixedJoint "root_joint"
        {
            rel physics:body1 = </World/Robot/base_link>
            point3f physics:localPos0 = (0, 0, 0.1)
        }
        def PhysicsRevoluteJoint "shoulder" (
            prepend apiSchemas = ["PhysicsDriveAPI:angular", "PhysxJointAPI", "PhysicsJointStateAPI:angular"]
        )
        {
            rel physics:body0 = </World/Robot/base_link>
            rel physics:body1 = </World/Robot/link1>
            point3f physics:localPos0 = (0, 0, 0.1)
            uniform token physics:axis = "Y"
            float physics:lowerLimit = -90
            float physics:upperLimit = 90
            float drive:angular:physics:stiffness = 1000
            float drive:angular:physics:damping = 100
            float drive:angular:physics:maxForce = 87
            float drive:angular:physics:targetPosition = 30
            float physxJoint:maxJointVelocity = 124.6
            float physxJoint:armature = 0.01
        }
        def PhysicsPrismaticJoint "finger1" (prepend apiSchemas = ["PhysicsDriveAPI:linear"])
        {
            rel physics:body0 = </World/Robot/link1>
            rel physics:body1 = </World/Robot/left>
            point3f physics:localPos0 = (0, 0, 0.35)
            uniform token physics:axis = "X"
            float physics:lowerLimit = 0
            float physics:upperLimit = 0.04
            float drive:linear:physics:stiffness = 1000
            float drive:linear:physics:damping = 50
            float drive:linear:physics:targetPosition = 0.02
        }
        def PhysicsPrismaticJoint "finger2" (prepend apiSchemas = ["NewtonMimicAPI"])
        {
            rel physics:body0 = </World/Robot/link1>
            rel physics:body1 = </World/Robot/right>
            point3f physics:localPos0 = (0, 0, 0.35)
            quatf physics:localRot0 = (0, 0, 0, 1)
            quatf physics:localRot1 = (0, 0, 0, 1)
            uniform token physics:axis = "X"
            rel newton:mimicJoint = </World/Robot/finger1>
            float newton:mimicCoef1 = 1
        }
    }
    def Xform "Tray1" (
        instanceable = true
        references = </Tray>
    )
    {
        double3 xformOp:translate = (1, 0, 0.01)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Sphere "Ball" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysxRigidBodyAPI"])
    {
        double radius = 0.05
        double3 xformOp:translate = (1.15, 0.15, 0.4)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        float physxRigidBody:linearDamping = 0
        float physxRigidBody:angularDamping = 0.05
    }
}
class Xform "Tray" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
{
    float physics:mass = 2
    def Mesh "mesh" (
        prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI", "PhysxSDFMeshCollisionAPI"]
    )
    {
        uniform token physics:approximation = "sdf"
        point3f[] points = [
            (0, 0, 0), (0.3, 0, 0), (0.3, 0.3, 0), (0, 0.3, 0),
            (0, 0, 0.1), (0.3, 0, 0.1), (0.3, 0.3, 0.1), (0, 0.3, 0.1),
            (0.05, 0.05, 0.1), (0.25, 0.05, 0.1), (0.25, 0.25, 0.1), (0.05, 0.25, 0.1),
            (0.05, 0.05, 0.03), (0.25, 0.05, 0.03), (0.25, 0.25, 0.03), (0.05, 0.25, 0.03)]
        int[] faceVertexCounts = [4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4]
        int[] faceVertexIndices = [
            0, 3, 2, 1, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7,
            4, 5, 9, 8, 5, 6, 10, 9, 6, 7, 11, 10, 7, 4, 8, 11,
            8, 9, 13, 12, 9, 10, 14, 13, 10, 11, 15, 14, 11, 8, 12, 15, 12, 13, 14, 15]
    }
}
"""


@pytest.fixture
def played(tmp_path):
    (tmp_path / "arm.usda").write_text(ARM)
    with App(stage=str(tmp_path / "arm.usda"), loop_hz=60) as app:
        app.play()
        app.update(steps=240)
        yield app


def test_the_scene_brings_its_own_rate_and_only_choices_of_another_engine_are_reported(played):
    assert played.simulation.get_num_physics_steps() == 480
    assert {(warning.code, warning.where) for warning in played.warnings} == {
        ("physics-setting-stored", "/World/physicsScene.physxScene:broadphaseType"),
    }


def test_the_arm_goes_to_its_target_and_the_fingers_mimic(played):
    robot = played.physics.articulation("/World/Robot")
    assert robot.joint_names == ("shoulder", "finger1", "finger2")
    shoulder, first, second = robot.positions
    # 1000 N m per degree holds 1.1 kg about 0.17 m out against gravity to 1e-4 rad
    assert shoulder == pytest.approx(math.radians(30), abs=1e-3)
    assert first == pytest.approx(0.02, abs=2e-3)  # it leans, and 0.025 kg g sin 30 per N/m pulls it by 0.5 mm
    assert second == pytest.approx(first, abs=1e-3)
    left, right = (
        played.physics.positions[played.physics.body_paths.index(f"/World/Robot/{name}")] for name in ("left", "right")
    )
    along = np.array([math.cos(shoulder), 0, -math.sin(shoulder)])
    assert (left - right) @ along == pytest.approx(first + second, abs=1e-4)


def test_the_ball_lies_in_the_hollow_of_the_instanced_tray(played):
    bodies = played.physics.body_paths
    tray, ball = (played.physics.positions[bodies.index(path)] for path in ("/World/Tray1", "/World/Ball"))
    assert tray == pytest.approx([1, 0, 0], abs=3e-3)
    assert ball[2] - tray[2] == pytest.approx(0.03 + 0.05, abs=3e-3)
    assert played.physics.model.body_mass[bodies.index("/World/Tray1") + 1] == pytest.approx(2)
