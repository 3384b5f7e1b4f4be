"""Names of PhysX sensors: prim types, and the channel that only they have."""

from __future__ import annotations

import numpy as np

from sensors.channels import CHANNELS, Channel

LIDAR = "Lidar"
LIGHT_BEAM = "IsaacLightBeamSensor"

BEAM_TIME = Channel(
    "beamTime", np.dtype("<f4"), unit="s", doc="simulation time of the update in which the beam was fired"
)
BEAM_CHANNELS = (CHANNELS["xyz"], CHANNELS["distance"], CHANNELS["flags"])
