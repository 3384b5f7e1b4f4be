"""SingleViewDepthCameraSensor: a camera whose depth is as a stereo camera measures it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, ClassVar

from sensors.errors import SensorValueError

from .authoring import RtxCamera
from .sensor import ANNOTATORS, WIDTHS, CameraSensor
from .stereo_depth import NAMES, PREFIX, STEREO_ANNOTATORS, STEREO_API, StereoDepth, checked, read_stereo

if TYPE_CHECKING:
    from pxr import Usd


class SingleViewDepthCameraSensor(CameraSensor):
    """A `CameraSensor` without rgb and rgba, and with four annotators more.

    These are depth_sensor_distance, depth_sensor_imager, depth_sensor_point_cloud_position (world [m]) and
    depth_sensor_point_cloud_color. What it measures is set on the render product
    (OmniSensorDepthSensorSingleViewAPI), by the setters here; they raise AssertionError where all values are None. How
    confidence, outliers and coloured depth are worked out is not published: their settings are kept, without effect and
    with a warning.
    """

    annotator_specs: ClassVar[Mapping[str, dict[str, Any]]] = {
        **{name: spec for name, spec in ANNOTATORS.items() if name not in ("rgb", "rgba")},
        **{one.name: {"name": one.name} for one in STEREO_ANNOTATORS},
    }

    widths: ClassVar[Mapping[str, int]] = {
        **WIDTHS,
        "depth_sensor_distance": 1,
        "depth_sensor_imager": 1,
        "depth_sensor_point_cloud_position": 3,
        "depth_sensor_point_cloud_color": 4,
    }

    def __init__(self, path: RtxCamera | str, **options: Any) -> None:
        super().__init__(path, **options)
        with self._editing() as prim:
            prim.ApplyAPI(STEREO_API)

    @property
    def stereo(self) -> StereoDepth:
        """The values in use."""
        return read_stereo(self.scene.stage, self.render_product.path, self.render_product.camera_path)

    def set_sensor_baseline(self, baseline: float | None) -> None:
        """Sets the distance of the two imagers [mm]."""
        self._set(baseline_mm=baseline)

    def get_sensor_baseline(self) -> float:
        """The distance of the two imagers [mm]."""
        return self.stereo.baseline_mm

    def set_sensor_focal_length(self, focal_length: float | None) -> None:
        """Sets the focal length of the imagers [px]."""
        self._set(focal_length_pixel=focal_length)

    def get_sensor_focal_length(self) -> float:
        """The focal length of the imagers [px]."""
        return self.stereo.focal_length_pixel

    def set_sensor_size(self, size: float | None) -> None:
        """Sets the width of the imagers [px]."""
        self._set(sensor_size_pixel=size)

    def get_sensor_size(self) -> float:
        """The width of the imagers [px]."""
        return self.stereo.sensor_size_pixel

    def set_sensor_maximum_disparity(self, maximum_disparity: float | None) -> None:
        """Sets the largest disparity that is found [px]."""
        self._set(max_disparity_pixel=maximum_disparity)

    def get_sensor_maximum_disparity(self) -> float:
        """The largest disparity that is found [px]."""
        return self.stereo.max_disparity_pixel

    def set_sensor_distance_cutoffs(
        self, minimum_distance: float | None = None, maximum_distance: float | None = None
    ) -> None:
        """Sets the nearest and the farthest distance that is measured [m]."""
        self._set(min_distance=minimum_distance, max_distance=maximum_distance)

    def get_sensor_distance_cutoffs(self) -> tuple[float, float]:
        """The nearest and the farthest distance that is measured [m]."""
        return self.stereo.min_distance, self.stereo.max_distance

    def set_sensor_noise_parameters(self, noise_mean: float | None = None, noise_sigma: float | None = None) -> None:
        """Sets the step and the standard error of disparities [px]; a step of 0 switches both off."""
        self._set(noise_mean=noise_mean, noise_sigma=noise_sigma)

    def get_sensor_noise_parameters(self) -> tuple[float, float]:
        """The step and the standard error of disparities [px]."""
        return self.stereo.noise_mean, self.stereo.noise_sigma

    def set_sensor_disparity_noise_downscale(self, downscale: float | None) -> None:
        """Sets the side of the squares that have the same noise [px]."""
        self._set(noise_downscale_factor_pixel=downscale)

    def get_sensor_disparity_noise_downscale(self) -> float:
        """The side of the squares that have the same noise [px]."""
        return self.stereo.noise_downscale_factor_pixel

    def set_enabled_post_processing(self, enabled: bool | None) -> None:
        """Whether depth is measured; if not, it is exact."""
        self._set(enabled=enabled)

    def get_enabled_post_processing(self) -> bool:
        """Whether depth is measured; if not, it is exact."""
        return self.stereo.enabled

    def set_sensor_disparity_confidence(self, confidence_threshold: float | None) -> None:
        """Keeps the confidence below which a disparity counts as not found; it has no effect."""
        self._keep("confidenceThreshold", confidence_threshold)

    def get_sensor_disparity_confidence(self) -> float:
        """The confidence that is kept; it has no effect."""
        return float(self._kept("confidenceThreshold"))

    def set_sensor_output_mode(self, mode: int | None) -> None:
        """Keeps how depth is painted over the colours, 0 (not at all) to 7; it has no effect."""
        if mode is not None and mode not in range(8):
            raise SensorValueError(f"{self.path}: mode {mode}: give a whole number from 0 to 7")
        self._keep("rgbDepthOutputMode", mode)

    def get_sensor_output_mode(self) -> int:
        """The output mode that is kept; it has no effect."""
        return int(self._kept("rgbDepthOutputMode"))

    def set_enabled_outlier_removal(self, enabled: bool | None) -> None:
        """Keeps whether outliers are removed; it has no effect."""
        self._keep("outlierRemovalEnabled", enabled)

    def get_enabled_outlier_removal(self) -> bool:
        """Whether outliers would be removed; it has no effect."""
        return bool(self._kept("outlierRemovalEnabled"))

    @property
    def _product_prim(self) -> Usd.Prim:
        return self.scene.stage.GetPrimAtPath(self.render_product.path)

    @contextmanager
    def _editing(self) -> Iterator[Usd.Prim]:
        """The render product's prim; what is authored on it meanwhile goes to the session layer."""
        from graph.sim.usd import Usd

        with Usd.EditContext(self.scene.stage, self.scene.stage.GetSessionLayer()):
            yield self._product_prim

    def _kept(self, name: str) -> Any:
        return self._product_prim.GetAttribute(PREFIX + name).Get()

    def _keep(self, name: str, value: float | bool | None) -> None:
        """Writes a setting without effect on the render product."""
        assert value is not None, f"give {name}"
        number = checked(f"{self.path}: {name}", name, value)
        with self._editing() as prim:
            attribute = prim.GetAttribute(PREFIX + name)
            attribute.Set(type(attribute.Get())(number))
        where = f"{self.render_product.path}.{name}"
        self.scene.warn("depth-setting-ignored", where, f"{PREFIX}{name} has no effect here")

    def _set(self, **values: Any) -> None:
        assert any(value is not None for value in values.values()), f"give {' or '.join(values)}"
        given = {
            name: checked(f"{self.path}: {name}", name, value) for name, value in values.items() if value is not None
        }
        with self._editing() as prim:
            for name, value in given.items():
                prim.GetAttribute(PREFIX + NAMES[name]).Set(value)
