"""The images of cameras by OpenGL, which MuJoCo's renderer draws: the entry point `gl` of `tickgraph.backends`.

`context` says whether this machine can; `scene` draws shapes and lamps; `drawn` makes them of a world and a camera.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.lazy_names import lazy_names as _lazy_names

if TYPE_CHECKING:
    from .context import require
    from .drawn import DrawnCamera, reason_for_rays

__all__ = ["DrawnCamera", "reason_for_rays", "require"]

__getattr__, __dir__ = _lazy_names(__name__, {"DrawnCamera": "drawn", "reason_for_rays": "drawn", "require": "context"})
