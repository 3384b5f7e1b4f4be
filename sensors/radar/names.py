"""Names of radar attributes: camelCase on prims and in files, snake_case in Python."""

from __future__ import annotations

PRIM_TYPE = "OmniRadar"
MODALITY = "RADAR"
API = "OmniSensorGenericRadarWpmDmatAPI"
SCAN_API = "OmniSensorGenericRadarWpmDmatScanCfgAPI"
PREFIX = "omni:sensor:WpmDmat:"
SCAN_PREFIX = "omni:sensor:WpmDmat:scan:"


def attribute_name(field: str) -> str:
    """max_range_m -> maxRangeM, cfar_noise_sdev -> cfarNoiseSDev."""
    first, *rest = field.split("_")
    return first + "".join("SDev" if part == "sdev" else part.capitalize() for part in rest)


CHIRPS = (
    *("carrierFrequency", "chirpBandwidth", "chirpDuration", "chirpRepetitionTime", "frequencyStepBetweenChirps"),
    *("fastTimeSamples", "fastTimePaddingSamples", "enableRangeAliasing"),
)
"""Attributes of a scan configuration that only the mode WAVEFORM looks at."""

WITHOUT_EFFECT = (
    *("azimuthPaddingSamples", "elevationPaddingSamples"),
    *("rxAntennaCrossGain", "txAntennaCrossGain", "exponentialDecayFactor"),
    *("arrayAzimuthElements", "arrayElevationElements", "azimuthElementSpacing", "elevationElementSpacing"),
    *("apertureArrayAzimuthElements", "apertureArrayElevationElements", "apertureAzimuthElementSpacing"),
    *("apertureElevationElementSpacing", "apertureWindowAzimuth", "apertureWindowElevation"),
    *("debugForceDetection", "debugForceRange", "debugForceAz", "debugForceEl", "debugForceV"),
)
"""Attributes of a scan configuration that prims may have and that are not modelled."""
