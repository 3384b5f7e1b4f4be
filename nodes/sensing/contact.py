"""Contact sensors: the contact force on a body."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.node import Attribute, Database, node_type

from .imu import EVERY_STEP, check_body, sensor_prim

if TYPE_CHECKING:
    from graph.sim.app import App

THRESHOLD, RADIUS = (0.0, 100000.0), -1.0
"""Defaults of an IsaacContactSensor's attributes."""


@node_type(
    "isaacsim.sensors.physics.IsaacReadContactSensor",
    version=1,
    check=check_body,
    needs=(("csPrim",),),
    inputs={
        "execIn": Attribute("execution", "reads the sensor"),
        "csPrim": Attribute("target", "an IsaacContactSensor, or any other prim, on a rigid body or below one"),
        "useLatestData": Attribute("bool", "has no effect", default=False, deprecated=EVERY_STEP),
    },
    outputs={
        "execOut": Attribute("execution", "follows when there is a reading"),
        "sensorTime": Attribute("float", "simulation time of the reading", default=0.0, unit="s"),
        "inContact": Attribute("bool", "whether the force is within the sensor's threshold", default=False),
        "value": Attribute("float", "the total force of the body's contacts; 0 out of contact", default=0.0, unit="N"),
    },
)
def read_contact_sensor(db: Database) -> None:
    """Add up the forces on the sensor's body in the newest physics step, of contacts within the sensor's radius.

    The prim's `threshold` (least, most, in units of the stage) and `radius` (stage units; not above 0: all contacts)
    apply if authored: a force below the least counts as no contact, a force above the most reads as the most.
    """
    from graph.sim.physics.protocol import contact_force
    from sensors.inertial import attribute_of, body_of

    outputs, app = db.outputs, db.app
    prim = sensor_prim(db, db.inputs.csPrim, "csPrim", "IsaacContactSensor")
    outputs.inContact, outputs.value, outputs.sensorTime = False, 0.0, 0.0
    if app.timeline.is_stopped() or not attribute_of(prim, "enabled", True):
        return
    body, physics = body_of(app.world, str(prim.GetPath())), app.physics
    if body is None or physics is None or body not in physics.body_paths:
        db.fail(f"{prim.GetPath()} is on a body that physics does not move; its contacts are not simulated")
    unit = app.meters_per_unit
    place = app.fabric.world_matrix(str(prim.GetPath()))[:3, 3] * unit
    force = contact_force(physics, body, place, float(attribute_of(prim, "radius", RADIUS)) * unit)
    least, most = (float(part) * _newtons(app) for part in attribute_of(prim, "threshold", THRESHOLD))
    value = min(float((force @ force) ** 0.5), most)
    if value > 0 and value >= least:
        outputs.inContact, outputs.value = True, value
    outputs.sensorTime = float(app.simulation.time)
    db.fire("execOut")


def _newtons(app: App) -> float:
    """Newtons in one unit of force of the stage."""
    from graph.sim.attributes import kilograms_per_unit

    return kilograms_per_unit(app.stage) * float(app.meters_per_unit)
