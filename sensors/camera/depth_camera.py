"""SingleViewDepthCameraSensor: a camera whose depth is as a stereo camera measures it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from sensors.errors import SensorValueError

from .authoring import RtxCamera
from .sensor import ANNOTATORS, WIDTHS, CameraSensor
from .stereo_depth import NAMES, PREFIX, STEREO_ANNOTATORS, StereoDepth, authored_stereo, read_stereo


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

    def __init__(self, camera: RtxCamera | str, **options: Any) -> None:
        super().__init__(camera, **options)
        self._copy_template()

    @property
    def stereo(self) -> StereoDepth:
        """The values in use."""
        return read_stereo(self._app.stage.GetPrimAtPath(self.render_product.path))

    def set_sensor_baseline(self, baseline: float | None) -> None:
        """Sets the distance of the two imagers [mm]."""
        self._set(baseline_mm=baseline)

    def set_sensor_focal_length(self, focal_length: float | None) -> None:
        """Sets the focal length of the imagers [px]."""
        self._set(focal_length_pixel=focal_length)

    def set_sensor_size(self, size: float | None) -> None:
        """Sets the width of the imagers [px]."""
        self._set(sensor_size_pixel=size)

    def set_sensor_maximum_disparity(self, maximum_disparity: float | None) -> None:
        """Sets the largest disparity that is found [px]."""
        self._set(max_disparity_pixel=maximum_disparity)

    def set_sensor_distance_cutoffs(
        self, minimum_distance: float | None = None, maximum_distance: float | None = None
    ) -> None:
        """Sets the nearest and the farthest distance that is measured [m]."""
        self._set(min_distance=minimum_distance, max_distance=maximum_distance)

    def set_sensor_noise_parameters(self, noise_mean: float | None = None, noise_sigma: float | None = None) -> None:
        """Sets the step and the standard error of disparities [px]; a step of 0 switches both off."""
        self._set(noise_mean=noise_mean, noise_sigma=noise_sigma)

    def set_sensor_disparity_noise_downscale(self, factor: float | None) -> None:
        """Sets the side of the squares that have the same noise [px]."""
        self._set(noise_downscale_factor_pixel=factor)

    def set_enabled_post_processing(self, enabled: bool | None) -> None:
        """Whether depth is measured; if not, it is exact."""
        self._set(enabled=enabled)

    def set_sensor_disparity_confidence(self, confidence_threshold: float | None) -> None:
        """Keeps the confidence below which a disparity counts as not found; it has no effect."""
        self._keep("confidenceThreshold", "Float", confidence_threshold)

    def set_sensor_output_mode(self, output_mode: int | None) -> None:
        """Keeps how depth is painted over the colours, 0 (not at all) to 7; it has no effect."""
        if output_mode is not None and output_mode not in range(8):
            raise SensorValueError(f"{self.path}: output_mode {output_mode}: give a whole number from 0 to 7")
        self._keep("rgbDepthOutputMode", "Int", output_mode)

    def set_enabled_outlier_removal(self, enabled: bool | None) -> None:
        """Keeps whether outliers are removed; it has no effect."""
        self._keep("outlierRemovalEnabled", "Bool", enabled)

    def _keep(self, name: str, kind: str, value: float | bool | None) -> None:
        """Writes a setting without effect on the render product."""
        from graph.sim.usd import Sdf, Usd

        assert value is not None, f"give {name}"
        app, path = self._app, self.render_product.path
        with Usd.EditContext(app.stage, app.stage.GetSessionLayer()):
            prim = app.stage.GetPrimAtPath(path)
            prim.CreateAttribute(PREFIX + name, getattr(Sdf.ValueTypeNames, kind), custom=False).Set(value)
        app.warn("depth-setting-ignored", f"{path}.{name}", f"{PREFIX}{name} has no effect here")

    def _copy_template(self) -> None:
        """Takes what a configuration or an asset says of the camera's render product."""
        from sensors.configs.cameras import template_path

        template = self._app.stage.GetPrimAtPath(template_path(self.authoring_object.prim))
        said = {} if not template else authored_stereo(template)
        if said:
            self._set(**said)

    def _set(self, **values: Any) -> None:
        from graph.sim.usd import Sdf, Usd

        assert any(value is not None for value in values.values()), f"give {' or '.join(values)}"
        stage = self._app.stage
        for name, value in values.items():
            if value is None:
                continue
            if value < 0 or (name in ("sensor_size_pixel", "focal_length_pixel", "baseline_mm") and value <= 0):
                raise SensorValueError(f"{self.path}: {name} {value}: give a number above 0")
            kind = Sdf.ValueTypeNames.Bool if name == "enabled" else Sdf.ValueTypeNames.Float
            with Usd.EditContext(stage, stage.GetSessionLayer()):
                prim = stage.GetPrimAtPath(self.render_product.path)
                prim.CreateAttribute(PREFIX + NAMES[name], kind, custom=False).Set(value)
