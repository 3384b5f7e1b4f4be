"""How writers are made, and those for all sensors by their names in Replicator's registry."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from graph.base.records import dataclass, field
from graph.base.suggest import did_you_mean
from sensors.frame import Frame

Writer = Callable[[Frame], object]


@dataclass(frozen=True, slots=True)
class WriterSpec:
    """How a writer is made: a factory, its default arguments, and the channels it reads.

    factory: called with the arguments, returns a callable for frames; it raises ValueError or TypeError for wrong
    arguments.
    """

    factory: Callable[..., Writer]
    defaults: Mapping[str, Any] = field(default_factory=dict)
    channels: frozenset[str] = frozenset({"xyz"})


def _debug_draw(**options: Any) -> Writer:
    from .drawing import PointCloudDrawing

    known = inspect.signature(PointCloudDrawing).parameters
    for name in options:
        if name not in known:
            hint = did_you_mean(name, known, f"it has {', '.join(known)}")
            raise ValueError(f"it has no option {name!r}{hint}")
    return PointCloudDrawing(**options)


DEBUG_DRAW = "RtxSensorDebugDrawPointCloud"
REGISTRY: dict[str, WriterSpec] = {
    DEBUG_DRAW: WriterSpec(
        _debug_draw,
        {"doTransform": True, "color": (0.75, 0.75, 1.0, 1.0), "size": 0.02, "testMode": False},
    )
}
REGISTRY |= {
    **dict.fromkeys(("RtxLidarDebugDrawPointCloud", "RtxLidarDebugDrawPointCloudBuffer"), REGISTRY[DEBUG_DRAW]),
    "RtxRadarDebugDrawPointCloud": WriterSpec(
        _debug_draw, {**REGISTRY[DEBUG_DRAW].defaults, "size": 0.2, "color": (1.0, 0.2, 0.3, 1.0)}
    ),
}
"""The registry, by Replicator's names, including the older ones; `sensors.writers.registry` adds those that read
annotators, which know the sensor types, which know this table."""
