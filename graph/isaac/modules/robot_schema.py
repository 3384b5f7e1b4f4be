"""`usd.schema.isaac.robot_schema`: names of the robot schema, and the functions that apply it to prims."""

from __future__ import annotations

from enum import Enum
from typing import Any

from graph.sim.usd import Sdf

from .carb import log_warn
from .own_schemas import take_own_schemas

__all__ = [
    "ApplyAttachmentPointAPI",
    "ApplyJointAPI",
    "ApplyLinkAPI",
    "ApplyReferencePointAPI",
    "ApplyRobotAPI",
    "ApplySiteAPI",
    "Attributes",
    "Classes",
    "CreateNamedPose",
    "CreateSurfaceGripper",
    "DofOffsetOpOrder",
    "Relations",
]

take_own_schemas()  # prims are asked for these by name


class Classes(Enum):
    """Types and API schemas."""

    ROBOT_API = "IsaacRobotAPI"
    LINK_API = "IsaacLinkAPI"
    REFERENCE_POINT_API = "IsaacReferencePointAPI"
    SITE_API = "IsaacSiteAPI"
    JOINT_API = "IsaacJointAPI"
    SURFACE_GRIPPER = "IsaacSurfaceGripper"
    ATTACHMENT_POINT_API = "IsaacAttachmentPointAPI"
    NAMED_POSE = "IsaacNamedPose"


class DofOffsetOpOrder(Enum):
    """Tokens of `isaac:physics:DofOffsetOpOrder`."""

    TRANS_X = "TransX"
    TRANS_Y = "TransY"
    TRANS_Z = "TransZ"
    ROT_X = "RotX"
    ROT_Y = "RotY"
    ROT_Z = "RotZ"


class _Property(Enum):
    """A property: its name on the prim and its label; of an attribute, the type too."""

    @property
    def name(self) -> str:  # the name on the prim, as in Isaac Sim
        return str(self.value[0])

    @property
    def display_name(self) -> str:
        return str(self.value[1])


class Attributes(_Property):
    """Attributes of the schema."""

    DESCRIPTION = ("isaac:description", "Description", "string")
    NAMESPACE = ("isaac:namespace", "Namespace", "string")
    ROBOT_TYPE = ("isaac:robotType", "Robot Type", "token")
    LICENSE = ("isaac:license", "License", "token")
    VERSION = ("isaac:version", "Version", "string")
    SOURCE = ("isaac:source", "Source", "string")
    CHANGELOG = ("isaac:changelog", "Changelog", "string[]")
    NAME_OVERRIDE = ("isaac:nameOverride", "Name Override", "string")
    REFERENCE_DESCRIPTION = ("isaac:Description", "Reference Description", "string")
    FORWARD_AXIS = ("isaac:forwardAxis", "Forward Axis", "token")
    JOINT_NAME_OVERRIDE = ("isaac:NameOverride", "Joint Name Override", "string")
    DOF_OFFSET_OP_ORDER = ("isaac:physics:DofOffsetOpOrder", "Dof Offset Op Order", "token[]")
    ACTUATOR = ("isaac:actuator", "Actuator", "bool[]")
    RETRY_INTERVAL = ("isaac:retryInterval", "Retry Interval", "float")
    STATUS = ("isaac:status", "Status", "token")
    SHEAR_FORCE_LIMIT = ("isaac:shearForceLimit", "Shear Force Limit", "float")
    COAXIAL_FORCE_LIMIT = ("isaac:coaxialForceLimit", "Coaxial Force Limit", "float")
    MAX_GRIP_DISTANCE = ("isaac:maxGripDistance", "Max Grip Distance", "float")
    CLEARANCE_OFFSET = ("isaac:clearanceOffset", "Clearance Offset", "float")
    POSE_VALID = ("isaac:robot:pose:valid", "Pose Valid", "bool")
    POSE_JOINT_VALUES = ("isaac:robot:pose:jointValues", "Pose Joint Values", "float[]")
    POSE_JOINT_FIXED = ("isaac:robot:pose:jointFixed", "Pose Joint Fixed", "bool[]")

    @property
    def type(self) -> Any:
        return Sdf.ValueTypeNames.Find(self.value[2])


class Relations(_Property):
    """Relationships of the schema."""

    ROBOT_LINKS = ("isaac:physics:robotLinks", "Robot Links")
    ROBOT_JOINTS = ("isaac:physics:robotJoints", "Robot Joints")
    NAMED_POSES = ("isaac:robot:namedPoses", "Named Poses")
    ATTACHMENT_POINTS = ("isaac:attachmentPoints", "Attachment Points")
    GRIPPED_OBJECTS = ("isaac:grippedObjects", "Gripped Objects")
    POSE_START_LINK = ("isaac:robot:pose:startLink", "Pose Start Link")
    POSE_END_LINK = ("isaac:robot:pose:endLink", "Pose End Link")
    POSE_JOINTS = ("isaac:robot:pose:joints", "Pose Joints")


_ROBOT = ("DESCRIPTION", "NAMESPACE", "ROBOT_TYPE", "LICENSE", "VERSION", "SOURCE", "CHANGELOG")
_POSE = ("POSE_VALID", "POSE_JOINT_VALUES", "POSE_JOINT_FIXED")
_GRIPPER = ("STATUS", "SHEAR_FORCE_LIMIT", "COAXIAL_FORCE_LIMIT", "MAX_GRIP_DISTANCE", "RETRY_INTERVAL")


def ApplyRobotAPI(prim: Any) -> None:
    """Makes the prim a robot whose links and joints are those of its articulation."""
    from .robot_schema_utils import PopulateRobotSchemaFromArticulation

    if not prim.HasAPI(Classes.ROBOT_API.value):
        prim.AddAppliedSchema(Classes.ROBOT_API.value)
        _create(prim, _ROBOT)
    PopulateRobotSchemaFromArticulation(prim.GetStage(), prim, prim)


def ApplyLinkAPI(prim: Any) -> None:
    _apply(prim, Classes.LINK_API)


def ApplyJointAPI(prim: Any) -> None:
    _apply(prim, Classes.JOINT_API)


def ApplySiteAPI(prim: Any) -> None:
    _apply(prim, Classes.SITE_API)


def ApplyReferencePointAPI(prim: Any) -> None:
    """The old name of a site."""
    log_warn("ApplyReferencePointAPI is deprecated; use ApplySiteAPI")
    ApplySiteAPI(prim)


def ApplyAttachmentPointAPI(prim: Any) -> None:
    _apply(prim, Classes.ATTACHMENT_POINT_API)


def CreateSurfaceGripper(stage: Any, prim_path: str) -> Any:
    """The prim of a surface gripper, with its attributes and relationships."""
    prim = stage.DefinePrim(prim_path, Classes.SURFACE_GRIPPER.value)
    _create(prim, _GRIPPER, ("ATTACHMENT_POINTS", "GRIPPED_OBJECTS"))
    return prim


def CreateNamedPose(stage: Any, prim_path: str) -> Any:
    """The prim of a pose: a chain of joints from one link to another, and a value for each."""
    prim = stage.DefinePrim(prim_path, Classes.NAMED_POSE.value)
    _create(prim, _POSE, ("POSE_START_LINK", "POSE_END_LINK", "POSE_JOINTS"))
    return prim


def _apply(prim: Any, schema: Classes) -> None:
    if not prim.HasAPI(schema.value):
        prim.AddAppliedSchema(schema.value)


def _create(prim: Any, attributes: tuple[str, ...], relations: tuple[str, ...] = ()) -> None:
    for one in (Attributes[name] for name in attributes):
        prim.CreateAttribute(one.name, one.type, False)
    for name in relations:
        prim.CreateRelationship(Relations[name].name, False)
