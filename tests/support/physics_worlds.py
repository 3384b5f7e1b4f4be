"""Physics of stages that tests author, and step by hand."""

from fractions import Fraction

from graph.sim.physics import build_physics
from graph.sim.scene.stage import open_stage

G = 9.81  # gravity [m/s2] where a scene says nothing else
GROUND = {"/Ground": {"type": "Plane"}}
METRES = '#usda 1.0\n(metersPerUnit = 1\n upAxis = "Z")\n'


def physics_of(stage, hz=240, fidelity=None):
    """The physics of a stage (None if nothing moves) and the warnings that building it gave."""
    warnings = []
    physics = build_physics(stage, Fraction(1, hz), fidelity, warn=lambda *warning: warnings.append(warning))
    return physics, warnings


def stage_of(text, head=METRES):
    """The stage of a USD text, in metres and z up unless `head` says otherwise."""
    stage = open_stage()
    assert stage.GetRootLayer().ImportFromString(head + text)
    return stage


def steps(physics, count):
    """Steps physics so many times."""
    for _ in range(count):
        physics.step()


def fallen(count, dt, g=G):
    """The fall [m] in so many semi-implicit Euler steps from rest.

    v_k = g k dt, so it is the sum of v_k dt, g dt2 n (n + 1) / 2.
    """
    return g * dt * dt * count * (count + 1) / 2
