"""Scattering of flat facets by physical optics, each integrated exactly: sizes may be many wavelengths.

Gordon, "Far-field approximations to the Kirchhoff-Helmholtz representations of scattered fields", IEEE Trans. AP-23
(1975) 590-592: over a flat polygon the phase is linear, so the surface integral is a sum over its edges. Edge
diffraction and creeping waves are not modelled; the result holds for facets of more than a few wavelengths, within
about 40 degrees of the direction of the mirror reflection. Time factor e^{j w t}.
"""

from __future__ import annotations

import numpy as np

FLAT_PHASE = 1e-6
"""|w|^2 A below which the phase over a facet is constant: the edge sum would divide by it."""


FAR_FIELD = 8.0
"""Pieces have FAR_FIELD D^2 / wavelength < R: at 2, the textbook's far field, a disc over four Fresnel zones is 0.6 dB
off, at 8 below 0.1 dB."""


def phase_integral(facets: np.ndarray, wave: np.ndarray) -> np.ndarray:
    """Integral of exp(j w . r) over triangles, complex (n,) [m^2]; r from each triangle's centroid.

    facets: (n, 3, 3) float64, corners [m]; wave: w, (n, 3) [rad/m].
    """
    corners = facets - facets.mean(axis=1, keepdims=True)
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice_area = np.linalg.norm(doubled, axis=1)
    area = twice_area / 2.0
    normals = doubled / np.where(twice_area, twice_area, 1.0)[:, None]
    tangential = wave - np.einsum("ni,ni->n", wave, normals)[:, None] * normals
    squared = np.einsum("ni,ni->n", tangential, tangential)
    flat = squared * area < FLAT_PHASE
    across = np.cross(normals, tangential)
    edges = np.roll(corners, -1, axis=1) - corners
    middles = corners + edges / 2.0
    half_turn = np.einsum("ni,nmi->nm", tangential, edges) / 2.0
    terms = (
        np.einsum("ni,nmi->nm", across, edges)
        * np.exp(1j * np.einsum("ni,nmi->nm", tangential, middles))
        * np.sinc(half_turn / np.pi)
    )
    answer: np.ndarray = np.where(flat, area, terms.sum(axis=1) / (1j * np.where(flat, 1.0, squared)))
    return answer


def backscatter(
    facets: np.ndarray, radar: np.ndarray, wavelength: float, reflection: np.ndarray | complex = 1.0
) -> np.ndarray:
    """Root of the radar cross section of each triangle with its phase at the radar, complex (n,) [m].

    |sum|^2 is the cross section of facets that reflect coherently. A facet is lit from the side that its corners
    circle counter-clockwise; unlit ones give 0. Each facet takes its own distance and direction, so near-field targets
    are right once `refined`. facets: (n, 3, 3) float64 [m], in the frame of `radar` (3,); reflection: coefficients.
    """
    centres = facets.mean(axis=1)
    to_radar = radar - centres
    distances = np.linalg.norm(to_radar, axis=1)
    directions = to_radar / distances[:, None]
    normals = np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    cosines = np.einsum("ni,ni->n", normals, directions) / np.where(lengths, lengths, 1.0)
    number = 2.0 * np.pi / wavelength
    integral = phase_integral(facets, 2.0 * number * directions)
    amplitude = 2.0 * np.sqrt(np.pi) / wavelength * reflection * np.maximum(cosines, 0.0)
    answer: np.ndarray = amplitude * integral * np.exp(-2j * number * distances)
    return answer


def refined(facets: np.ndarray, radar: np.ndarray, wavelength: float) -> tuple[np.ndarray, np.ndarray]:
    """Triangles split until the radar is in the far field of each (see `FAR_FIELD`), and their origins.

    Returns (m, 3, 3) float64 and (m,) indices into `facets`. Splits the longest edge in the middle, so pieces of one
    triangle cover it exactly.
    """
    pending, origin = facets, np.arange(len(facets))
    done: list[np.ndarray] = []
    owners: list[np.ndarray] = []
    while len(pending):
        edges = np.roll(pending, -1, axis=1) - pending
        lengths = np.linalg.norm(edges, axis=2)
        longest = lengths.argmax(axis=1)
        size = lengths.max(axis=1)
        distance = np.linalg.norm(pending.mean(axis=1) - radar, axis=1)
        far = FAR_FIELD * size**2 < wavelength * distance
        done.append(pending[far])
        owners.append(origin[far])
        near = np.flatnonzero(~far)
        order = (longest[near, None] + np.arange(3)) % 3
        first, second, apex = (pending[near, order[:, corner]] for corner in range(3))
        middle = (first + second) / 2.0
        pending = np.concatenate((np.stack((first, middle, apex), 1), np.stack((middle, second, apex), 1)))
        origin = np.concatenate((origin[near], origin[near]))
    return np.concatenate(done), np.concatenate(owners)
