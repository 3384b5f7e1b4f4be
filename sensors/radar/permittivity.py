"""What a surface reflects of a millimetre wave: complex permittivity, Fresnel coefficients, roughness.

Time factor e^{j w t} throughout, so a lossy medium has permittivity e' - j e'' with e'' >= 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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
