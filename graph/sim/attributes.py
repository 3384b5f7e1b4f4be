"""Reads attributes and relationships of prims, whose schema defaults often mean "not set"."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.sim.transforms import Floats


def _at(attribute: Any, time: Any = None) -> Any:
    """The value of an attribute at a time; by default at the earliest, at which scenes are read."""
    from graph.sim.usd import EARLIEST

    return attribute.Get(EARLIEST if time is None else time)


def array_of(attribute: Any, kind: type, columns: int = 0, time: Any = None) -> NDArray[Any]:
    """The value of an attribute, (n,) or (n, columns) of `kind`; empty for a missing value or one of another type."""
    empty: NDArray[Any] = np.zeros((0, columns) if columns else 0, kind)
    value = _at(attribute, time) if attribute else None
    if value is None:
        return empty
    try:
        found: NDArray[Any] = np.asarray(value).astype(kind)
    except (TypeError, ValueError, OverflowError):
        return empty
    if columns and found.size == 0:
        return empty
    return found if found.ndim == (2 if columns else 1) and (not columns or found.shape[1] == columns) else empty


def number_of(attribute: Any, time: Any = None) -> float:
    """The value of an attribute; NaN for a missing value or another type."""
    value = _at(attribute, time) if attribute else None
    try:
        return float("nan") if value is None else float(value)
    except (TypeError, ValueError):
        return float("nan")


def kilograms_per_unit(stage: Any) -> float:
    """Kilograms in one unit of mass of the stage."""
    from graph.sim.usd import UsdPhysics

    value = float(UsdPhysics.GetStageKilogramsPerUnit(stage))
    return value if 0 < value < math.inf else 1.0


def authored_value(attribute: Any) -> Any:
    """The authored value of an attribute; None if it is missing, not authored or blocked."""
    return _at(attribute) if attribute and attribute.HasAuthoredValue() else None


def value_of(prim: Any, name: str) -> Any:
    """The value that a prim authors for an attribute, even if USD does not know the attribute; None if not authored."""
    return authored_value(prim.GetAttribute(name))


def first_target(relationship: Any) -> str:
    """The prim to which a relationship leads first; "" without a target."""
    targets = relationship.GetForwardedTargets() if relationship else ()
    return str(targets[0].GetPrimPath()) if targets else ""


def applied_schemas(prim: Any) -> list[str]:
    """The API schemas in a prim's metadata, including those that this USD does not know."""
    return list(prim.GetPrimTypeInfo().GetAppliedAPISchemas())


def authored(attribute: Any, nothing: float = 0.0) -> float | None:
    """The authored number of an attribute; None if it is unset, not finite, or the schema's value for "not set"."""
    value = authored_value(attribute)
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
    value = authored_value(attribute)
    out = None if value is None else np.array(value, dtype=np.float64)
    return out if out is not None and np.isfinite(out).all() else None
