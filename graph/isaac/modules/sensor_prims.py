"""Authoring of `isaacsim.sensors.experimental.physics`: IMU, Contact, Raycast, one prim each."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.results import rows
from graph.sim.usd import Gf, Sdf, UsdPhysics, Vt
from sensors.inertial import attribute_of

from .prim_base import attribute, found_or_new
from .stage import generate_next_free_path, usd_stage
from .xform_prim import XformPrim

__all__ = ["IMU", "Contact", "Raycast"]


class SensorPrim(XformPrim):
    """Makes a missing prim of its type. Raises ValueError for a prim of another, and for more than one prim."""

    kind = ""

    def __init__(
        self,
        path: Any,
        *,
        positions: Any = None,
        translations: Any = None,
        orientations: Any = None,
        scales: Any = None,
        reset_xform_op_properties: bool = True,
        **options: Any,
    ) -> None:
        found = found_or_new(path)
        if len(found) != 1:
            raise ValueError(f"{path} stands for {len(found)} prims; give the path of one")
        text, stage = found[0], usd_stage()
        prim = stage.GetPrimAtPath(text)
        if prim and str(prim.GetTypeName()) != self.kind:
            raise ValueError(f"{text} is a {prim.GetTypeName() or 'prim without a type'}, not an {self.kind}")
        if positions is not None and translations is not None:
            raise ValueError("positions (world) and translations (local) exclude each other")
        fresh = not prim
        self.check(text, fresh, options)
        if fresh:
            prim = stage.DefinePrim(text, self.kind)
            attribute(prim, "enabled", "bool", True)
        self.author(prim, fresh, **options)
        super().__init__(
            text,
            resolve_paths=False,
            positions=positions,
            translations=translations,
            orientations=orientations,
            scales=scales,
            reset_xform_op_properties=reset_xform_op_properties,
        )

    @classmethod
    def create(cls, path: str, **kwargs: Any) -> Any:
        text = path.rstrip("/")
        if text.count("/") < 2:
            raise RuntimeError(f"{path} has no parent prim; give a path such as /World/Cube{text}")
        return cls(generate_next_free_path(text, prepend_default_prim=False), **kwargs)

    def check(self, path: str, fresh: bool, options: dict[str, Any]) -> None:
        """Raises ValueError for a sensor that cannot be there."""

    def author(self, prim: Any, fresh: bool) -> None:
        """Writes what was asked for; of a new prim, also the defaults."""

    @property
    def prim(self) -> Any:
        return self.prims[0]

    @property
    def path(self) -> str:
        return self.paths[0]


class IMU(SensorPrim):
    kind = "IsaacImuSensor"

    def author(
        self,
        prim: Any,
        fresh: bool,
        linear_acceleration_filter_size: int | None = 1,
        angular_velocity_filter_size: int | None = 1,
        orientation_filter_size: int | None = 1,
    ) -> None:
        widths = {
            "linearAcceleration": linear_acceleration_filter_size,
            "angularVelocity": angular_velocity_filter_size,
            "orientation": orientation_filter_size,
        }
        for name, width in widths.items():
            if width is not None and (fresh or width != 1):
                attribute(prim, f"{name}FilterWidth", "uint", int(width))


class Contact(SensorPrim):
    kind = "IsaacContactSensor"

    def check(self, path: str, fresh: bool, options: dict[str, Any]) -> None:
        self._body = _body_above(path)
        if self._body is None:
            raise ValueError(f"{path}: a contact sensor must be below a rigid body that is enabled")

    def author(
        self,
        prim: Any,
        fresh: bool,
        min_threshold: float | None = None,
        max_threshold: float | None = None,
        radius: float | None = None,
        color: Any = None,
    ) -> None:
        self.prims = [prim]
        if fresh:
            attribute(prim, "threshold", "float2", Gf.Vec2f(0.0, 100000.0))
            attribute(prim, "radius", "float", -1.0)
            attribute(prim, "color", "float4", Gf.Vec4f(*(map(float, color or (1, 1, 1, 1)))))
            self._body.AddAppliedSchema("PhysxContactReportAPI")
            attribute(self._body, "physxContactReport:threshold", "float", float(min_threshold or 0.0))
        given = (
            (self.set_min_threshold, min_threshold),
            (self.set_max_threshold, max_threshold),
            (self.set_radius, radius),
        )
        for setter, value in given:
            if value is not None:
                setter(value)

    def get_radius(self) -> float | None:
        found: float | None = attribute_of(self.prim, "radius", None)
        return found

    def set_radius(self, value: float) -> None:
        attribute(self.prim, "radius", "float", float(value))

    def _thresholds(self) -> tuple[float, float]:
        low, high = attribute_of(self.prim, "threshold", (0.0, 100000.0))
        return float(low), float(high)

    def get_min_threshold(self) -> float | None:
        return self._thresholds()[0]

    def set_min_threshold(self, value: float) -> None:
        attribute(self.prim, "threshold", "float2", Gf.Vec2f(float(value), self._thresholds()[1]))

    def get_max_threshold(self) -> float | None:
        return self._thresholds()[1]

    def set_max_threshold(self, value: float) -> None:
        attribute(self.prim, "threshold", "float2", Gf.Vec2f(self._thresholds()[0], float(value)))


class Raycast(SensorPrim):
    kind = "IsaacRaycastSensor"

    def check(self, path: str, fresh: bool, options: dict[str, Any]) -> None:
        origins, directions = options.get("ray_origins"), options.get("ray_directions")
        if fresh and (origins is None or directions is None):
            raise ValueError(f"{path}: a new raycast sensor needs ray_origins and ray_directions")
        counts = {
            name: len(values)
            for name in ("ray_origins", "ray_directions", "ray_time_offsets")
            if (values := options.get(name)) is not None
        }
        if len(set(counts.values())) > 1:
            raise ValueError(f"{path}: these must have one element for each ray: {counts}")

    def author(
        self,
        prim: Any,
        fresh: bool,
        min_range: float | None = None,
        max_range: float | None = None,
        ray_origins: Any = None,
        ray_directions: Any = None,
        ray_time_offsets: Any = None,
        output_frame: str | None = None,
        report_hit_prim_paths: bool | None = None,
    ) -> None:
        if fresh:
            min_range, max_range = (0.4 if min_range is None else min_range, 100.0 if max_range is None else max_range)
            output_frame, report_hit_prim_paths = output_frame or "SENSOR", bool(report_hit_prim_paths)
        for name, value in (("minRange", min_range), ("maxRange", max_range)):
            if value is not None:
                attribute(prim, name, "float", float(value))
        for name, values in (("rayOrigins", ray_origins), ("rayDirections", ray_directions)):
            if values is not None:
                given = rows(values, len(values), 3, name)
                attribute(prim, name, "float3[]", Vt.Vec3fArray.FromNumpy(np.asarray(given, np.float32)))
                attribute(prim, "numRays", "uint", len(values))
        if ray_time_offsets is not None:
            attribute(prim, "rayTimeOffsets", "float[]", Vt.FloatArray([float(one) for one in ray_time_offsets]))
        if output_frame is not None:
            attribute(prim, "outputFrameOfReference", "token", output_frame)
        if report_hit_prim_paths is not None:
            attribute(prim, "reportHitPrimPaths", "bool", bool(report_hit_prim_paths))


def _body_above(path: str) -> Any:
    """The nearest prim above that is an enabled rigid body; None without one."""
    stage = usd_stage()
    for prefix in reversed(Sdf.Path(path).GetParentPath().GetPrefixes()):
        prim = stage.GetPrimAtPath(prefix)
        if prim and prim.HasAPI(UsdPhysics.RigidBodyAPI) and attribute_of(prim, "physics:rigidBodyEnabled", True):
            return prim
    return None
