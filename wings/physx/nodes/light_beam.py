"""The light beam sensor of PhysX."""

from __future__ import annotations

from collections.abc import Iterator

from graph.node import Attribute, Database, NodeAtLoad, node_type

from .polling import Poll, check_polled, poll, release


def _check(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    from wings.physx.names import LIGHT_BEAM

    return check_polled(node, "lightbeamPrim", LIGHT_BEAM)


@node_type(
    "isaacsim.sensors.physx.IsaacReadLightBeam",
    version=1,
    check=_check,
    inputs={
        "execIn": Attribute("execution", "reads the sensor"),
        "lightbeamPrim": Attribute("target", "an IsaacLightBeamSensor"),
    },
    outputs={
        "execOut": Attribute("execution", "follows when there is a reading"),
        "numRays": Attribute("int", "beams of the curtain", default=0),
        "beamHitData": Attribute("bool[]", "whether each beam hits something", default=[]),
        "linearDepthData": Attribute(
            "float[]", "how far each beam goes; maxRange if it hits nothing", default=[], unit="m"
        ),
        "hitPosData": Attribute("pointf[3][]", "where each beam ends, in the sensor's axes", default=[], unit="m"),
        "beamOrigins": Attribute("pointf[3][]", "where each beam begins in the world", default=[], unit="m"),
        "beamEndPoints": Attribute("pointf[3][]", "where each beam ends in the world", default=[], unit="m"),
    },
    memory=Poll,
    release=release,
)
def read_light_beam(db: Database) -> None:
    """Cast the beams of a light curtain at the newest physics step: from minRange on, at the surfaces that lidars see.

    A beam that hits nothing ends minRange + maxRange from the sensor. With a disabled sensor or a stopped timeline
    there is no reading.
    """
    import numpy as np

    from graph.sim.transforms import transformed
    from wings.physx.names import LIGHT_BEAM

    reading, outputs = poll(db, "lightbeamPrim", LIGHT_BEAM, ("xyz", "distance", "flags")), db.outputs
    if reading is None:
        return
    config, pose = reading.config, reading.end.world_sensor
    unit = db.app.meters_per_unit
    starts = np.arange(config.count)[:, None] * (np.array(config.step) * unit)
    starts = starts + np.array(config.forward) * config.ranges[0]
    outputs.numRays = config.count
    outputs.beamHitData = reading.channel("flags") != 0
    outputs.linearDepthData = reading.channel("distance")
    outputs.hitPosData = reading.xyz
    outputs.beamOrigins = transformed(pose, starts).astype(np.float32)
    outputs.beamEndPoints = transformed(pose, reading.xyz.astype(np.float64)).astype(np.float32)
    db.fire("execOut")
