"""Old module paths of this package, importable for one more release with a DeprecationWarning."""

from __future__ import annotations

MOVED = {
    "sensors.annotated_writer": "sensors.writers.annotated",
    "sensors.annotator": "sensors.annotators.annotator",
    "sensors.annotator_types": "sensors.annotators.types",
    "sensors.drawing": "sensors.writers.drawing",
    "sensors.gmo_layout": "sensors.gmo.layout",
    "sensors.ids": "sensors.surfaces.ids",
    "sensors.lidar.history": "sensors.motion.history",
    "sensors.lidar.motion": "sensors.motion.velocities",
    "sensors.lidar.slerp": "sensors.motion.trajectory",
    "sensors.lidar.velocities": "sensors.motion.velocities",
    "sensors.materials": "sensors.surfaces.materials",
    "sensors.optics": "sensors.surfaces.optics",
    "sensors.semantics": "sensors.surfaces.semantics",
    "sensors.specs": "sensors.annotators.specs",
}
"""Old dotted path to the present one."""
