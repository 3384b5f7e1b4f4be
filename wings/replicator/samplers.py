"""Random positions for prims: in a ball, on a sphere, between two spheres."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, node_type
from graph.sim.scene.prim_paths import prim_at
from nodes.data.random_values import Random, generator_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from graph.sim.app import App

PRIMS = Attribute("target", "the prims to place, each in the frame of its parent", default=[])
EXEC_IN = Attribute("execution", "places the prims again")
EXEC_OUT = Attribute("execution", "follows when the prims are placed")


def sample_shell(generator: np.random.Generator, inner: float, outer: float, count: int) -> NDArray[np.float64]:
    """(count, 3) points, uniform in the volume between two spheres, or on the surface if both radii are equal."""
    import numpy as np

    around = generator.uniform(0, 2 * np.pi, count)
    height = generator.uniform(-1, 1, count)
    radius = np.cbrt(generator.uniform(inner**3, outer**3, count)) if outer > inner else np.full(count, outer)
    aside = radius * np.sqrt(1 - height**2)
    return np.stack([aside * np.cos(around), aside * np.sin(around), radius * height], axis=1)


def _place(db: Database, inner: float, outer: float) -> bool:
    paths = [str(path) for path in db.inputs.prims]
    if not paths:
        return False
    if not (inner >= 0 and outer > 0):
        db.fail(f"a radius is {min(inner, outer):g}; give a positive one")
    prims = [_xformable(db, path) for path in paths]
    for prim, place in zip(prims, sample_shell(generator_of(db), inner, outer, len(prims)), strict=True):
        _translate(db.app, prim, place.tolist())
    db.fire("execOut")
    return True


def _xformable(db: Database, path: str) -> Any:
    from graph.sim.usd import UsdGeom

    prim = prim_at(db.app.stage, path)
    if not prim:
        db.fail(f"there is no prim {path} on the stage; correct input prims")
    elif not prim.IsA(UsdGeom.Xformable):
        db.fail(f"{path} is a {prim.GetTypeName() or 'typeless prim'}, which has no place; give Xformable prims")
    return prim


def _translate(app: App, prim: Any, place: Sequence[float]) -> None:
    """Write a prim's translation; a body that physics moves is moved there too."""
    from graph.sim import transforms
    from graph.sim.usd import EARLIEST, Gf, Sdf, UsdGeom

    attribute = prim.GetAttribute("xformOp:translate")
    if not attribute:
        attribute = UsdGeom.Xformable(prim).AddTranslateOp().GetAttr()
    exact = attribute.GetTypeName() == Sdf.ValueTypeNames.Double3
    attribute.Set(Gf.Vec3d(*place) if exact else Gf.Vec3f(*place))
    path = str(prim.GetPath())
    if app.physics is not None and path in app.physics.body_paths:
        world = UsdGeom.XformCache(EARLIEST).GetLocalToWorldTransform(prim)
        app.fabric.set_world_matrix(path, transforms.from_usd(world))


@node_type(
    "isaacsim.replicator.examples.OgnSampleInSphere",
    version=1,
    inputs={
        "prims": PRIMS,
        "execIn": EXEC_IN,
        "radius": Attribute("float", "radius of the ball", default=1.0, unit="stage units"),
    },
    outputs={"execOut": EXEC_OUT},
    memory=Random,
)
def sample_in_sphere(db: Database) -> bool:
    """Place each prim at random in a ball about its parent, uniformly in the volume."""
    return _place(db, 0.0, db.inputs.radius)


@node_type(
    "isaacsim.replicator.examples.OgnSampleOnSphere",
    version=1,
    inputs={
        "prims": PRIMS,
        "execIn": EXEC_IN,
        "radius": Attribute("float", "radius of the sphere", default=1.0, unit="stage units"),
    },
    outputs={"execOut": EXEC_OUT},
    memory=Random,
)
def sample_on_sphere(db: Database) -> bool:
    """Place each prim at random on a sphere about its parent, uniformly on the surface."""
    return _place(db, db.inputs.radius, db.inputs.radius)


@node_type(
    "isaacsim.replicator.examples.OgnSampleBetweenSpheres",
    version=1,
    inputs={
        "prims": PRIMS,
        "execIn": EXEC_IN,
        "radius1": Attribute("float", "radius of one sphere", default=0.5, unit="stage units"),
        "radius2": Attribute("float", "radius of the other sphere", default=1.0, unit="stage units"),
    },
    outputs={"execOut": EXEC_OUT},
    memory=Random,
)
def sample_between_spheres(db: Database) -> bool:
    """Place each prim at random between two spheres about its parent, uniformly in the volume."""
    return _place(db, *sorted((db.inputs.radius1, db.inputs.radius2)))


@node_type(
    "isaacsim.replicator.domain_randomization.Random3f",
    version=1,
    volatile=True,
    inputs={
        "minimum": Attribute("float[3]", "smallest numbers"),
        "maximum": Attribute("float[3]", "largest numbers"),
    },
    outputs={"output": Attribute("float[3]", "random numbers, new ones in every compute")},
    memory=Random,
)
def random_3f(db: Database) -> None:
    """Draw three numbers, each uniformly between its minimum and maximum."""
    inputs = db.inputs
    low, high = inputs.minimum, inputs.maximum
    if not (low <= high).all():
        db.fail(f"minimum {low.tolist()} is above maximum {high.tolist()}; exchange them")
    db.outputs.output = generator_of(db).uniform(low, high)
