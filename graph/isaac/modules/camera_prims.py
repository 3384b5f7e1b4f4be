"""`Camera` of `isaacsim.core.experimental.objects`: the optics that a Camera prim authors."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.results import Result, numbers, result, rows, words

from .accessors import number, read, text, together, write
from .typed import Typed

__all__ = ["Camera"]
TENTH = 0.1
"""USD counts focal lengths and apertures in tenths of the stage's unit."""


class Camera(Typed):
    kind = "Camera"
    set_focal_lengths, get_focal_lengths = number("focalLength", "focal_lengths", default=50.0, unit=TENTH)
    set_focus_distances, get_focus_distances = number("focusDistance", "focus_distances")
    set_fstops, get_fstops = number("fStop", "fstops")
    set_stereo_roles, get_stereo_roles = text("stereoRole", "stereo_roles", default="mono", argument="roles")
    set_projections, get_projections = text("projection", "projections", default="perspective")
    set_apertures, get_apertures = together(
        ("horizontalAperture", "verticalAperture"),
        "apertures",
        ("horizontal_apertures", "vertical_apertures"),
        (20.955, 15.2908),
        unit=TENTH,
    )
    set_aperture_offsets, get_aperture_offsets = together(
        ("horizontalApertureOffset", "verticalApertureOffset"),
        "aperture_offsets",
        ("horizontal_offsets", "vertical_offsets"),
        (0.0, 0.0),
        unit=TENTH,
    )
    set_shutter_times, get_shutter_times = together(
        ("shutter:open", "shutter:close"), "shutter_times", ("open_times", "close_times"), (0.0, 0.0), kind="double"
    )

    def set_clipping_ranges(
        self, near_distances: Any = None, far_distances: Any = None, *, indices: Any = None
    ) -> None:
        chosen = numbers(indices, len(self))
        ends = [rows(one, len(chosen), None, "distances") for one in (near_distances, far_distances)]
        for row, one in enumerate(chosen):
            held = read(self.prims[one], "clippingRange", (1.0, 1e6))
            range_ = [kept if end is None else float(end[row]) for kept, end in zip(held, ends, strict=True)]
            write(self.prims[one], "clippingRange", "float2", tuple(range_))

    def get_clipping_ranges(self, *, indices: Any = None) -> tuple[Result, Result]:
        found = [read(self.prims[one], "clippingRange", (1.0, 1e6)) for one in numbers(indices, len(self))]
        return result([[near] for near, _ in found]), result([[far] for _, far in found])

    def enforce_square_pixels(self, resolutions: Any, *, modes: Any = "horizontal", indices: Any = None) -> None:
        """Gives one aperture the pixels' size of the other, for pictures of (height, width)."""
        chosen = numbers(indices, len(self))
        sizes = rows(resolutions, len(chosen), 2, "resolutions")
        widths, heights = (one.numpy() for one in self.get_apertures(indices=chosen))
        for row, (one, mode) in enumerate(zip(chosen, words(modes, len(chosen)), strict=True)):
            aspect = 1.0 if sizes is None else sizes[row][1] / sizes[row][0]
            if mode not in ("horizontal", "vertical"):
                raise ValueError(f'the mode is "horizontal" or "vertical", not {mode!r}')
            wanted = (None, widths[row] / aspect) if mode == "horizontal" else (heights[row] * aspect, None)
            have = heights[row] if mode == "horizontal" else widths[row]
            if not np.isclose(have, next(end for end in wanted if end is not None), rtol=1e-5):
                self.set_apertures(*wanted, indices=[one])
