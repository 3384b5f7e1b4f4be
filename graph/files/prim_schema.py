"""The JSON Schema of an inline prim, for completion in an editor; the values are checked when the prim is authored."""

from __future__ import annotations

from typing import Any

_POSITIVE = {"type": "number", "exclusiveMinimum": 0}
_VECTOR = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
_TEXTS = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}

PRIM: dict[str, Any] = {
    "description": "A prim added to the scene. Lengths are in stage units.",
    "type": "object",
    "additionalProperties": False,
    "properties": {
        "type": {
            "description": "USD prim type, such as Xform, Cube, Sphere, Capsule, Cylinder, Cone, Plane, Mesh, "
            "PhysicsRevoluteJoint, or that of a sensor. Left out to change a prim of the scene.",
            "type": "string",
        },
        "reference": {
            "description": "USD file that the prim brings in, relative to the graph file and below its folder.",
            "type": "string",
        },
        "schemas": {"description": "API schemas to apply, such as PhysicsArticulationRootAPI.", **_TEXTS},
        "config": {
            "description": "Sensor configuration: a shipped name such as Example_Rotary, or a profile's .json file.",
            "type": "string",
        },
        "variant": {
            "description": "Variant of the sensor configuration; or of each variant set.",
            "anyOf": [{"type": "string"}, {"type": "object"}],
        },
        "aux_output_level": {
            "description": "How many channels the sensor may give.",
            "enum": ["NONE", "BASIC", "EXTRA", "FULL"],
        },
        "translate": {"description": "Place in the parent [stage units].", **_VECTOR},
        "orient": {
            "description": "Orientation in the parent as a quaternion w, x, y, z.",
            **_VECTOR,
            "minItems": 4,
            "maxItems": 4,
        },
        "rotate": {
            "description": "Orientation in the parent as rotations about x, then y, then z [degrees].",
            **_VECTOR,
        },
        "scale": {
            "description": "Scale along x, y, z, or one number for all.",
            "anyOf": [{"type": "number"}, _VECTOR],
        },
        "mount_translate": {
            "description": "Mounting error: how far it sits from its pose, along its own axes [stage units].",
            **_VECTOR,
        },
        "mount_rotate": {
            "description": "Mounting error: how it is turned from its pose about its own x, then y, then z [degrees].",
            **_VECTOR,
        },
        "size": {"description": "Edge of a Cube.", **_POSITIVE},
        "radius": {"description": "Radius of a Sphere, Capsule, Cylinder or Cone.", **_POSITIVE},
        "height": {"description": "Height of a Capsule (without its caps), Cylinder or Cone.", **_POSITIVE},
        "width": {"description": "Extent of a Plane; infinite without width and length.", **_POSITIVE},
        "length": {"description": "Extent of a Plane; infinite without width and length.", **_POSITIVE},
        "axis": {"description": "Axis of a Capsule, Cylinder, Cone or Plane.", "enum": ["X", "Y", "Z"]},
        "points": {"description": "Points of a Mesh.", "type": "array", "items": _VECTOR},
        "faces": {
            "description": "Faces of a Mesh: for each the numbers of three or more points.",
            "type": "array",
            "items": {"type": "array", "items": {"type": "integer", "minimum": 0}, "minItems": 3},
        },
        "rigid_body": {"description": "Whether physics moves it.", "type": "boolean"},
        "mass": {"description": "Mass [kg].", **_POSITIVE},
        "density": {"description": "Density [kg per cubic stage unit]; used without mass.", **_POSITIVE},
        "velocity": {"description": "Velocity at the start [stage units/s].", **_VECTOR},
        "angular_velocity": {"description": "Angular velocity at the start [degrees/s].", **_VECTOR},
        "collision": {"description": "Whether bodies hit it (default: shapes and meshes do).", "type": "boolean"},
        "visible": {"description": "Whether sensors see it.", "type": "boolean"},
        "color": {"description": "Display colour: red, green, blue from 0 to 1.", **_VECTOR},
        "material": {
            "description": "Non-visual material: its name, or {base:, coating:, attributes:}.",
            "anyOf": [{"type": "string"}, {"type": "object"}],
        },
        "semantics": {
            "description": "Labels: a class, or taxonomy to label or labels.",
            "anyOf": [{"type": "string"}, {"type": "array"}, {"type": "object"}],
        },
        "exclude": {"description": "Prims that this sensor never hits, such as its mount.", **_TEXTS},
        "attributes": {
            "description": "Any USD attribute: name to value; its type comes from the schema.",
            "type": "object",
        },
    },
}
