"""Reads image files that a scene names: only from allowed folders, of known formats, and no larger than a limit."""

from __future__ import annotations

import io
import warnings
import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from graph.base.inputs import start_of
from graph.base.limits import allowed, most
from graph.base.records import dataclass

from . import radiance_hdr

FORMATS = ("PNG", "JPEG", "BMP", "TGA", "TIFF", "WEBP")
KNOWN = f"{', '.join(FORMATS)}, HDR"
BYTES_A_PIXEL = 8
HEAD = 1 << 20
"""Largest file: so many bytes for each pixel of the limit, and for its header."""


class ImageProblem(Exception):  # noqa: N818  (named as `graph.base.errors.Problem`)
    """Why an image is not read; the message has no name of a file."""


@dataclass(frozen=True, eq=False)
class Image:
    """pixels: (channels, height, width) uint8 or uint16, the first row on top; 1 to 4 channels: grey, grey and alpha,
    red green blue, the same and alpha. rgbe: whether the fourth is the common exponent of a Radiance picture.
    """

    pixels: np.ndarray
    rgbe: bool = False

    @property
    def colours(self) -> bool:
        """Whether it has three or four channels of 8 bits, which are sRGB if nothing else is said."""
        return bool(self.pixels.dtype == np.uint8 and len(self.pixels) >= 3 and not self.rgbe)


class ImageFiles:
    """The image files of a scene, each read once.

    folders: from which files may be read; None: from any.
    """

    def __init__(self, folders: Iterable[Path] | None) -> None:
        self._folders = None if folders is None else [folder.expanduser().resolve() for folder in folders]
        self._images: dict[str, Image | ImageProblem] = {}
        self._texels = 0

    def read(self, attribute: Any) -> Image:
        """The image that an asset attribute names. Raises ImageProblem."""
        name = self.find(attribute)
        if name not in self._images:
            try:
                self._images[name] = self._open(name)
            except ImageProblem as problem:
                self._images[name] = problem
        found = self._images[name]
        if isinstance(found, ImageProblem):
            raise found
        return found

    def find(self, attribute: Any) -> str:
        """The file of an asset attribute; "a.usdz[b.png]" for one in a package. Raises ImageProblem."""
        value = attribute.Get()
        text = str(getattr(value, "path", value) or "")
        if not text:
            raise ImageProblem("no file is named")
        stack = attribute.GetPropertyStack()
        if stack and stack[0].layer.anonymous and self._folders and not Path(text).is_absolute():
            return str(self._folders[0] / text)  # written in the graph file
        return str(getattr(value, "resolvedPath", "") or text)

    def allowed(self, attribute: Any) -> Path:
        """The file that an asset attribute names, which may be read. Raises ImageProblem."""
        return self._real(Path(self.find(attribute)))

    def _real(self, file: Path) -> Path:
        real = file.resolve()
        if self._folders is not None and not any(real.is_relative_to(folder) for folder in self._folders):
            raise ImageProblem(f"{file.name} lies outside the scene's folders; allow its folder with --allow DIR")
        if not real.is_file():
            raise ImageProblem(f"{file.name} does not exist")
        return real

    def _open(self, name: str) -> Image:
        from graph.sim.usd import Ar

        outer, inner = Ar.SplitPackageRelativePathOuter(name) if Ar.IsPackageRelativePath(name) else (name, "")
        file = Path(outer)
        try:
            real = self._real(file)
            return self._decoded(_contents(real, inner), inner or file.name)
        except (OSError, ValueError, RuntimeError, zipfile.BadZipFile) as error:
            raise ImageProblem(f"{inner or file.name} cannot be read: {error}") from error

    def _decoded(self, data: bytes, name: str) -> Image:
        from PIL import Image as Pillow
        from PIL import UnidentifiedImageError

        if data.startswith(radiance_hdr.MAGIC):
            width, height, _ = radiance_hdr.picture_size(data)
            self._count(name, width, height)
            return Image(_planes(radiance_hdr.decoded(data)), rgbe=True)
        before = Pillow.MAX_IMAGE_PIXELS
        Pillow.MAX_IMAGE_PIXELS = None  # the limit is ours, and checked before anything is decoded
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                with Pillow.open(io.BytesIO(data), formats=FORMATS) as picture:
                    self._count(name, *picture.size)
                    return Image(_planes(_pixels(picture)))
        except ImageProblem:
            raise
        except UnidentifiedImageError:
            raise ImageProblem(f"{name} is not an image of a kind that is read: {KNOWN}") from None
        except Exception as error:  # decoders stumble over damaged files in many ways
            raise ImageProblem(f"{name} is damaged: {error}") from error
        finally:
            Pillow.MAX_IMAGE_PIXELS = before

    def _count(self, name: str, width: int, height: int) -> None:
        """Counts the pixels of an image before they are decoded."""
        if self._texels + width * height > most("camera.texels"):
            with_it = f"{name}: with its {width:,} x {height:,} pixels the textures are too large"
            raise ImageProblem(f"{with_it}; {allowed('camera.texels')}")
        self._texels += width * height


def _contents(file: Path, inner: str) -> bytes:
    """The bytes of a file, or of one in a package; so many that an image of the limit fits."""
    largest = most("camera.texels") * BYTES_A_PIXEL + HEAD
    if inner:
        with zipfile.ZipFile(file) as package, package.open(inner) as stream:
            data = stream.read(largest + 1)
    else:
        data = start_of(file, largest + 1)
    if len(data) > largest:
        raise ImageProblem(f"{inner or file.name} is too large a file; {allowed('camera.texels')}")
    return data


def _pixels(picture: Any) -> np.ndarray:
    """The pixels of a Pillow image."""
    if picture.mode.startswith("I;16") or picture.mode == "I":
        found = np.clip(np.asarray(picture, np.int64), 0, 65535).astype(np.uint16)
    elif picture.mode in ("L", "LA", "RGB", "RGBA"):
        found = np.asarray(picture)
    elif picture.mode == "1":
        found = np.asarray(picture.convert("L"))
    else:
        transparent = picture.mode in ("PA", "RGBa") or "transparency" in picture.info
        found = np.asarray(picture.convert("RGBA" if transparent else "RGB"))
    return found.reshape(*found.shape[:2], -1)


def _planes(pixels: np.ndarray) -> np.ndarray:
    """(channels, height, width) of (height, width, channels): looked up channel by channel it is five times as fast."""
    return np.ascontiguousarray(np.moveaxis(pixels, 2, 0))
