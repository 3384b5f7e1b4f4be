"""Names of acoustic sensors: prim type, schemas, attributes and channels."""

from __future__ import annotations

import numpy as np

from sensors.channels import Channel

PRIM_TYPE = "OmniAcoustic"
MODALITY = "ACOUSTIC"
AUX_LEVELS = ("NONE", "BASIC")
API = "OmniSensorGenericAcousticWpmAPI"
PREFIX = "omni:sensor:WpmAcoustic:"
MOUNT_API, MOUNT_PREFIX = "OmniSensorWpmAcousticSensorMountAPI", f"{PREFIX}sensorMount:"
GROUP_API, GROUP_PREFIX = "OmniSensorWpmAcousticRxGroupAPI", f"{PREFIX}rxGroup:"
FIRING_API, FIRING_PREFIX = "OmniSensorWpmAcousticFiringSeqAPI", f"{PREFIX}firingSeq:"

FAMILIES = {MOUNT_PREFIX: MOUNT_API, GROUP_PREFIX: GROUP_API, FIRING_PREFIX: FIRING_API}
"""Prefix of attributes -> the schema whose instances have them."""

OWN_CHANNELS = (  # x, y and z of a GenericModelOutput
    Channel("txMount", np.dtype("<u4"), doc="number of the mount that sent"),
    Channel("rxMount", np.dtype("<u4"), doc="number of the mount that heard"),
    Channel("wayChannel", np.dtype("<u4"), doc="channel of the signal way"),
)
