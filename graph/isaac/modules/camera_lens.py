"""The lens and the shutter of the class Camera: projection, stereo role, and the schemas of lens distortion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from graph.isaac.session import app
from graph.sim.scene.prim_attributes import set_property
from sensors.camera.lens_models import MODELS, NOMINAL, lens_model
from sensors.camera.names import LENS, LENS_MODEL

from .old_prims import SingleXFormPrim
from .own_schemas import applied
from .prim_base import attribute

_SCHEMA = "OmniLensDistortion"
_NOMINAL = ("nominal_height", "nominal_width", "optical_center", "max_fov")
_OPENCV = ("cx", "cy", "fx", "fy")
_TEXTURES = ("ray_enter_direction_texture", "ray_exit_position_texture")
_BROWN = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4")
"""Coefficients in OpenCV's order."""


def _attribute_name(argument: str) -> str:
    first, *others = argument.split("_")
    return first + "".join(map(str.capitalize, others))


def _properties(model: str, arguments: Sequence[str], numbers: str = "", names: Sequence[str] = ()) -> tuple[Any, Any]:
    """The setter and the getter of a lens model: they take and give the arguments, then its coefficients as a list."""
    parameters = (*arguments, numbers) if numbers else tuple(arguments)

    def put(self: CameraLens, *values: Any, **named: Any) -> None:
        given = {**dict(zip(parameters, values, strict=False)), **named}
        if unknown := given.keys() - {*parameters}:
            raise TypeError(f"a lens of the model {model} takes {', '.join(parameters)}, not {', '.join(unknown)}")
        self.set_lens_distortion_model(_SCHEMAS[model])
        coefficients = given.pop(numbers, None) or ()
        found = {_attribute_name(name): value for name, value in given.items()}
        found |= dict(zip(names, coefficients, strict=False))
        if model.startswith("opencv"):
            found["imageSize"] = self.get_resolution()
        for name, value in found.items():
            if value is not None:
                set_property(self.prim, f"{LENS}{model}:{name}", value)

    def get(self: CameraLens) -> tuple[Any, ...] | None:
        if lens_model(self.prim) != model:
            app().warn("camera-lens-other", self.prim_path, f"its lens is {self.get_lens_distortion_model()}")
            return None
        held = {name: self.prim.GetAttribute(f"{LENS}{model}:{name}").Get() for name in names}
        found = [self.prim.GetAttribute(f"{LENS}{model}:{_attribute_name(name)}").Get() for name in arguments]
        return (*found, list(held.values())) if numbers else tuple(found)

    return put, get


def _coefficients(model: str) -> tuple[str, ...]:
    return tuple(name for name in MODELS[model] if name not in NOMINAL)


_SCHEMAS = {
    model: f"{_SCHEMA}{name}API"
    for model, name in {
        "opencvPinhole": "OpenCvPinhole",
        "opencvFisheye": "OpenCvFisheye",
        "ftheta": "Ftheta",
        "kannalaBrandtK3": "KannalaBrandtK3",
        "radTanThinPrism": "RadTanThinPrism",
        "lut": "Lut",
    }.items()
}


class CameraLens(SingleXFormPrim):
    get_resolution: Callable[[], tuple[int, int]]
    get_focal_length: Callable[[], float]
    get_horizontal_aperture: Callable[[], float]
    get_vertical_aperture: Callable[[], float]

    set_ftheta_properties, get_ftheta_properties = _properties(
        "ftheta", _NOMINAL, "distortion_coefficients", _coefficients("ftheta")
    )
    set_kannala_brandt_k3_properties, get_kannala_brandt_k3_properties = _properties(
        "kannalaBrandtK3", _NOMINAL, "distortion_coefficients", _coefficients("kannalaBrandtK3")
    )
    set_rad_tan_thin_prism_properties, get_rad_tan_thin_prism_properties = _properties(
        "radTanThinPrism", _NOMINAL, "distortion_coefficients", _coefficients("radTanThinPrism")
    )
    set_lut_properties, get_lut_properties = _properties("lut", (*_NOMINAL[:3], *_TEXTURES))
    set_opencv_pinhole_properties, get_opencv_pinhole_properties = _properties(
        "opencvPinhole", _OPENCV, "pinhole", _BROWN
    )
    set_opencv_fisheye_properties, get_opencv_fisheye_properties = _properties(
        "opencvFisheye", _OPENCV, "fisheye", ("k1", "k2", "k3", "k4")
    )

    def set_fisheye_polynomial_properties(
        self,
        nominal_width: float | None,
        nominal_height: float | None,
        optical_centre_x: float | None,
        optical_centre_y: float | None,
        max_fov: float | None,
        polynomial: Sequence[float] | None,
    ) -> None:
        """The lens of the model ftheta, by its former arguments; None leaves a value."""
        if "fisheye" not in self.get_projection_type():
            raise ValueError(f"{self.prim_path}: call set_projection_type('fisheyePolynomial') first")
        x, y = self.get_ftheta_properties()[2]
        centre = (
            x if optical_centre_x is None else optical_centre_x,
            y if optical_centre_y is None else optical_centre_y,
        )
        self.set_ftheta_properties(nominal_height, nominal_width, centre, max_fov, polynomial)

    def get_fisheye_polynomial_properties(self) -> tuple[Any, ...]:
        height, width, centre, field, numbers = self.get_ftheta_properties()
        return width, height, *centre, field, numbers

    def get_lens_distortion_model(self) -> str:
        return lens_model(self.prim) or "pinhole"

    def set_lens_distortion_model(self, value: str) -> None:
        """Applies a schema of lens distortion; "pinhole" removes it."""
        tokens = {schema: model for model, schema in _SCHEMAS.items()}
        if value == "pinhole":
            for schema in (one for one in applied(self.prim) if one.startswith(_SCHEMA)):
                self.prim.RemoveAppliedSchema(schema)
            self.prim.RemoveProperty(LENS_MODEL)
        elif value in tokens:
            self.prim.ApplyAPI(value)
            self.prim.GetAttribute(LENS_MODEL).Set(tokens[value])
        else:
            self._refuse("lens distortion model", value, ("pinhole", *tokens))

    def set_rational_polynomial_properties(
        self,
        nominal_width: float,
        nominal_height: float,
        optical_centre_x: float,
        optical_centre_y: float,
        max_fov: float | None,
        distortion_model: Sequence[float],
    ) -> None:
        focal = self._focal(nominal_width, nominal_height)
        self.set_opencv_pinhole_properties(optical_centre_x, optical_centre_y, *focal, distortion_model)

    def set_kannala_brandt_properties(
        self,
        nominal_width: float,
        nominal_height: float,
        optical_centre_x: float,
        optical_centre_y: float,
        max_fov: float | None,
        distortion_model: Sequence[float],
    ) -> None:
        focal = self._focal(nominal_width, nominal_height)
        self.set_opencv_fisheye_properties(optical_centre_x, optical_centre_y, *focal, distortion_model)

    def _focal(self, width: float, height: float) -> tuple[float, float]:
        """The focal lengths [px] across and down of an image."""
        focal = self.get_focal_length()
        return width * focal / self.get_horizontal_aperture(), height * focal / self.get_vertical_aperture()

    def get_projection_type(self) -> str:
        found = self.prim.GetAttribute("cameraProjectionType")
        return str(found.Get()) if found else "pinhole"

    def set_projection_type(self, value: str) -> None:
        """Keeps a former name of a lens on the prim; only pinhole and fisheyePolynomial are lenses here."""
        known = {"pinhole": "pinhole", "fisheyePolynomial": _SCHEMAS["ftheta"]}
        if value in known:
            self.set_lens_distortion_model(known[value])
        else:
            self._refuse("projection type", value, tuple(known))
        attribute(self.prim, "cameraProjectionType", "string", value)

    def get_projection_mode(self) -> str:
        return str(self.prim.GetAttribute("projection").Get())

    def set_projection_mode(self, value: str) -> None:
        self._choose("projection", value, ("perspective", "orthographic"))

    def get_stereo_role(self) -> str:
        return str(self.prim.GetAttribute("stereoRole").Get())

    def set_stereo_role(self, value: str) -> None:
        self._choose("stereoRole", value, ("mono", "left", "right"))

    def get_shutter_properties(self) -> tuple[float, float]:
        return self.prim.GetAttribute("shutter:open").Get(), self.prim.GetAttribute("shutter:close").Get()

    def set_shutter_properties(self, delay_open: float | None = None, delay_close: float | None = None) -> None:
        for name, value in (("shutter:open", delay_open), ("shutter:close", delay_close)):
            if value:
                self.prim.GetAttribute(name).Set(value)

    def _choose(self, name: str, value: str, known: Sequence[str]) -> None:
        if value in known:
            self.prim.GetAttribute(name).Set(value)
        else:
            self._refuse(name, value, known)

    def _refuse(self, what: str, value: str, known: Sequence[str]) -> None:
        app().warn("camera-value-unknown", self.prim_path, f"{what} {value!r} is left out; known: {', '.join(known)}")
