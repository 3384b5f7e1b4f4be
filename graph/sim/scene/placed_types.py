"""Prim types that no USD schema declares and whose prims have a transform all the same: sensors that packages add.

To USD their prims are Xforms (the stage metadata fallbackPrimTypes, in the session layer).
"""

from __future__ import annotations

from typing import Any

_FALLBACKS = "fallbackPrimTypes"
names: set[str] = set()
"""The types; `sensors.sensor_types` fills it."""


def give_transforms(stage: Any) -> None:
    """Makes the prims of these types on a stage Xforms."""
    if not names:
        return
    from graph.sim.usd import Usd, Vt

    known = Usd.SchemaRegistry().FindConcretePrimDefinition
    present = dict(stage.GetMetadata(_FALLBACKS) or {})
    missing = [name for name in sorted(names) if name not in present and not known(name)]
    if missing:
        with Usd.EditContext(stage, stage.GetSessionLayer()):
            stage.SetMetadata(_FALLBACKS, present | dict.fromkeys(missing, Vt.TokenArray(["Xform"])))
