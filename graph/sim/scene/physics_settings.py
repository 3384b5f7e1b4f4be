"""The simulated physics settings, and the prims on which they work; `stored_settings` has the others.

A name is that of an attribute or relationship; the instance of a multiple-apply schema is written `*`
(`drive:*:physics:damping`). Every name in one of `NAMESPACES` that is not `SIMULATED` is only stored on its prim.
"""

from __future__ import annotations

from collections.abc import Mapping


def names(text: str) -> frozenset[str]:
    """The names in a text, with spaces between them."""
    return frozenset(text.split())


AXES = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ")
"""Names of the axes in UsdPhysics' LimitAPI and DriveAPI."""

NAMESPACES = ("physics:", "physx", "newton:", "mjc:", "omniphysics:", "drive:", "limit:", "state:", "deformablePose:")
"""Prefixes of the names of physics attributes."""

SCHEMAS = ("Physics", "Physx", "Newton", "Mjc", "OmniPhysics")
"""Prefixes of the names of physics schemas."""

INSTANCED = names(
    "drive limit state physxLimit physxJointAxis physxMimicJoint physxTendon physxDrivePerformanceEnvelope "
    "physxCookedData physxVehicleBrakes physxVehicleNCR deformablePose"
)
"""Namespaces of multiple-apply schemas: the part after the first colon names the instance."""

ROLES = {
    "scene": "a PhysicsScene",
    "body": "a rigid body (PhysicsRigidBodyAPI)",
    "collider": "a collider (PhysicsCollisionAPI)",
    "material": "a physics material (PhysicsMaterialAPI)",
    "group": "a PhysicsCollisionGroup",
    "root": "an articulation root (PhysicsArticulationRootAPI)",
    "revolute": "a PhysicsRevoluteJoint",
    "prismatic": "a PhysicsPrismaticJoint",
    "spherical": "a PhysicsSphericalJoint",
    "distance": "a PhysicsDistanceJoint",
    "fixed": "a PhysicsFixedJoint",
    "d6": "a PhysicsJoint",
    "soft": "a deformable",
    "attachment": "an attachment of a deformable",
}
"""The role of a prim in physics, in words."""

JOINTS = ("revolute", "prismatic", "spherical", "distance", "fixed", "d6")
SINGLES = ("revolute", "prismatic")
MOVING_AXES = (*SINGLES, "d6")

INSTANCES: Mapping[str, tuple[str, ...]] = {"revolute": ("angular",), "prismatic": ("linear",), "d6": AXES}
"""Instances of drives, limits and states of a joint, by its role."""


def _on(roles: tuple[str, ...], names: str) -> dict[str, tuple[str, ...]]:
    return dict.fromkeys(names.split(), roles)


SIMULATED: Mapping[str, tuple[str, ...]] = {
    **_on(
        ("body",),
        "physics:rigidBodyEnabled physics:kinematicEnabled physics:startsAsleep physics:angularVelocity "
        "physxRigidBody:linearDamping physxRigidBody:angularDamping physxRigidBody:disableGravity "
        "physxRigidBody:maxLinearVelocity physxRigidBody:maxAngularVelocity physxRigidBody:lockedPosAxis "
        "physxRigidBody:lockedRotAxis physxForce:force physxForce:torque physxForce:forceEnabled physxForce:mode "
        "physxForce:worldFrameEnabled physxSurfaceVelocity:surfaceVelocity "
        "physxSurfaceVelocity:surfaceAngularVelocity physxSurfaceVelocity:surfaceVelocityEnabled "
        "physxSurfaceVelocity:surfaceVelocityLocalSpace",
    ),
    **_on(("body", "soft"), "physics:velocity"),
    **_on(("body", "collider", "soft"), "physics:simulationOwner physics:mass"),
    **_on(("body", "collider", "material", "soft"), "physics:density"),
    **_on(("body", "collider"), "physics:centerOfMass physics:diagonalInertia physics:principalAxes"),
    **_on(("body", "collider", "root"), "physics:filteredPairs"),
    **_on(("collider",), "physics:collisionEnabled physics:approximation"),
    **_on(
        ("material",),
        "physics:staticFriction physics:dynamicFriction physics:restitution physxMaterial:frictionCombineMode "
        "physxMaterial:restitutionCombineMode newton:torsionalFriction newton:rollingFriction mjc:torsionalfriction "
        "mjc:rollingfriction",
    ),
    **_on(("group",), "physics:filteredGroups physics:mergeGroup physics:invertFilteredGroups"),
    **_on(
        ("scene",),
        "physics:gravityDirection physics:gravityMagnitude newton:gravityEnabled newton:maxSolverIterations "
        "physxScene:timeStepsPerSecond newton:timeStepsPerSecond mjc:option:timestep physxScene:enableCCD "
        "physxScene:disableSleeping mjc:flag:multiccd mjc:flag:nativeccd mjc:option:integrator mjc:option:solver "
        "mjc:option:cone mjc:option:jacobian mjc:option:iterations mjc:option:ls_iterations "
        "mjc:option:noslip_iterations mjc:option:ccd_iterations mjc:option:tolerance mjc:option:ls_tolerance "
        "mjc:option:ccd_tolerance mjc:option:impratio mjc:option:density mjc:option:viscosity mjc:option:wind",
    ),
    **_on(
        JOINTS,
        "physics:body0 physics:body1 physics:localPos0 physics:localPos1 physics:localRot0 physics:localRot1 "
        "physics:jointEnabled physics:collisionEnabled physics:excludeFromArticulation physics:breakForce "
        "physics:breakTorque",
    ),
    "physics:collisionEnabled": ("collider", *JOINTS),
    **_on((*SINGLES, "spherical"), "physics:axis"),
    **_on(SINGLES, "physics:lowerLimit physics:upperLimit"),
    **_on(("spherical",), "physics:coneAngle0Limit physics:coneAngle1Limit"),
    **_on(("distance",), "physics:minDistance physics:maxDistance"),
    **_on(
        MOVING_AXES,
        "drive:*:physics:type drive:*:physics:stiffness drive:*:physics:damping drive:*:physics:maxForce "
        "drive:*:physics:targetPosition drive:*:physics:targetVelocity physxJoint:armature newton:armature "
        "newton:friction mjc:armature mjc:frictionloss physxJointAxis:*:armature "
        "physxJointAxis:*:dynamicFrictionEffort physxJointAxis:*:maxJointVelocity "
        "physxJointAxis:*:viscousFrictionCoefficient physxJoint:jointFriction physxJoint:maxJointVelocity "
        "newton:damping newton:velocityLimit mjc:damping state:*:physics:position state:*:physics:velocity "
        "newton:mimicEnabled newton:mimicJoint newton:mimicCoef0 newton:mimicCoef1 physxMimicJoint:*:gearing "
        "physxMimicJoint:*:offset physxMimicJoint:*:referenceJoint physxMimicJoint:*:referenceJointAxis",
    ),
    **_on(("d6",), "limit:*:physics:low limit:*:physics:high"),
    **_on(("root",), "physxArticulation:enabledSelfCollisions newton:selfCollisionEnabled"),
    **_on(
        ("soft",),
        "physxDeformable:deformableEnabled physxDeformable:selfCollision physxDeformable:simulationIndices "
        "physxDeformable:simulationRestPoints physxParticle:particleEnabled physxParticle:selfCollision "
        "physxParticle:fluid omniphysics:deformableBodyEnabled omniphysics:mass",
    ),
    **_on(
        ("soft", "material"),
        "omniphysics:density omniphysics:dynamicFriction omniphysics:youngsModulus omniphysics:poissonsRatio "
        "omniphysics:elasticityDamping omniphysics:surfaceThickness physxPBDMaterial:density "
        "physxPBDMaterial:friction physxDeformableSurfaceMaterial:thickness physxDeformableSurfaceMaterial:density "
        "physxDeformableSurfaceMaterial:youngsModulus physxDeformableSurfaceMaterial:poissonsRatio "
        "physxDeformableSurfaceMaterial:elasticityDamping physxDeformableSurfaceMaterial:dynamicFriction "
        "physxDeformableBodyMaterial:density physxDeformableBodyMaterial:youngsModulus "
        "physxDeformableBodyMaterial:poissonsRatio physxDeformableBodyMaterial:elasticityDamping "
        "physxDeformableBodyMaterial:dynamicFriction",
    ),
    **_on(("attachment",), "omniphysics:src0 omniphysics:src1 omniphysics:vtxIndicesSrc0"),
}
"""Roles in which an attribute or relationship has an effect."""

RELATIONSHIPS = frozenset(
    {"newton:mimicJoint", "physxMimicJoint:*:referenceJoint", "omniphysics:src0", "omniphysics:src1"}
)
TOKENS = names(
    "physxMaterial:frictionCombineMode physxMaterial:restitutionCombineMode physxMimicJoint:*:referenceJointAxis "
    "mjc:option:integrator mjc:option:solver mjc:option:cone mjc:option:jacobian physxForce:mode"
)
VECTORS = names(
    "mjc:option:wind physxForce:force physxForce:torque physxSurfaceVelocity:surfaceVelocity "
    "physxSurfaceVelocity:surfaceAngularVelocity"
)
ARRAYS = frozenset(
    {"physxDeformable:simulationIndices", "physxDeformable:simulationRestPoints", "omniphysics:vtxIndicesSrc0"}
)
"""Kinds of simulated properties that are not in UsdPhysics' own schemas; all others are numbers."""


def generic(name: str) -> tuple[str, str]:
    """The name of an attribute as this table writes it, and its instance ("" if none)."""
    first, _, rest = name.partition(":")
    if first in INSTANCED and ":" in rest:
        instance, _, attribute = rest.partition(":")
        return f"{first}:*:{attribute}", instance
    return name, ""
