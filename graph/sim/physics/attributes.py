"""Reading UsdPhysics attributes, whose schema defaults often mean "not set"."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdPhysics


def kilograms_per_unit(stage: Any) -> float:
    """Kilograms in one unit of mass of the stage."""
    value = float(UsdPhysics.GetStageKilogramsPerUnit(stage))
    return value if 0 < value < math.inf else 1.0


def value_of(prim: Any, name: str) -> Any:
    """The value that a prim authors for an attribute, even if USD does not know the attribute; None if not authored."""
    attribute = prim.GetAttribute(name)
    return attribute.Get(EARLIEST) if attribute and attribute.HasAuthoredValue() else None


def applied_schemas(prim: Any) -> list[str]:
    """The API schemas in a prim's metadata, including those that this USD does not know."""
    return list(prim.GetPrimTypeInfo().GetAppliedAPISchemas())


def authored(attribute: Any, nothing: float = 0.0) -> float | None:
    """The authored number of an attribute; None if it is unset, not finite, or the schema's value for "not set"."""
    value = attribute.Get(EARLIEST) if attribute and attribute.HasAuthoredValue() else None
    return None if value is None or not math.isfinite(value) or value <= nothing else float(value)


def quaternion_of(value: Any) -> Floats:
    """A `Gf.Quat*` as unit w, x, y, z; the identity if its length is 0, NaN if it is not finite."""
    out = np.array([value.GetReal(), *value.GetImaginary()], dtype=np.float64)
    length = float(np.linalg.norm(out))
    if math.isinf(length):
        return np.full(4, np.nan)
    return out / length if length != 0 else np.array([1.0, 0, 0, 0])


def vector(attribute: Any) -> Floats | None:
    """(3,) if authored, finite and not the schema's "not set" of minus infinity, else None."""
    value = attribute.Get(EARLIEST) if attribute and attribute.HasAuthoredValue() else None
    out = None if value is None else np.array(value, dtype=np.float64)
    return out if out is not None and np.isfinite(out).all() else None
