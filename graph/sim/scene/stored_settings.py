"""Physics settings that are only stored on their prims: their effect elsewhere, and what to do instead.

Names are those of attributes and of schemas, with `*` for any part; simulated ones are in `physics_settings`.
"""

from __future__ import annotations

from collections.abc import Mapping
from fnmatch import fnmatchcase
from functools import lru_cache
from typing import Any

from graph.base.records import dataclass

from .physics_settings import names


@dataclass(frozen=True)
class Stored:
    """Settings without effect: names (with `*`), the reason, and what to do instead."""

    why: str
    names: tuple[str, ...]


ACTUATOR = "NewtonActuator"
"""The prim type of explicit actuators, which a node reads."""

STORED = tuple(
    Stored(why, tuple(which.split()))
    for why, which in (
        (
            "MuJoCo has a solver and a broad phase of its own; raise physics_hz or physics.iterations for more "
            "precision",
            "physxRigidBody:solver*IterationCount physxArticulation:solver*IterationCount physxScene:solverType "
            "physxScene:min*IterationCount physxScene:max*IterationCount physxScene:maxBiasCoefficient "
            "physxRigidBody:cfmScale physxRigidBody:contactSlopCoefficient physxRigidBody:maxContactImpulse "
            "physxRigidBody:maxDepenetrationVelocity physxScene:bounceThreshold physxScene:friction* "
            "physxScene:enableStabilization physxScene:solveArticulationContactLast physxScene:collisionSystem "
            "physxScene:broadphaseType physxScene:enableExternalForcesEveryIteration "
            "physxScene:enableEnhancedDeterminism physxScene:enableResidualReporting PhysxResidual* newton:xpbd:* "
            "newton:kamino:* newton:vbd:* physxRigidBody:retainAccelerations",
        ),
        (
            "physics runs on the CPU and sizes its own buffers; nothing is to be done",
            "physxScene:gpu* physxScene:enableGPUDynamics physxScene:updateType physxScene:enableSceneQuerySupport",
        ),
        ("bodies never fall asleep by themselves; nothing is to be done", "*:sleepThreshold *:stabilizationThreshold"),
        (
            "collisions are looked for at every physics step and not between; raise physics_hz where fast bodies pass "
            "through thin ones",
            "physxRigidBody:enableCCD physxRigidBody:enableSpeculativeCCD",
        ),
        (
            "bodies collide where their surfaces meet, neither before nor after; change the collider's size instead",
            "physxCollision:contactOffset physxCollision:restOffset newton:contactMargin newton:contactGap mjc:margin "
            "mjc:gap",
        ),
        (
            "friction against spinning is a number of the material; set newton:torsionalFriction on it",
            "physxCollision:torsionalPatchRadius physxCollision:minTorsionalPatchRadius",
        ),
        (
            "colliding meshes are cut into convex parts exactly, whatever is set; use a coarser mesh if it is too slow",
            "physxConvexHullCollision:* physxConvexDecompositionCollision:* physxSphereFillCollision:* "
            "physxTriangleMeshCollision:* physxTriangleMeshSimplificationCollision:* physxSDFMeshCollision:* "
            "physxCookedData:* PhysxMeshMergeCollisionAPI physxMeshMergeCollision:* newton:maxHullVertices newton:sdf* "
            "newton:hydroelastic* mjc:maxhullvert",
        ),
        (
            "the mass is spread over the volume of the colliders; author physics:mass and physics:diagonalInertia",
            "newton:massModel newton:shellThickness newton:inertia mjc:shellinertia mjc:inertia",
        ),
        (
            "contacts are rigid; use a deformable for what gives way",
            "physxMaterial:compliantContact* physxMaterial:dampingCombineMode physxMaterial:improvePatchFriction "
            "newton:contactStiffness newton:contactDamping newton:contactFrictionGain newton:contactAdhesion "
            "mjc:solref mjc:solimp mjc:solmix mjc:condim mjc:priority",
        ),
        (
            "all colliders of a body touch; set physics:collisionEnabled = false on those that must not",
            "physxRigidBody:solveContact",
        ),
        (
            "what joints connect is always one mechanism; set physics:jointEnabled = false on a joint that must not "
            "hold",
            "physxArticulation:articulationEnabled",
        ),
        (
            "what enters and leaves a trigger is read in app.simulation.tensors.triggered; nothing runs by itself",
            "physxTrigger:*",
        ),
        ("what spins always precesses; nothing is to be done", "physxRigidBody:enableGyroscopicForces"),
        (
            "kinematic bodies and what stands still do not meet; make one of them a body that forces move",
            "physxScene:reportKinematic*",
        ),
        (
            "collision groups are filtered as UsdPhysics says; set physics:invertFilteredGroups on each group",
            "physxScene:invertCollisionGroupFilter",
        ),
        (
            "only contact reports of scripts follow it; every contact is in app.simulation.tensors.contacts",
            "physxContactReport:*",
        ),
        (
            "joint limits are hard stops; for a soft one use a drive that aims at it",
            "physxLimit:* newton:limitStiffness newton:limitDamping mjc:solreflimit mjc:solimplimit "
            "physxJoint:enableProjection",
        ),
        (
            "drives are springs with dampers within a force limit; set drive:*:physics:maxForce",
            "physxDrivePerformanceEnvelope:* PhysxDrivePerformanceEnvelopeAPI",
        ),
        (
            "distance joints are strings or rods; for a spring use a PhysicsPrismaticJoint with a drive",
            "physxPhysicsDistanceJoint:*",
        ),
        (
            "a joint that mimics another follows it rigidly; set gearing and offset",
            "physxMimicJoint:*:naturalFrequency physxMimicJoint:*:dampingRatio",
        ),
        (
            "joints have inertia (armature), dry and viscous friction, a top speed and a drive; use the drive for a "
            "spring",
            "mjc:stiffness mjc:springref mjc:springdamper mjc:actuatorfrc* mjc:ref mjc:actuatorgravcomp "
            "mjc:solreffriction mjc:solimpfriction physxJoint:* physxJointAxis:* newton:jointsAddMobility",
        ),
        (
            "tendons are not simulated; couple joints by NewtonMimicAPI or PhysxMimicJointAPI",
            "physxTendon:* PhysxTendon* MjcTendon mjc:path* mjc:sideSites*",
        ),
        (
            "gears are not simulated; couple the joints by PhysxMimicJointAPI or NewtonMimicAPI",
            "PhysxPhysicsGearJoint PhysxPhysicsRackAndPinionJoint",
        ),
        (
            "vehicles are not simulated; build one of bodies, joints and drives, steered by a controller node",
            "physxVehicle* PhysxVehicle*",
        ),
        (
            "character controllers are not simulated; move a kinematic body",
            "physxCharacterController:* PhysxCharacterControllerAPI",
        ),
        (
            "cameras do not follow by physics; write their transforms",
            "physxCamera:* physxFollow* physxDroneCamera:* PhysxCamera*",
        ),
        (
            "particles are simulated as PhysxParticleSetAPI without fluid only",
            "PhysxParticleSystem physxParticle* PhysxParticle* PhysxDiffuseParticlesAPI PhysxPBDMaterialAPI "
            "physxDiffuseParticles:* physxPBDMaterial:* newton:mpm:* NewtonMPM*",
        ),
        (
            "cloth and soft bodies have a density, stiffness, damping and thickness; no other setting of theirs counts",
            "physxDeformable* physxSurfaceDeformable* physxAutoDeformable* physxBaseDeformable* omniphysics:* "
            "OmniPhysics* deformablePose:* Physx*Deformable* PhysxPhysicsAttachment physxAutoAttachment* PhysxAuto* "
            "newton:curves* Newton*Deformable* physxHair* PhysxHair* physxCloth* physxAutoParticleCloth:* "
            "physxVolumeDeformable* physics:masses",
        ),
        (
            "copies by physics instancers are not simulated; use a PointInstancer or references",
            "PhysxPhysicsInstancer PhysxPhysicsJointInstancer",
        ),
        (
            "inertia is always simulated, quasi-static scenes are not; raise damping instead",
            "PhysxSceneQuasistaticAPI physxSceneQuasistatic:*",
        ),
        (
            "belts along curves are not simulated; use PhysxSurfaceVelocityAPI on straight and round parts",
            "physxSplinesSurfaceVelocity:* PhysxSplinesSurfaceVelocityAPI",
        ),
        (
            "actuators act only through the node ArticulationActuators (in scripts the class of this name); without "
            "it joints move by their drives",
            "NewtonActuator* NewtonPDControlAPI NewtonPIDControlAPI NewtonNeuralControlAPI Newton*Clamping* "
            "newton:targets newton:delaySteps newton:constEffort newton:k? newton:integralMax newton:max*Effort "
            "newton:saturationEffort newton:model* newton:lookup*",
        ),
        (
            "of MuJoCo's own elements in USD only the options of the scene, armature and friction are read; load the "
            "MJCF model itself (scene: {mjcf: ...})",
            "mjc:* Mjc*",
        ),
        ("sites are not simulated; use an Xform", "NewtonSiteAPI"),
    )
)
"""Settings that are only stored, grouped by reason; the first entry that matches a name counts."""

UNKNOWN = Stored("nothing here reads it; check its spelling", ("*",))

NEUTRAL: Mapping[str, Any] = {
    "physxRigidBody:enableGyroscopicForces": True,
    "physxRigidBody:solveContact": True,
    "physxArticulation:articulationEnabled": True,
    "physxScene:enableSceneQuerySupport": True,
    "physxScene:updateType": "Synchronous",
    "physxMaterial:dampingCombineMode": "average",
    "physxCharacterController:climbingMode": "easy",
}
"""Values that ask for the default behaviour, besides 0, false, empty and infinite ones."""

QUIET_SCHEMAS = names(
    "PhysicsRigidBodyAPI PhysicsCollisionAPI PhysicsMassAPI PhysicsMaterialAPI PhysicsDriveAPI PhysicsLimitAPI "
    "PhysicsFilteredPairsAPI PhysicsMeshCollisionAPI PhysicsArticulationRootAPI PhysicsJointStateAPI PhysicsScene "
    "PhysicsCollisionGroup PhysicsJoint PhysicsFixedJoint PhysicsRevoluteJoint PhysicsPrismaticJoint "
    "PhysicsSphericalJoint PhysicsDistanceJoint PhysxSceneAPI PhysxRigidBodyAPI PhysxCollisionAPI PhysxMaterialAPI "
    "PhysxJointAPI PhysxForceAPI PhysxSurfaceVelocityAPI PhysxTriggerAPI PhysxTriggerStateAPI PhysxJointAxisAPI "
    "PhysxLimitAPI PhysxMimicJointAPI PhysxArticulationAPI PhysxContactReportAPI PhysxConvexHullCollisionAPI "
    "PhysxConvexDecompositionCollisionAPI PhysxSphereFillCollisionAPI PhysxTriangleMeshCollisionAPI "
    "PhysxTriangleMeshSimplificationCollisionAPI PhysxSDFMeshCollisionAPI PhysxPhysicsDistanceJointAPI "
    "PhysxCookedDataAPI PhysxDeformableSurfaceAPI PhysxDeformableAPI PhysxDeformableBodyAPI "
    "PhysxDeformableSurfaceMaterialAPI PhysxDeformableBodyMaterialAPI PhysxParticleClothAPI PhysxParticleSetAPI "
    "PhysxParticleAPI PhysxPBDMaterialAPI PhysxPhysicsAttachment OmniPhysicsVtxXformAttachment "
    "OmniPhysicsDeformableBodyAPI OmniPhysicsSurfaceDeformableSimAPI OmniPhysicsVolumeDeformableSimAPI "
    "OmniPhysicsBaseMaterialAPI OmniPhysicsDeformableMaterialAPI OmniPhysicsSurfaceDeformableMaterialAPI "
    "OmniPhysicsBodyAPI NewtonSceneAPI NewtonJointAPI NewtonMaterialAPI NewtonMimicAPI NewtonArticulationRootAPI "
    "NewtonXpbdSceneAPI NewtonKaminoSceneAPI NewtonVbdSceneAPI NewtonMassAPI NewtonCollisionAPI "
    "NewtonMeshCollisionAPI NewtonSDFCollisionAPI MjcSceneAPI MjcJointAPI MjcMaterialAPI MjcCollisionAPI "
    "MjcMeshCollisionAPI MjcImageableAPI MjcSiteAPI"
)
"""Schemas without an effect of their own: their effect is in their attributes."""


@lru_cache(maxsize=4096)
def stored_as(name: str) -> Stored:
    """The explanation for a name that is not simulated."""
    return next((row for row in STORED if any(fnmatchcase(name, each) for each in row.names)), UNKNOWN)
