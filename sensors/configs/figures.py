"""The figures of a lidar configuration by which users choose a sensor."""

from __future__ import annotations

from typing import Any

import numpy as np

from sensors.lidar.config import LidarConfig


def arc(azimuth_deg: np.ndarray) -> tuple[float, float]:
    """The smallest arc, first to last counter-clockwise [deg], that holds every azimuth; its middle is in [-180, 180).

    Azimuths at equal steps all round give (0, 360).
    """
    edges = np.unique(np.mod(azimuth_deg.astype(np.float64), 360.0))
    gaps = np.diff(edges, append=edges[0] + 360.0)
    last = int(np.argmax(gaps))
    if len(edges) >= 8 and gaps[last] <= 2 * 360.0 / len(edges):  # equal steps all round: no first azimuth
        return 0.0, 360.0
    start, end = float(edges[(last + 1) % len(edges)]), float(edges[last])
    if start > end:
        start -= 360.0
    turns = 360.0 if (start + end) / 2 >= 180.0 else 0.0
    return start - turns, end - turns


def summary(config: LidarConfig) -> dict[str, Any]:
    """The figures of one configuration: rates [Hz], angles [deg] in the sensor frame, ranges [m], counts.

    `azimuth_deg` of a rotary lidar is its valid window; of a solid-state one, the span of its emitters.
    """
    azimuth = np.concatenate([state.azimuth_deg for state in config.emitter_states])
    elevation = np.concatenate([state.elevation_deg for state in config.emitter_states])
    window = (config.valid_start_azimuth_deg, config.valid_end_azimuth_deg) if config.is_rotary else arc(azimuth)
    return {
        "modality": "lidar",
        "scan_type": config.scan_type,
        "rotation": config.rotation_direction if config.is_rotary else None,
        "scan_rate_hz": float(config.scan_rate_base_hz),
        "firing_rate_hz": float(config.pattern_firing_rate_hz),
        "elevations": int(np.unique(elevation.round(4)).size),
        "emitters": config.number_of_emitters,
        "rays_per_scan": config.rays_per_scan,
        "azimuth_deg": [round(float(edge), 3) for edge in window],
        "elevation_deg": [round(float(elevation.min()), 3), round(float(elevation.max()), 3)],
        "range_m": [config.near_range_m, config.far_range_m],
        "returns": config.max_returns,
        "wavelength_nm": config.wave_length_nm,
    }
