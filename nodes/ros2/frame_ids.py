"""The coordinate frame that a cloud's header names: it must be the one in which the points are given."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.records import dataclass
from graph.sim import settings as keys
from graph.sim.scene.prim_paths import NAME_OVERRIDE
from nodes.isaac.transform_trees import WORLD

if TYPE_CHECKING:
    from collections.abc import Mapping

    from graph.node import Database
    from graph.sim.renderer.products import RenderProduct
    from sensors.frame import Frame

FIXED = (WORLD, "map", "odom", "earth")
"""Names of frames that stand in the world (REP 105)."""


@dataclass(frozen=True, slots=True)
class FrameIds:
    """The frame ids of a sensor's messages: of points in its own (or a custom) frame, and of points in the world."""

    given: str
    world: str

    def of(self, frame: Frame) -> str:
        """The id for a frame's points."""
        return self.world if frame.frame_of_reference == "WORLD" else self.given


def frame_ids(db: Database, product: RenderProduct, default: str) -> FrameIds:
    """The frame ids of a helper's clouds, by its input frameId; `default`: its value if none is given.

    Points in the world under the id of the sensor, or of what carries it, would be transformed twice: their header
    names the world. Warns of that, and of any other id that does not fit the sensor's frame of reference. The setting
    `frameIdAsGiven` takes each id as it is.
    """
    from graph.sim.renderer.wrapper import unwrapped

    given = db.inputs.frameId
    if db.app.settings.get(keys.FRAME_ID_AS_GIVEN):
        return FrameIds(given, given)
    facts: Mapping[str, str] = getattr(unwrapped(product.sensor), "frame_facts", {})
    reference = facts.get("frame_of_reference", "SENSOR")
    own = given == default or given in _carriers(db, product.camera_path)
    if reference == "CUSTOM" and own:
        db.warn(
            "frame-id-not-custom",
            f"{product.camera_path} gives points in its customFrameOfReferenceTrafo, but frameId {given} names the "
            "sensor or what carries it; name the frame that the trafo means, and publish its transform",
        )
    if given in FIXED or not given:
        return FrameIds(given, given)
    if reference == "WORLD":
        how = f"the header says {WORLD}" if own else "the frame must stand at the origin of the world"
        db.warn(
            "frame-id-not-world",
            f"{product.camera_path} gives points in the WORLD, but frameId is {given}: {how}; set frameId to "
            f"{', '.join(FIXED[:3])} or to your own fixed frame, or outputFrameOfReference to SENSOR",
        )
    return FrameIds(given, WORLD if own else given)


def _carriers(db: Database, path: str) -> set[str]:
    """The TF names of a prim and of the prims above it."""
    names = set()
    prim = db.app.stage.GetPrimAtPath(path)
    while prim and not prim.IsPseudoRoot():
        names.add(str(prim.GetAttribute(NAME_OVERRIDE).Get() or prim.GetName()))
        prim = prim.GetParent()
    return names
