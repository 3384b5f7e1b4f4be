"""`omni.syntheticdata`: render variables, gates of render products, the former waits."""

from __future__ import annotations

from enum import Enum
from functools import partial
from typing import Any

from graph.isaac.outcomes import inert
from graph.isaac.session import app, kit
from graph.isaac.watched import watch
from graph.session.runner import graphs_of
from nodes.ros2.frame_writers import FrameWriter

__all__ = ["SensorType", "SyntheticData", "_syntheticdata"]
_RENDERVARS = {
    "Rgb": "LdrColor",
    "DistanceToImagePlane": "DistanceToImagePlaneSD",
    "DistanceToCamera": "DistanceToCameraSD",
    "Depth": "DepthSD",
    "DepthLinear": "DepthLinearSD",
    "InstanceSegmentation": "InstanceSegmentationSD",
    "SemanticSegmentation": "SemanticSegmentationSD",
    "BoundingBox2DTight": "BoundingBox2DTightSD",
    "BoundingBox2DLoose": "BoundingBox2DLooseSD",
    "BoundingBox3D": "BoundingBox3DSD",
    "Normal": "NormalSD",
    "Occlusion": "OcclusionSD",
    "MotionVector": "TargetMotionSD",
    "CrossCorrespondence": "CrossCorrespondenceSD",
}
SensorType: Any = Enum("SensorType", [(name, name) for name in _RENDERVARS])  # type: ignore[misc]
ANNOTATORS = {
    "LdrColor": "rgb",
    "DistanceToImagePlaneSD": "distance_to_image_plane",
    "DistanceToCameraSD": "distance_to_camera",
    "InstanceSegmentationSD": "instance_segmentation",
    "InstanceSegmentation": "instance_segmentation",
    "SemanticSegmentationSD": "semantic_segmentation",
    "SemanticSegmentation": "semantic_segmentation",
    "BoundingBox2DTightSD": "bounding_box_2d_tight",
    "BoundingBox2DTight": "bounding_box_2d_tight",
    "BoundingBox2DLooseSD": "bounding_box_2d_loose",
    "BoundingBox2DLoose": "bounding_box_2d_loose",
    "BoundingBox3DSD": "bounding_box_3d",
    "BoundingBox3D": "bounding_box_3d",
    "PostProcessDispatch": "camera_info",
}
"""Render variable of a gate -> what the writers behind it send."""
NEVER = 1 << 62
"""The step 0 never fires."""
PIPELINE = "/Render/PostProcess/SDGPipeline"


class _syntheticdata:  # noqa: N801
    SensorType = SensorType


def _thin(path: str, product_path: str, variable: str) -> None:
    """A gate has another step: the writers behind it publish every so many frames."""
    from graph.isaac.omnigraph.lookup import get_node_by_path

    product, gate = app().rendering.products.get(product_path), get_node_by_path(path)
    if product is None or gate is None:
        return
    is_camera = app().stage.GetPrimAtPath(product.camera_path).GetTypeName() == "Camera"
    wanted = ANNOTATORS.get(variable, variable)
    behind = [one for one in product.writers if isinstance(one, FrameWriter) and (not is_camera or one.gate == wanted)]
    for writer in behind:
        writer.thin(int(gate.ours.get("inputs:step")) or NEVER)
    if not behind:
        app().warn("gate-without-writer", path, "nothing publishes behind it yet: set its step once a helper does")


class SyntheticData:
    _instance: SyntheticData | None = None

    @staticmethod
    def Get() -> SyntheticData:
        return kit().singleton(SyntheticData, SyntheticData)

    @staticmethod
    def Initialize() -> SyntheticData:
        return SyntheticData.Get()

    @staticmethod
    def convert_sensor_type_to_rendervar(sensor_type_name: str) -> str:
        return _RENDERVARS.get(sensor_type_name, sensor_type_name)

    @staticmethod
    def _get_node_path(template_name: str, render_product_path: str | None = None) -> str:
        """The path of a gate of a product; the gate is there, and keeps its `step`."""
        from graph.isaac.og import Controller
        from graph.isaac.omnigraph.lookup import get_node_by_path

        name = (
            template_name
            if render_product_path is None
            else (f"{str(render_product_path).strip('/').replace('/', '_')}_{template_name}")
        )
        path = f"{PIPELINE}/{name}"
        if "SimulationGate" in template_name and get_node_by_path(path) is None:
            controller = Controller(app=app())
            if app().graphs.get(PIPELINE) is None:
                controller.create_graph(
                    {"graph_path": PIPELINE, "evaluator_name": "push", "pipeline_stage": "on_demand"}
                )
            controller.create_node(path, "isaacsim.core.nodes.IsaacSimulationGate")
            variable = template_name.partition("IsaacSimulationGate")[0]
            watch(graphs_of(app()), f"{path}.inputs:step", partial(_thin, path, str(render_product_path), variable))
        return path

    @inert("omni.syntheticdata")
    def activate_node_template(self, template_name: str, *_: Any, **__: Any) -> None:
        return None

    @inert("omni.syntheticdata")
    def deactivate_node_template(self, template_name: str, *_: Any, **__: Any) -> None: ...

    def get_node_attributes(
        self, template_name: str, attributes: list[str], render_product_path: str | None = None, gpu: bool = False
    ) -> dict[str, Any] | None:
        from graph.isaac.omnigraph.lookup import get_node_by_path

        node = get_node_by_path(self._get_node_path(template_name, render_product_path))
        return None if node is None else {name: node.ours.get(name) for name in attributes}

    def set_node_attributes(
        self, template_name: str, attributes: dict[str, Any], render_product_path: str | None = None
    ) -> None:
        from graph.isaac.omnigraph.lookup import get_node_by_path

        node = get_node_by_path(self._get_node_path(template_name, render_product_path))
        if node is not None:
            for name, value in attributes.items():
                if (attribute := node.get_attribute(name)) is not None:
                    attribute.set(value)


class sensors:  # noqa: N801
    @staticmethod
    async def next_render_simulation_async(render_product_path: Any, num_simulation_frames: int = 1) -> None:
        await app().next_render_simulation_async(
            getattr(render_product_path, "path", render_product_path), num_simulation_frames
        )

    @staticmethod
    async def next_sensor_data_async(viewport: Any = None, wait_for_rendering: bool = True, *_: Any) -> None:
        await kit().next_update()

    @staticmethod
    @inert("omni.syntheticdata")
    def enable_sensors(*_: Any, **__: Any) -> None:
        return None
