"""`isaacsim.sensors.experimental.rtx`."""

from __future__ import annotations

from typing import Any

from sensors.annotators.registry import register_annotator_spec, unregister_annotator_spec
from sensors.camera.authoring import RtxCamera as OurRtxCamera
from sensors.camera.depth_camera import SingleViewDepthCameraSensor as OurDepthCameraSensor
from sensors.camera.sensor import CameraSensor as OurCameraSensor
from sensors.camera.structured_light import StructuredLightCamera as OurStructuredLightCamera
from sensors.camera.tiled_sensor import TiledCameraSensor as OurTiledCameraSensor
from sensors.configs import SUPPORTED_CAMERA_CONFIGS, SUPPORTED_LIDAR_CONFIGS
from sensors.errors import SensorValueError
from sensors.gmo import GenericModelOutput, parse_generic_model_output_data
from sensors.lidar.authoring import Lidar as OurLidar
from sensors.lidar.authoring import LidarSensor as OurLidarSensor
from sensors.radar.authoring import Radar as OurRadar
from sensors.radar.authoring import RadarSensor as OurRadarSensor
from sensors.radar.configs import SUPPORTED_RADAR_CONFIGS
from sensors.surfaces import ids
from sensors.writers import register_writer_spec, unregister_writer_spec

__all__ = [
    "SUPPORTED_ACOUSTIC_VARIANT_SET_NAME",
    "SUPPORTED_CAMERA_CONFIGS",
    "SUPPORTED_CAMERA_VARIANT_SET_NAME",
    "SUPPORTED_LIDAR_CONFIGS",
    "SUPPORTED_LIDAR_VARIANT_SET_NAME",
    "SUPPORTED_RADAR_CONFIGS",
    "SUPPORTED_RADAR_VARIANT_SET_NAME",
    "CameraSensor",
    "GenericModelOutput",
    "Lidar",
    "LidarSensor",
    "Radar",
    "RadarSensor",
    "RtxCamera",
    "SingleViewDepthCameraSensor",
    "StructuredLightCamera",
    "TiledCameraSensor",
    "get_camera_metadata",
    "parse_generic_model_output_data",
    "parse_object_ids",
    "parse_stable_id_map_data",
    "register_annotator_spec",
    "register_writer_spec",
    "unregister_annotator_spec",
    "unregister_writer_spec",
]
SUPPORTED_ACOUSTIC_VARIANT_SET_NAME = SUPPORTED_CAMERA_VARIANT_SET_NAME = "sensor"
SUPPORTED_LIDAR_VARIANT_SET_NAME = SUPPORTED_RADAR_VARIANT_SET_NAME = "sensor"


def get_camera_metadata(config_path: str) -> dict[str, Any]:
    """What a table of cameras shows of one: its vendor, the name shown, a name for its prim, whether it measures depth,
    its variants. Raises KeyError for an address that is not in SUPPORTED_CAMERA_CONFIGS.
    """
    known: dict[str, Any] = SUPPORTED_CAMERA_CONFIGS[config_path]
    parts = config_path.split("/")
    return {
        "vendor": parts[parts.index("Sensors") + 1],
        "display_name": known["display_name"],
        "prim_prefix": parts[-1].partition(".")[0],
        "is_depth_sensor": known.get("is_depth_sensor", False),
        "variants": known.get("variants", set()),
    }


def parse_object_ids(obj_ids: Any) -> list[int]:
    return ids.parse_object_ids(obj_ids)


def parse_stable_id_map_data(data: Any) -> dict[int, str]:
    return ids.parse_stable_id_map_data(data)


class Authoring:
    """What wrappers have beside our authoring objects: lists of paths and prims, poses as arrays of rows."""

    path: str
    prim: Any

    @property
    def paths(self) -> list[str]:
        return [self.path]

    @property
    def prims(self) -> list[Any]:
        return [self.prim]

    @property
    def valid(self) -> bool:
        return bool(self.prim)

    def __len__(self) -> int:
        return 1

    def _wrapper(self) -> Any:
        from .xform_prim import XformPrim

        return XformPrim(self.path, resolve_paths=False)

    def get_world_poses(self, *, indices: Any = None) -> Any:
        return self._wrapper().get_world_poses()

    def set_world_poses(self, positions: Any = None, orientations: Any = None, *, indices: Any = None) -> None:
        self._wrapper().set_world_poses(positions, orientations)

    def get_local_poses(self, *, indices: Any = None) -> Any:
        return self._wrapper().get_local_poses()

    def set_local_poses(self, translations: Any = None, orientations: Any = None, *, indices: Any = None) -> None:
        self._wrapper().set_local_poses(translations, orientations)

    @classmethod
    def create(cls, path: Any, *, usd_path: Any = None, config: Any = None, **options: Any) -> Any:
        """A sensor of a configuration; an asset of a sensor that is not here is its built-in configuration."""
        from graph.isaac.assets import local_path

        if usd_path is not None and config is None:
            local = local_path(str(usd_path))
            if local is None and "/Sensors/" in str(usd_path):
                config, usd_path = str(usd_path).rpartition("/")[2].partition(".")[0], None
            else:
                usd_path = local or usd_path
        return super().create(path, usd_path=usd_path, config=config, **options)  # type: ignore[misc]


class Wrapping(Authoring):
    """Sensors that wrap no bare prims: those have the schema of their kind, or values of a configuration."""

    schema: str

    @classmethod
    def define(cls, stage: Any, path: str) -> Any:
        """A new prim of this kind, with its schema authored."""
        prim = super().define(stage, path)  # type: ignore[misc]
        prim.AddAppliedSchema(cls.schema)
        return prim

    def _check_wrapped(self) -> None:
        super()._check_wrapped()  # type: ignore[misc]
        applied = map(str, self.prim.GetPrimTypeInfo().GetAppliedAPISchemas())
        if self.schema not in applied and not self.prim.GetAuthoredPropertiesInNamespace("omni:sensor"):
            raise SensorValueError(f"{self.path} is without the API schema {self.schema}; apply it before")


class Lidar(Wrapping, OurLidar):
    def __init__(
        self,
        path: str,
        *,
        accumulate_outputs: bool | None = True,
        aux_output_level: str = "NONE",
        tick_rate: float | None = None,
        schemas: list[str] | None = None,
        attributes: dict[str, Any] | None = None,
        positions: Any = None,
        translations: Any = None,
        orientations: Any = None,
        scales: Any = None,
        reset_xform_op_properties: bool = True,
        **of_app: Any,
    ) -> None:
        super().__init__(
            path,
            accumulate_outputs=accumulate_outputs,
            aux_output_level=aux_output_level,
            tick_rate=tick_rate,
            schemas=schemas,
            attributes=attributes,
            positions=positions,
            translations=translations,
            orientations=orientations,
            scales=scales,
            reset_xform_op_properties=reset_xform_op_properties,
            **of_app,
        )


class Radar(Wrapping, OurRadar):
    def __init__(self, path: str, *, aux_output_level: str = "NONE", **options: Any) -> None:
        super().__init__(path, aux_output_level=aux_output_level, **options)


class Lens:
    """The lenses as scripts know them: `Camera` of `isaacsim.core.experimental.objects`."""

    @property
    def camera(self) -> Any:
        from .camera_prims import Camera

        return Camera(super().camera.paths)  # type: ignore[misc]


class RtxCamera(Lens, Authoring, OurRtxCamera): ...


class StructuredLightCamera(Lens, OurStructuredLightCamera): ...


class Product:
    """The render product with the calls of its prim."""

    @property
    def render_product(self) -> Any:
        from .replicator import HydraTexture

        return HydraTexture(super().render_product)  # type: ignore[misc]

    def attach_writer(self, writer_name: str, **arguments: Any) -> Any:
        """A writer of the table; or one that the script registered, whose instance is given back."""
        from .replicator import WriterRegistry

        if not WriterRegistry.is_of_script(writer_name):
            return super().attach_writer(writer_name, **arguments)  # type: ignore[misc]
        held: dict[str, Any] = self._writers  # type: ignore[attr-defined]
        if writer_name in held:
            self.detach_writer(writer_name)  # type: ignore[attr-defined]
        made = held[writer_name] = WriterRegistry.get(writer_name, arguments)
        return made.attach([self.render_product.path])


class LidarSensor(Product, OurLidarSensor):
    authored_by = OurLidar

    def __init__(self, path: Any, **options: Any) -> None:
        super().__init__(Lidar(path) if isinstance(path, str) else path, **options)

    def get_data(self, annotator: str, device: str | None = None, *, out: Any = None) -> Any:
        return data_of(super().get_data(annotator, device), out)


class RadarSensor(Product, OurRadarSensor):
    def __init__(self, path: Any, **options: Any) -> None:
        super().__init__(Radar(path) if isinstance(path, str) else path, **options)

    def get_data(self, annotator: str, device: str | None = None, *, out: Any = None) -> Any:
        return data_of(super().get_data(annotator, device), out)


class CameraSensor(Lens, Product, OurCameraSensor):
    def get_data(self, annotator: str, out: Any = None) -> Any:
        return data_of(super().get_data(annotator), out)


class SingleViewDepthCameraSensor(Lens, Product, OurDepthCameraSensor):
    def get_data(self, annotator: str, out: Any = None) -> Any:
        return data_of(super().get_data(annotator), out)


class TiledCameraSensor(Lens, OurTiledCameraSensor):
    def get_data(self, annotator: str, *, tiled: bool = False, out: Any = None) -> Any:
        return data_of(super().get_data(annotator, tiled=tiled), out)


def data_of(found: Any, out: Any) -> Any:
    """(data, info) with data as scripts know it: NumPy and Warp calls; None before the first frame."""
    import numpy as np

    from graph.isaac.results import Result

    data, info = found
    if isinstance(data, np.ndarray):
        if out is not None:
            out[...] = data
            return out, info
        data = data.view(Result)
    return data, info
