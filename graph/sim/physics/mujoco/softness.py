"""The softness of all contacts of a model by one number (`physics.contact_softness`)."""

from __future__ import annotations

from typing import Any

import numpy as np

RIGID, FREE = 0.9999, 0.0001
"""MuJoCo keeps impedances between these."""


def soften_contacts(model: Any, softness: float) -> None:
    """Multiplies the compliance 1 - d of every contact by `softness`, where d is MuJoCo's impedance (`solimp`).

    A body at rest sinks in by (1 - d) / d2 of g times the square of its contact's time constant, and creeps on a slope
    by (1 - d) / d of half that constant times its downhill acceleration per second; both are proportional to 1 - d
    while that is small (MuJoCo, Computation, "Impedance").
    """
    rows = [model.geom_solimp, model.pair_solimp, model.flex_solimp, model.opt.o_solimp[None]]
    for impedance in (each[:, :2] for each in rows):
        impedance[:] = np.clip(1 - softness * (1 - impedance), FREE, RIGID)
