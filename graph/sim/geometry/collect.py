"""Collects the stage's visible surfaces as triangles; static ones and moving ones are separate."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from graph.sim.scene.scan import Scan, scan_stage
from graph.sim.scene.stage import Warn, ignore_warning
from graph.sim.usd import Usd, UsdGeom

from .collector import Collector, endless
from .complaints import Complaints
from .instancing import castable, hidden
from .surfaces import Mesh, Plane, Solid

__all__ = ["Mesh", "Plane", "Solid", "collect_geometry", "endless"]


def collect_geometry(
    stage: Any,
    tolerance: float,
    warn: Warn = ignore_warning,
    scan: Scan | None = None,
    *,
    refine: bool = False,
    exact: bool = False,
) -> tuple[Mesh | Plane, ...]:
    """Every visible surface of the stage, in stage order.

    tolerance: how far the triangles of curved surfaces may lie off them [m], `mesh.tolerance`. refine: whether
    subdivision surfaces are refined instead of cast as their cages. exact: whether solids keep their closed form
    (`mesh.solids`). Invisible prims, guides and proxies are left out.
    `warn` gets `bad-geometry` and `bad-transform` for surfaces that cannot be cast, `odd-scale` for implausible sizes,
    one line for each kind. Raises UserError beyond the limit scene.triangles.
    """
    scan = scan or scan_stage(stage)
    complaints = Complaints(warn)
    collector = Collector(scan, tolerance, refine, exact, complaints)
    single: list[tuple[Any, str]] = []
    for prim, path in visible_prims(stage):
        if prim.IsA(UsdGeom.PointInstancer):
            collector.add(single)
            single = []
            collector.add_copies(prim, path)
        else:
            single.append((prim, path))
    collector.add(single)
    complaints.flush()
    return collector.finished()


def visible_prims(stage: Any) -> Iterator[tuple[Any, str]]:
    """Each visible gprim and point instancer with its path, except those below an instancer."""
    walk = iter(Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()))
    for prim in walk:
        if hidden(prim):
            walk.PruneChildren()
        elif prim.IsA(UsdGeom.PointInstancer):
            walk.PruneChildren()
            yield prim, str(prim.GetPath())
        elif castable(prim):
            yield prim, str(prim.GetPath())
