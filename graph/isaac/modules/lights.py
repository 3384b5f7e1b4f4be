"""`Light` and its kinds in `isaacsim.core.experimental.objects`."""

from __future__ import annotations

from typing import Any

from graph.isaac.results import Result, numbers, result
from graph.sim.usd import UsdLux

from .accessors import colors_of, number, read, text, together, write
from .typed import Typed

__all__ = ["CylinderLight", "DiskLight", "DistantLight", "DomeLight", "Light", "RectLight", "SphereLight"]


class Light(Typed):
    set_intensities, get_intensities = number("inputs:intensity", "intensities")
    set_exposures, get_exposures = number("inputs:exposure", "exposures")
    set_multipliers, get_multipliers = together(
        ("inputs:diffuse", "inputs:specular"),
        "multipliers",
        ("diffuse_multipliers", "specular_multipliers"),
        (1.0, 1.0),
    )
    set_enabled_normalizations, get_enabled_normalizations = number(
        "inputs:normalize", "enabled_normalizations", "bool", argument="enabled"
    )
    set_enabled_color_temperatures, get_enabled_color_temperatures = number(
        "inputs:enableColorTemperature", "enabled_color_temperatures", "bool", argument="enabled"
    )
    set_color_temperatures, get_color_temperatures = number("inputs:colorTemperature", "color_temperatures")
    set_radii, get_radii = number("inputs:radius", "radii")
    set_lengths, get_lengths = number("inputs:length", "lengths")
    set_widths, get_widths = number("inputs:width", "widths")
    set_heights, get_heights = number("inputs:height", "heights")
    set_angles, get_angles = number("inputs:angle", "angles")
    set_texture_files, get_texture_files = text("inputs:texture:file", "texture_files", "asset")

    @property
    def lights(self) -> list[Any]:
        return [getattr(UsdLux, self.kind)(prim) for prim in self.prims]

    def set_colors(self, colors: Any, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        given = colors_of(colors, len(chosen))
        for one, color in zip(chosen, () if given is None else given, strict=given is not None):
            write(self.prims[one], "inputs:color", "color3f", tuple(map(float, color)))

    def get_colors(self, *, indices: Any = None) -> Result:
        return result([read(self.prims[one], "inputs:color", (1, 1, 1)) for one in numbers(indices, len(self))])


class CylinderLight(Light):
    kind = "CylinderLight"
    set_enabled_treat_as_lines, get_enabled_treat_as_lines = number(
        "treatAsLine", "enabled_treat_as_lines", "bool", argument="enabled"
    )


class DiskLight(Light):
    kind = "DiskLight"


class DistantLight(Light):
    kind = "DistantLight"


class DomeLight(Light):
    kind = "DomeLight"
    set_guide_radii, get_guide_radii = number("guideRadius", "guide_radii", argument="radii")
    set_radii, get_radii = set_guide_radii, get_guide_radii
    set_texture_formats, get_texture_formats = text("inputs:texture:format", "texture_formats")


class RectLight(Light):
    kind = "RectLight"


class SphereLight(Light):
    kind = "SphereLight"
    set_enabled_treat_as_points, get_enabled_treat_as_points = number(
        "treatAsPoint", "enabled_treat_as_points", "bool", argument="enabled"
    )
