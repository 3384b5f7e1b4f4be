"""The shipped camera configurations: one data file for each asset, with its imagers as variants."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass
from graph.base.suggest import did_you_mean
from sensors.camera.lens_models import opencv_lens
from sensors.camera.names import LENS, PRIM_TYPE
from sensors.camera.stereo_depth import NAMES, PREFIX, StereoDepth, template_path

from .catalog import shipped
from .spelling import short_name, spellings

if TYPE_CHECKING:
    from pxr import Usd

FILM_MM = 20.955
"""Width of the film of an imager whose focal length is not known: that of a new Camera prim."""
NEAR_M, FAR_M = 0.01, 1e6
"""Distances that a configured camera shows."""
PINHOLE, FISHEYE = "opencvPinhole", "opencvFisheye"


@dataclass(frozen=True, slots=True)
class Imager:
    """One camera of a device.

    resolution: width, height [px]; fov_deg: across the image; equidistant: whether the angle to the axis grows with the
    distance from the centre, else its tangent does; lens: OpenCV's numbers, where they are public. range_m and
    baseline_mm: of a depth measurement; None and 0 without one.
    """

    resolution: tuple[int, int]
    rate_hz: float
    fov_deg: float = 0.0
    equidistant: bool = False
    focal_length_mm: float = 0.0
    film_mm: float = 0.0
    lens: Mapping[str, Any] | None = None
    shutter: str = ""
    range_m: tuple[float, float] | None = None
    baseline_mm: float = 0.0

    @property
    def focal_length_px(self) -> float:
        """Pixels for a unit of the tangent (equidistant: for a radian)."""
        if self.lens is not None:
            return float(self.lens["fx"])
        half = math.radians(self.fov_deg) / 2
        return self.resolution[0] / 2 / (half if self.equidistant else math.tan(half))

    @property
    def fields_deg(self) -> tuple[float, float]:
        """Fields of view across and down [deg]: between the rays of opposite edges, through the middle of the image.

        Its distortion counts; NaN where the lens has no ray for an edge.
        """
        width, height = self.resolution
        edges = np.array([(0, width, width / 2, width / 2), (height / 2, height / 2, 0, height)], np.float64)
        x, y, ahead = opencv_lens(self._model, self._lens_values(), self.resolution).unproject(edges)
        left, right = np.arctan2(x[:2], ahead[:2])
        top, bottom = np.arctan2(y[2:], ahead[2:])
        return math.degrees(right - left), math.degrees(bottom - top)

    def attributes(self) -> dict[str, tuple[str, Any]]:
        """Attribute of a Camera prim -> its USD value type and value; focal length and film in mm."""
        film = self.film_mm or FILM_MM
        focal = self.focal_length_mm or self.focal_length_px * film / self.resolution[0]
        film = focal * self.resolution[0] / self.focal_length_px
        height = film * self.resolution[1] / self.resolution[0]
        sizes = {"focalLength": focal, "horizontalAperture": film, "verticalAperture": height}
        return {**{name: ("float", value) for name, value in sizes.items()}, **self._lens_attributes()}

    @property
    def _model(self) -> str:
        return str((self.lens or {}).get("model", FISHEYE if self.equidistant else PINHOLE))

    def _lens_values(self) -> dict[str, Any]:
        if self.lens is not None:
            return {name: value for name, value in self.lens.items() if name != "model"}
        (width, height), focal = self.resolution, self.focal_length_px
        values = {"imageSize": [width, height], "fx": focal, "fy": focal, "cx": width / 2, "cy": height / 2}
        return {**values, **(dict.fromkeys(("k1", "k2", "k3", "k4"), 0.0) if self.equidistant else {})}

    def _lens_attributes(self) -> dict[str, tuple[str, Any]]:
        if self.lens is None and not self.equidistant:
            return {}
        values = self._lens_values()
        found = {f"{LENS}{self._model}:{name}": ("float", value) for name, value in values.items()}
        found[f"{LENS}{self._model}:imageSize"] = "int2", tuple(values["imageSize"])
        found[f"{LENS}model"] = "token", self._model
        return found

    @property
    def schemas(self) -> list[str]:
        """The API schemas of its attributes."""
        kinds = {PINHOLE: "OpenCvPinhole", FISHEYE: "OpenCvFisheye"}
        bent = self.lens is not None or self.equidistant
        return ["OmniSensorAPI", *([f"OmniLensDistortion{kinds[self._model]}API"] if bent else [])]

    def stereo(self) -> dict[str, float]:
        """Attributes of the render product of a stereo camera; empty for other cameras."""
        if not self.baseline_mm or self.range_m is None:
            return {}
        nearest, farthest = self.range_m
        found = StereoDepth(
            baseline_mm=self.baseline_mm,
            focal_length_pixel=self.focal_length_px,
            sensor_size_pixel=float(self.resolution[0]),
            max_disparity_pixel=float(math.ceil(self.focal_length_px * self.baseline_mm / 1000 / nearest)),
            min_distance=nearest,
            max_distance=farthest,
        )
        fields = ("baseline_mm", "focal_length_pixel", "sensor_size_pixel", "max_disparity_pixel")
        return {PREFIX + NAMES[name]: getattr(found, name) for name in (*fields, "min_distance", "max_distance")}


@dataclass(frozen=True, slots=True)
class CameraAsset:
    """One device: its asset path, further names, and its imagers."""

    path: str
    display_name: str
    is_depth_sensor: bool
    aliases: tuple[str, ...]
    source: str
    imagers: Mapping[str, Imager]
    prim_type: str = PRIM_TYPE

    @property
    def variants(self) -> tuple[str, ...]:
        """The names of its imagers; empty if there is only one."""
        return tuple(self.imagers) if len(self.imagers) > 1 else ()

    @property
    def default(self) -> str | None:
        """The imager that is meant where none is named."""
        return next(iter(self.imagers)) if len(self.imagers) > 1 else None

    @property
    def products(self) -> tuple[str, ...]:
        """Names that choose a variant: always empty."""
        return ()

    @property
    def spellings(self) -> tuple[str, ...]:
        """As of a lidar's asset, and the display name."""
        return spellings(self.path, (*self.aliases, self.display_name))

    @property
    def short_name(self) -> str:
        """The name used in messages."""
        return short_name(self.path, self.aliases or (self.display_name,))

    def imager(self, variant: Any = None) -> Imager:
        """The imager of a name; None is the default. Raises UserError with the existing names."""
        name = next(iter(variant.values()), None) if isinstance(variant, Mapping) else variant
        name = name or next(iter(self.imagers))
        if name not in self.imagers:
            hint = did_you_mean(str(name), self.imagers, f"there are {', '.join(self.imagers)}")
            raise UserError(f"camera config {self.path} has no variant {name!r}{hint}")
        return self.imagers[name]

    def figures(self, variant: Any = None) -> dict[str, Any]:
        """What one imager is like, as `graph sensors` lists it."""
        imager = self.imager(variant)
        across, down = (round(field, 2) for field in imager.fields_deg)
        return {
            "modality": "camera",
            "scan_rate_hz": imager.rate_hz,
            "rays_per_scan": imager.resolution[0] * imager.resolution[1],
            "resolution": list(imager.resolution),
            "azimuth_deg": [-across / 2, across / 2],
            "elevation_deg": [-down / 2, down / 2],
            "range_m": list(imager.range_m or (NEAR_M, FAR_M)),
            "focal_length_px": round(imager.focal_length_px, 3),
            "lens": FISHEYE if imager.equidistant else (imager.lens or {}).get("model", "pinhole"),
            "shutter": imager.shutter,
            "baseline_mm": imager.baseline_mm,
            "is_depth_sensor": self.is_depth_sensor,
        }


@functools.cache
def camera_assets() -> tuple[CameraAsset, ...]:
    """Every shipped camera, ordered by path."""
    found = [
        CameraAsset(
            one["asset"],
            one["display_name"],
            one.get("is_depth_sensor", False),
            tuple(one.get("aliases", ())),
            one["source"],
            {name: _imager(values) for name, values in one["imagers"].items()},
        )
        for one in shipped("data/cameras").values()
    ]
    return tuple(sorted(found, key=lambda asset: asset.path.lower()))


def _imager(values: Mapping[str, Any]) -> Imager:
    span = values.get("rangeM")
    return Imager(
        (values["resolution"][0], values["resolution"][1]),
        values["rateHz"],
        values.get("fovDeg") or values.get("fisheyeFovDeg") or _film_deg(values),
        "fisheyeFovDeg" in values,
        values.get("focalLengthMm", 0.0),
        values.get("apertureMm", (0.0,))[0],
        values.get("lens"),
        values.get("shutter", ""),
        None if span is None else (span[0], span[1]),
        values.get("baselineMm", 0.0),
    )


def _film_deg(values: Mapping[str, Any]) -> float:
    """The field of view across [deg] of a pinhole by its focal length and film; 0 where these are not given."""
    focal, film = values.get("focalLengthMm"), values.get("apertureMm")
    return math.degrees(2 * math.atan(film[0] / 2 / focal)) if focal and film else 0.0


def supported_cameras() -> dict[str, dict[str, Any]]:
    """Asset path -> display name and whether it measures depth: the table SUPPORTED_CAMERA_CONFIGS."""
    return {
        asset.path: {
            "display_name": asset.display_name,
            **({"is_depth_sensor": True} if asset.is_depth_sensor else {}),
        }
        for asset in camera_assets()
    }


def find_camera(config: str) -> CameraAsset:
    """The shipped camera of a name, in any of its spellings. Raises UserError with similar names, or all."""
    if not isinstance(config, str):
        raise UserError("a camera config is text: the name of a shipped camera")
    for asset in camera_assets():
        if config in asset.spellings:
            return asset
    names = [name for asset in camera_assets() for name in asset.spellings]
    there_are = f"there are {', '.join(asset.short_name for asset in camera_assets())}"
    raise UserError(
        f"no camera config {config!r}{did_you_mean(config, names, there_are)} (see SUPPORTED_CAMERA_CONFIGS)"
    )


def author_camera(prim: Usd.Prim, config: str, variant: Any = None, **where: Any) -> None:
    """Writes a shipped camera on a Camera prim: lens, film, clipping distances.

    For a stereo camera it also defines, beside the prim, <prim>_render_product with its baseline, focal length and
    range, which SingleViewDepthCameraSensor copies. Raises UserError for unknown names and variants.
    """
    from graph.sim.usd import Gf, UsdGeom
    from sensors.prim import apply_schemas, write

    imager = find_camera(config).imager(variant)
    apply_schemas(prim, imager.schemas)
    for name, (kind, value) in imager.attributes().items():
        write(prim, name, kind, Gf.Vec2i(*value) if kind == "int2" else value)
    unit = UsdGeom.GetStageMetersPerUnit(prim.GetStage())
    prim.GetAttribute("clippingRange").Set(Gf.Vec2f(NEAR_M / unit, FAR_M / unit))
    _author_template(prim, imager)


def _author_template(prim: Usd.Prim, imager: Imager) -> None:
    from graph.sim.usd import Gf, Sdf, UsdRender
    from sensors.prim import write

    values = imager.stereo()
    if not values:
        return
    product = UsdRender.Product.Define(prim.GetStage(), template_path(str(prim.GetPath())))
    product.CreateCameraRel().SetTargets([prim.GetPath()])
    product.CreateResolutionAttr().Set(Gf.Vec2i(*imager.resolution))
    for name, value in values.items():
        write(product.GetPrim(), name, str(Sdf.ValueTypeNames.Float), value)
