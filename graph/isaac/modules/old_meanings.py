"""`omni.isaac.core.prims` and `.articulations`: short names there are of one prim, and views have their own names."""

from __future__ import annotations

from .old_prims import SingleGeometryPrim as GeometryPrim
from .old_prims import SingleRigidPrim as RigidPrim
from .old_prims import SingleXFormPrim as XFormPrim
from .old_robots import SingleArticulation as Articulation
from .old_views import Articulation as ArticulationView
from .old_views import GeometryPrim as GeometryPrimView
from .old_views import RigidPrim as RigidPrimView
from .old_views import XFormPrim as XFormPrimView

__all__ = [
    "Articulation",
    "ArticulationView",
    "GeometryPrim",
    "GeometryPrimView",
    "RigidPrim",
    "RigidPrimView",
    "XFormPrim",
    "XFormPrimView",
]
