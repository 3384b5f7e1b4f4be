"""Rays drawn into pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type

if TYPE_CHECKING:
    from sensors.writers.drawing import RayDrawing

IDENTITY = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]


@dataclass(slots=True)
class _Pictures:
    drawing: RayDrawing | None = None
    told: bool = False


@node_type(
    "isaacsim.util.debug_draw.DebugDrawRayCast",
    version=1,
    inputs={
        "exec": Attribute("execution", "draws the rays"),
        "beamOrigins": Attribute("pointf[3][]", "where each ray begins", default=[], unit="m"),
        "beamEndPoints": Attribute("pointf[3][]", "where each ray ends", default=[], unit="m"),
        "numRays": Attribute("int", "how many of them to draw", default=0),
        "color": Attribute("colorf[4]", "r, g, b, a of the rays, 0 to 1", default=[0.75, 0.75, 1.0, 1.0]),
        "beamWidth": Attribute("float", "width of a ray, at least a pixel", default=0.02, unit="m"),
        "doTransform": Attribute("bool", "draw the rays through transform, if that is connected", default=True),
        "transform": Attribute("matrixd[4]", "where the axes of the rays are in the world", default=IDENTITY),
    },
    memory=_Pictures,
)
def debug_draw_ray_cast(db: Database) -> None:
    """Draw rays, seen from above, into a PNG file in the folder debug_view of the run's --out.

    Each compute writes one picture; all show the same part of the world.
    """
    import numpy as np

    from sensors.writers.drawing import RayDrawing

    inputs, memory = db.inputs, db.memory
    folder = db.app.output_folder
    if folder is None:
        if not memory.told:
            memory.told = True
            db.warn("debug-view-unavailable", "it draws into the run's folder; give the run one with --out")
        return
    count = max(0, int(inputs.numRays))
    points = [np.asarray(one, np.float64).reshape(-1, 3)[:count] for one in (inputs.beamOrigins, inputs.beamEndPoints)]
    if len(points[0]) != len(points[1]):
        db.fail(f"{len(points[0])} beamOrigins and {len(points[1])} beamEndPoints; give as many of each")
    if inputs.doTransform and db.connected("inputs:transform"):
        matrix = np.asarray(inputs.transform, np.float64).reshape(4, 4)  # row vectors
        points = [one @ matrix[:3, :3] + matrix[3, :3] for one in points]
    memory.drawing = memory.drawing or RayDrawing(db.path, folder / "debug_view")
    try:
        memory.drawing(*points, np.asarray(inputs.color, float).tolist(), float(inputs.beamWidth))
    except ValueError as error:
        db.fail(f"input {error}")
