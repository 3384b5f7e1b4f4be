"""The images of lights: skies of domes, textures of rectangles, slides of projectors."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import UserError

from .image_files import ImageFiles, ImageProblem
from .sky import SkyImage, sky_image
from .slides import PATTERN as FILE
from .slides import Slide, read_slide
from .stage_values import text_of
from .textures import Texture, linear_table

if TYPE_CHECKING:
    from pxr import Usd

Warn = Callable[[str, str, str], None]


class LightImages:
    """The images of lights by the paths of their prims, each read when its light first shines."""

    def __init__(self, files: ImageFiles) -> None:
        self._files = files
        self._found: dict[str, Any] = {}

    def sky(self, prim: Usd.Prim, warn: Warn) -> SkyImage | None:
        """That of a dome; None for one of one colour. warn: gets `texture-not-read` and `light-not-modelled`."""
        found: SkyImage | None = self._once(prim, self._sky, "the sky has one plain colour", warn)
        return found

    def mean(self, prim: Usd.Prim, warn: Warn) -> np.ndarray | None:
        """(3,) float32, the mean of a texture; None without one."""
        found: np.ndarray | None = self._once(prim, self._mean, "the light has one plain colour", warn)
        return found

    def slide(self, prim: Usd.Prim, warn: Warn) -> Slide | None:
        """What a projector throws; None if that cannot be read."""
        found: Slide | None = self._once(prim, lambda prim, _: read_slide(prim, self._files), "it stays dark", warn)
        return found

    def _once(self, prim: Usd.Prim, read: Callable[[Any, Warn], Any], instead: str, warn: Warn) -> Any:
        path = str(prim.GetPath())
        if path not in self._found:
            try:
                self._found[path] = read(prim, warn)
            except (ImageProblem, UserError) as problem:
                warn("texture-not-read", path, f"{problem}; {instead}")
                self._found[path] = None
        return self._found[path]

    def _sky(self, prim: Usd.Prim, warn: Warn) -> SkyImage | None:
        layout = text_of(prim.GetAttribute("inputs:texture:format"))
        if self._named(prim) and layout not in ("", "automatic", "latlong"):
            said = f"its image is laid out as {layout}, not latlong: the sky has one colour"
            warn("light-not-modelled", str(prim.GetPath()), said)
            return None
        return sky_image(self._texture(prim, "repeat")) if self._named(prim) else None

    def _mean(self, prim: Usd.Prim, warn: Warn) -> np.ndarray | None:
        return np.array(self._texture(prim, "clamp").mean(range(3)), np.float32) if self._named(prim) else None

    def _named(self, prim: Usd.Prim) -> bool:
        return bool(text_of(prim.GetAttribute(FILE)))

    def _texture(self, prim: Usd.Prim, across: str) -> Texture:
        image = self._files.read(prim.GetAttribute(FILE))
        ones = np.ones(4, np.float32)
        return Texture(image, linear_table(image, "auto"), (across, "clamp"), ones, 0 * ones)
