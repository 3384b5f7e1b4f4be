"""Names of radar attributes: camelCase on prims and in files, snake_case in Python."""

from __future__ import annotations

PRIM_TYPE = "OmniRadar"
MODALITY = "RADAR"
AUX_LEVELS = ("NONE", "BASIC")
API = "OmniSensorGenericRadarWpmDmatAPI"
SCAN_API = "OmniSensorGenericRadarWpmDmatScanCfgAPI"
PREFIX = "omni:sensor:WpmDmat:"
SCAN_PREFIX = "omni:sensor:WpmDmat:scan:"


def attribute_name(field: str) -> str:
    """max_range_m -> maxRangeM, cfar_noise_sdev -> cfarNoiseSDev."""
    first, *rest = field.split("_")
    return first + "".join("SDev" if part == "sdev" else part.capitalize() for part in rest)


WAVEFORM_ONLY = (
    *("carrierFrequency", "chirpBandwidth", "chirpDuration", "chirpRepetitionTime", "frequencyStepBetweenChirps"),
    *("fastTimeSamples", "fastTimePaddingSamples", "enableRangeAliasing"),
    *("arrayAzimuthElements", "arrayElevationElements", "azimuthElementSpacing", "elevationElementSpacing"),
    *("azimuthPaddingSamples", "elevationPaddingSamples", "apertureWindowAzimuth", "apertureWindowElevation"),
)
"""Attributes of a scan configuration that only the mode WAVEFORM looks at."""

ALSO_CALLED = {
    "arrayAzimuthElements": "apertureArrayAzimuthElements",
    "arrayElevationElements": "apertureArrayElevationElements",
    "azimuthElementSpacing": "apertureAzimuthElementSpacing",
    "elevationElementSpacing": "apertureElevationElementSpacing",
}
"""Attribute of a scan configuration -> what the schema calls it in some versions."""

WITHOUT_EFFECT = (
    *("rxAntennaCrossGain", "txAntennaCrossGain", "exponentialDecayFactor"),
    *("debugForceDetection", "debugForceRange", "debugForceAz", "debugForceEl", "debugForceV"),
)
"""Attributes of a scan configuration that prims may have and that are not modelled."""
