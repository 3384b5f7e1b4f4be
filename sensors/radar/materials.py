"""What non-visual materials are to a millimetre wave."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sensors.surfaces.material_codes import decode

SPEED_OF_LIGHT = 299_792_458.0
"""[m/s], exact by definition."""


@dataclass(frozen=True, slots=True)
class Medium:
    """A building material after ITU-R P.2040-3, table 3: e' = a f^b, conductivity = c f^d S/m, f in GHz.

    thickness: of a slab [m]; 0 is a half space. roughness: rms height of the surface [m].
    """

    a: float
    c: float
    d: float
    b: float = 0.0
    thickness: float = 0.0
    roughness: float = 0.0

    def permittivity(self, wavelength: float) -> complex:
        """Relative permittivity at a wavelength [m]; P.2040-3 equation 9b: e'' = 17.98 x conductivity / f."""
        frequency = SPEED_OF_LIGHT / wavelength / 1e9
        return complex(self.a * frequency**self.b, -17.98 * self.c * frequency**self.d / frequency)


MEDIA = {
    "concrete": Medium(5.24, 0.0462, 0.7822, roughness=0.05e-3),
    "glass": Medium(6.31, 0.0036, 1.3394, thickness=4e-3),
    "wood": Medium(1.99, 0.0047, 1.0718, roughness=0.05e-3),
    "plasterboard": Medium(2.73, 0.0085, 0.9395),
    "chipboard": Medium(2.58, 0.0217, 0.78),
    "floorboard": Medium(3.66, 0.0044, 1.3515),
    "metal": Medium(1.0, 1e7, 0.0),
}
"""P.2040-3, valid at 76 to 81 GHz; thickness and roughness are nominal figures of ours: smooth as cast and planed."""


def fresnel(permittivity: complex, cos_incidence: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Reflection coefficients (TE, TM) of a half space, complex, of the shape of cos_incidence (from 0 to 1).

    P.2040-3 equations 31a and 31b.
    """
    cos = np.asarray(cos_incidence, np.float64)
    q = np.sqrt(permittivity - (1.0 - cos**2))
    return (cos - q) / (cos + q), (permittivity * cos - q) / (permittivity * cos + q)


def slab(reflection: np.ndarray, permittivity: complex, cos_incidence: np.ndarray, depth: float) -> np.ndarray:
    """Reflection coefficient of a slab `depth` wavelengths thick, from that of its half space.

    P.2040-3 equation 37: both faces reflect, and the wave loses and turns its phase inside.
    """
    q = np.sqrt(permittivity - (1.0 - np.asarray(cos_incidence, np.float64) ** 2))
    inside = np.exp(-4j * np.pi * depth * q)
    answer: np.ndarray = reflection * (1.0 - inside) / (1.0 - reflection**2 * inside)
    return answer


def reflection(medium: Medium, cos_incidence: np.ndarray, wavelength: float) -> np.ndarray:
    """Amplitude that comes back coherently, complex: the mean of TE and TM with the sign of TE, less roughness.

    A radar that sends and receives one linear polarisation sees TE on one axis and TM on the other; facets lie at any
    angle to it, so both count half. TM has the opposite sign by convention. Roughness of rms height h takes
    exp(-(2 k h cos)^2) of the power (Ament 1953).
    """
    cos = np.asarray(cos_incidence, np.float64)
    permittivity = medium.permittivity(wavelength)
    te, tm = fresnel(permittivity, cos)
    if medium.thickness:
        depth = medium.thickness / wavelength
        te, tm = slab(te, permittivity, cos, depth), slab(tm, permittivity, cos, depth)
    height = 4.0 * np.pi * medium.roughness / wavelength
    answer: np.ndarray = (te - tm) / 2.0 * np.exp(-((height * cos) ** 2) / 2.0)
    return answer


STEPS = 256
"""Entries of a table over the cosine of incidence."""

_METALS = (
    *("aluminum", "steel", "oxidized_steel", "iron", "oxidized_iron", "silver", "brass", "bronze"),
    *("oxidized_bronze_patina", "tin", "one_way_mirror", "mirror", "carbon_fiber"),
)
BASES: dict[str, Medium] = {
    # ITU-R P.2040-3, see `MEDIA`.
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
