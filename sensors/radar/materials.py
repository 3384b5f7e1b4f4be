"""What non-visual materials are to a millimetre wave."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sensors.surfaces.material_codes import decode

from .permittivity import MEDIA, Medium, reflection

STEPS = 256
"""Entries of a table over the cosine of incidence."""

_METALS = (
    *("aluminum", "steel", "oxidized_steel", "iron", "oxidized_iron", "silver", "brass", "bronze"),
    *("oxidized_bronze_patina", "tin", "one_way_mirror", "mirror", "carbon_fiber"),
)
BASES: dict[str, Medium] = {
    # ITU-R P.2040-3, see `permittivity.MEDIA`.
    **dict.fromkeys(("none", *_METALS), MEDIA["metal"]),
    "concrete": MEDIA["concrete"],
    **dict.fromkeys(("clear_glass", "frosted_glass", "ceramic_glass"), MEDIA["glass"]),
    "wood": MEDIA["wood"],
    "cardboard": MEDIA["chipboard"],
    # Estimated from the P.2040 figures of what is nearest, with nominal roughness: not for measurements.
    "brick": Medium(3.91, 0.0238, 0.16, roughness=0.5e-3),
    **dict.fromkeys(("stone", "marble"), Medium(5.24, 0.0462, 0.7822, roughness=0.2e-3)),
    "asphalt": Medium(5.24, 0.0462, 0.7822, roughness=1e-3),
    **dict.fromkeys(("gravel", "dirt", "mud"), Medium(4.0, 0.0462, 0.7822, roughness=3e-3)),
    **dict.fromkeys(
        ("plastic", "fiberglass", "plexiglass", "pvc", "nylon", "polyester", "vinyl"), Medium(2.7, 1e-3, 1.0)
    ),
    **dict.fromkeys(("rubber", "leather"), Medium(3.0, 0.01, 1.0, roughness=0.2e-3)),
    **dict.fromkeys(("paper", "fabric", "fur_hair", "bark"), Medium(1.6, 0.005, 1.0, roughness=0.5e-3)),
    **dict.fromkeys(("leaf_grass", "dead_leaf_grass"), Medium(2.0, 0.1, 1.0, roughness=3e-3)),
    **dict.fromkeys(("snow",), Medium(1.5, 1e-4, 1.0, roughness=1e-3)),
    "ice": Medium(3.15, 1e-4, 1.0),
    **dict.fromkeys(("water", "salt_water"), Medium(6.9, 0.667, 1.0)),
    "skin": Medium(6.6, 0.495, 1.0),
    "calibration_lambertion": Medium(2.7, 1e-3, 1.0, roughness=3e-3),
}
"""Base of a non-visual material -> its medium. A surface whose material says nothing is a smooth conductor."""


class Tables(NamedTuple):
    """Reflection over the cosine of incidence, `steps` places one after the other for each material.

    amplitude: complex64, what is reflected coherently; diffuse: float32, share of the power that a rough surface
    scatters to all sides (Lambert).
    """

    amplitude: np.ndarray
    diffuse: np.ndarray
    steps: int


class Reflections:
    """Reflection of the surfaces of a world at one wavelength; materials: (n,) encoded ones, of every surface."""

    def __init__(self, materials: np.ndarray, wavelength: float) -> None:
        known, which = np.unique(np.asarray(materials, np.int64), return_inverse=True)
        cosine = (np.arange(STEPS) + 0.5) / STEPS
        media = [BASES[decode(int(number))[0]] for number in known] or [BASES["none"]]
        smooth = [reflection(Medium(m.a, m.c, m.d, m.b, thickness=m.thickness), cosine, wavelength) for m in media]
        rough = [reflection(medium, cosine, wavelength) for medium in media]
        lost = [np.abs(s) ** 2 - np.abs(r) ** 2 for s, r in zip(smooth, rough, strict=True)]
        self.tables = Tables(np.array(rough, np.complex64).reshape(-1), np.array(lost, np.float32).reshape(-1), STEPS)
        self._of_surface = (which * STEPS).astype(np.int32) if len(materials) else np.zeros(1, np.int32)

    def of_surfaces(self, surfaces: np.ndarray) -> np.ndarray:
        """The first places (k,) int32 of surfaces (k,) in the tables."""
        return np.asarray(np.take(self._of_surface, surfaces, mode="clip"))
