"""The size of the images that a file makes of a sensor."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from graph.sim.app import App

SIZES = ("width", "height")
DEFAULT = (1280, 720)


def product_size(app: App, path: str) -> tuple[int, int]:
    """Width and height [px] of the render product that the file has of a sensor, else 1280 x 720.

    In this order: a node of the graphs that renders it, a RenderProduct prim of the scene, the settings that a
    configuration keeps beside a depth camera.
    """
    from graph.sim.usd import UsdRender

    for graph in app.graphs.values():
        for node in graph.nodes.values():
            sensors = [name for name in node.type.inputs_as("sensor") if path in map(str, node.get(name) or ())]
            if sensors and all(name in node.type.inputs for name in SIZES):
                width, height = (int(node.get(name)) for name in SIZES)
                if width > 0 and height > 0:
                    return width, height
    for prim in app.stage.Traverse():
        product = UsdRender.Product(prim)
        if product and path in map(str, product.GetCameraRel().GetTargets()):
            width, height = product.GetResolutionAttr().Get()
            return int(width), int(height)
    return DEFAULT
