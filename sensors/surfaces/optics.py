"""Optical properties of surfaces for lasers: reflectance by non-visual material, near infrared (about 905 nm)."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from graph.base.records import dataclass

from .material_codes import decode

DEFAULT_REFLECTANCE = 0.5
"""Reflectance of a surface without a non-visual material."""

REFLECTANCE = {
    # Wehr and Lohr, "Airborne laser scanning: an introduction and overview", ISPRS Journal 54 (1999), table of diffuse
    # reflectivities at 900 nm: lumber 0.94, snow 0.8 to 0.9, white paper up to 1, leaves about 0.6, conifers about 0.3,
    # limestone and clay up to 0.75, dry sand about 0.57, rough wood 0.25, concrete 0.24, asphalt 0.17, neoprene 0.05.
    "asphalt": 0.17,
    "concrete": 0.24,
    "wood": 0.6,
    "bark": 0.3,
    "paper": 0.9,
    "leaf_grass": 0.6,
    "snow": 0.85,
    "rubber": 0.05,
    "stone": 0.4,
    "marble": 0.7,
    # Estimated from the values above, from common reflectances of plastics and metals, and from Fresnel's 4 % for each
    # face of glass; no public table gives them.
    "none": DEFAULT_REFLECTANCE,
    "aluminum": 0.6,
    "steel": 0.5,
    "oxidized_steel": 0.3,
    "iron": 0.45,
    "oxidized_iron": 0.3,
    "silver": 0.7,
    "brass": 0.6,
    "bronze": 0.5,
    "oxidized_bronze_patina": 0.3,
    "tin": 0.5,
    "plastic": 0.5,
    "fiberglass": 0.5,
    "carbon_fiber": 0.08,
    "vinyl": 0.4,
    "plexiglass": 0.04,
    "pvc": 0.5,
    "nylon": 0.5,
    "polyester": 0.5,
    "clear_glass": 0.04,
    "frosted_glass": 0.4,
    "one_way_mirror": 0.3,
    "mirror": 0.05,
    "ceramic_glass": 0.2,
    "dead_leaf_grass": 0.45,
    "cardboard": 0.6,
    "fabric": 0.5,
    "skin": 0.5,
    "fur_hair": 0.4,
    "leather": 0.4,
    "brick": 0.4,
    "gravel": 0.3,
    "dirt": 0.3,
    "mud": 0.2,
    "water": 0.03,
    "salt_water": 0.03,
    "ice": 0.3,
    "calibration_lambertion": 0.99,
}
"""Fraction of the light that a diffuse surface of each base material reflects, along its normal."""

CLEAR = ("clear_glass", "plexiglass")
"""Transparent bases; every material with the attribute `visually_transparent` is transparent too."""

GLASS_FACE = 0.04
"""Reflectance of one face of a transparent surface:

Fresnel's at normal incidence, ((n - 1) / (n + 1))^2 with n = 1.5. A pane modelled as a solid has two faces.
"""

PAINTED = 0.5
"""Reflectance of paint, on any base (estimated)."""

CLEARCOAT = 0.96**2
"""Transmission of a clear coat, in and out: a surface of refractive index 1.5 reflects 4 %."""

RETRO_GAIN = 785.0
"""Light from a retro-reflector, relative to a white diffuse surface: pi times the coefficient of retro-reflection
250 cd/(lx m^2) that ASTM D4956 requires of white type III sheeting; independent of incidence here.
"""


@dataclass(frozen=True)
class Optics:
    """Optical properties of the surfaces of a world; arrays with one entry for each surface.

    reflectance: (n,) float32, 0 to 1. retro: (n,) bool. passing: (n,) float32, the fraction of the light that passes on
    its way there and back; 0 for opaque surfaces.
    """

    reflectance: np.ndarray
    retro: np.ndarray
    passing: np.ndarray

    @cached_property
    def has_glass(self) -> bool:
        """Whether light passes through any surface."""
        return bool(self.passing.any())


def optics_of(materials: np.ndarray) -> Optics:
    """The optics of surfaces with these encoded materials, (n,)."""
    known, which = np.unique(np.asarray(materials, np.int64), return_inverse=True)
    decoded = [decode(int(number)) for number in known]
    reflectance = np.array([reflectance_of(base, coating) for base, coating, _ in decoded], np.float32)
    retro = np.array(["retroreflective" in attributes for _, _, attributes in decoded], bool)
    glass = np.array([base in CLEAR or "visually_transparent" in attributes for base, _, attributes in decoded], bool)
    reflectance[glass] = GLASS_FACE
    passing = np.where(glass, (1 - reflectance) ** 2, 0).astype(np.float32)
    return Optics(reflectance[which], retro[which], passing[which])


def reflectance_of(base: str, coating: str = "none") -> float:
    """The reflectance of a coated material, 0 to 1."""
    bare = PAINTED if coating in ("paint", "paint_clearcoat") else REFLECTANCE[base]
    return bare * CLEARCOAT if coating in ("clearcoat", "paint_clearcoat") else bare
