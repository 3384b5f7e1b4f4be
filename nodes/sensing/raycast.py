"""Raycast sensors: distances along the sensor's own rays."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.errors import RunError
from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type

from .imu import sensor_prim

if TYPE_CHECKING:
    from sensors.rays import RaySensor


@dataclass(slots=True)
class _Memory:
    rays: RaySensor | None = None


@node_type(
    "isaacsim.sensors.physics.IsaacReadRaycastSensor",
    version=1,
    needs=(("raycastSensorPrim",),),
    inputs={
        "execIn": Attribute("execution", "reads the sensor"),
        "raycastSensorPrim": Attribute("target", "an IsaacRaycastSensor"),
    },
    outputs={
        "execOut": Attribute("execution", "follows when there is a reading"),
        "sensorTime": Attribute("float", "simulation time of the reading", default=0.0, unit="s"),
        "depths": Attribute(
            "float[]", "how far each ray goes from its origin; maxRange where it hits nothing", unit="stage units"
        ),
        "hitPositions": Attribute(
            "float[]", "x, y, z of where each ray ends, in the sensor's axes or the world's", unit="stage units"
        ),
        "hitNormals": Attribute(
            "float[]", "x, y, z of the normal of what each ray hits; 0, 0, 0 where it hits nothing"
        ),
        "hitPrimPaths": Attribute("token[]", "what each ray hits, with the prim's reportHitPrimPaths; else empty"),
        "numRays": Attribute("uint", "rays of this reading", default=0),
        "beamOrigins": Attribute("pointf[3][]", "where each ray begins in the world", default=[], unit="stage units"),
        "beamEndPoints": Attribute("pointf[3][]", "where each ray ends in the world", default=[], unit="stage units"),
    },
    memory=_Memory,
)
def read_raycast_sensor(db: Database) -> None:
    """Cast the sensor's rays at the newest physics step, from minRange on, at the surfaces that lidars see.

    The prim is read once after play. If it has time offsets, a reading holds the rays that were fired during the newest
    physics step; for all of them the graph must run in each step (OnPhysicsStep). With a disabled sensor or a stopped
    timeline, and while nobody reads what the node gives, there is no reading.
    """
    import numpy as np

    from sensors.rays import RaySensor

    outputs, app = db.outputs, db.app
    if app.timeline.is_stopped():
        return
    if db.memory.rays is None:
        try:
            db.memory.rays = RaySensor.of(sensor_prim(db, db.inputs.raycastSensorPrim, "raycastSensorPrim"))
        except RunError as error:
            db.fail(str(error))
    rays = db.memory.rays
    if not rays.enabled or not db.is_read():
        return
    found = rays.read(app.world)
    outputs.sensorTime = found.time
    outputs.depths = found.depths.astype(np.float32)
    outputs.beamOrigins, outputs.beamEndPoints = found.origins.astype(np.float32), found.ends.astype(np.float32)
    outputs.numRays = len(found.depths)
    outputs.hitPositions = found.positions.astype(np.float32).reshape(-1)
    outputs.hitNormals = found.normals.astype(np.float32).reshape(-1)
    outputs.hitPrimPaths = found.prims
    db.fire("execOut")
