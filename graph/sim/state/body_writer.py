"""Writes the poses of bodies as local transforms on the stage, after every physics step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass, field
from graph.sim import transforms
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, Gf, Sdf, UsdGeom

STANDARD = ("xformOp:translate", "xformOp:orient", "xformOp:scale")
OWN = ":simulated"
"""Suffix of our own ops, used if the standard ones are animated or the transform needs a matrix."""

_VECTORS = {"double3": Gf.Vec3d, "float3": Gf.Vec3f, "half3": Gf.Vec3h}
_QUATERNIONS = {"quatd": Gf.Quatd, "quatf": Gf.Quatf, "quath": Gf.Quath}


@dataclass(slots=True)
class _Body:
    """A body's prim, what carries its parent (row, -1: nothing that moves), and the specs that hold its transform."""

    prim: Any
    carrier: int
    offset: Floats
    place: Any = None
    turn: Any = None
    matrix: Any = None
    vector: Any = Gf.Vec3d
    quaternion: Any = Gf.Quatd


@dataclass
class BodyWriter:
    """Writes translate and orient if a prim has translate, orient and scale or can be given them, else a matrix.

    Opinions that are in the session layer are written there, all others in the root layer.
    """

    stage: Any
    meters_per_unit: float
    bodies: list[_Body] = field(default_factory=list)

    def attach(self, paths: Sequence[str], rows: Sequence[int], world: Floats, residuals: dict[str, Floats]) -> None:
        """Adds bodies: their paths, their rows among `world` (B, 4, 4), the rigid poses of all bodies [stage units].

        residuals: scale and shear of every body. Raises UserError for a prim that cannot be written.
        """
        self._rows = np.array(rows, dtype=np.intp)
        row_of = dict(zip(paths, rows, strict=True))
        self.bodies = [self._body(path, row_of, residuals) for path in paths]
        self._residual = np.array([residuals[path] for path in paths]).reshape(-1, 4, 4)
        self._carrier = np.array([body.carrier for body in self.bodies], dtype=np.intp)
        self._offset = np.array([body.offset for body in self.bodies]).reshape(-1, 4, 4)
        self._inverse = np.linalg.inv(self._offset) if self.bodies else self._offset
        self._written = np.full((len(self.bodies), 4, 4), np.nan)
        local = self._local(world)
        with Sdf.ChangeBlock():
            for body, matrix in zip(self.bodies, local, strict=True):
                _prepare(self.stage, body, matrix)
        self._as_matrix = np.array([body.matrix is not None for body in self.bodies], dtype=bool)
        self.write(world)

    def write(self, world: Floats) -> None:
        """Writes the transforms of the bodies that have moved; world: (B, 4, 4) rigid poses of all bodies."""
        if not self.bodies:
            return
        local = self._local(world)
        changed = local != self._written
        self._written = local
        placed, turned = changed[:, :3, 3].any(axis=1), changed[:, :3, :3].any(axis=(1, 2))
        places = (placed & ~self._as_matrix).nonzero()[0]
        turns = (turned & ~self._as_matrix).nonzero()[0]
        matrices = ((placed | turned) & self._as_matrix).nonzero()[0]
        bodies = self.bodies
        with Sdf.ChangeBlock():
            for index, place in zip(places.tolist(), local[places, :3, 3].tolist(), strict=True):
                bodies[index].place.default = bodies[index].vector(*place)
            for index, turn in zip(turns.tolist(), _quaternions(local[turns, :3, :3]).tolist(), strict=True):
                bodies[index].turn.default = bodies[index].quaternion(*turn)
            for index in matrices.tolist():
                bodies[index].matrix.default = Gf.Matrix4d(*local[index].T.ravel().tolist())

    def _local(self, world: Floats) -> Floats:
        inverse = self._inverse
        carried = self._carrier >= 0
        if carried.any():
            inverse = inverse.copy()
            inverse[carried] = np.linalg.inv(world[self._carrier[carried]] @ self._offset[carried])
        out: Floats = inverse @ world[self._rows] @ self._residual
        return out

    def _body(self, path: str, rows: dict[str, int], residuals: dict[str, Floats]) -> _Body:
        prim = self.stage.GetPrimAtPath(path)
        if prim.IsInstanceProxy():
            raise UserError(
                f"{path}: it lies in an instance, where no transform can be written while Fabric is off; switch "
                "fidelity fabric on, or clear instanceable above it"
            )
        parent = prim.GetParent()
        if UsdGeom.Xformable(prim).GetResetXformStack() or parent.IsPseudoRoot():
            return _Body(prim, -1, np.eye(4))
        above = parent
        while not above.IsPseudoRoot() and above.GetPath().pathString not in rows:
            above = above.GetParent()
        xforms = UsdGeom.XformCache(EARLIEST)
        if above.IsPseudoRoot():
            return _Body(prim, -1, transforms.from_usd(xforms.GetLocalToWorldTransform(parent)))
        carrier = above.GetPath().pathString
        relative, resets = xforms.ComputeRelativeTransform(parent, above)
        if resets:
            return _Body(prim, -1, transforms.from_usd(xforms.GetLocalToWorldTransform(parent)))
        return _Body(prim, rows[carrier], residuals[carrier] @ transforms.from_usd(relative))


def author_local(stage: Any, prim: Any, parent: Floats, local: Floats) -> None:
    """Writes one prim's local transform (4, 4), given its parent's in the world."""
    body = _Body(prim, -1, parent)
    with Sdf.ChangeBlock():
        _prepare(stage, body, local, with_scale=True)
        if body.matrix is not None:
            body.matrix.default = Gf.Matrix4d(*local.T.ravel().tolist())
        else:
            body.place.default = body.vector(*local[:3, 3].tolist())
            body.turn.default = body.quaternion(*_quaternions(local[None, :3, :3])[0].tolist())


def _prepare(stage: Any, body: _Body, local: Floats, with_scale: bool = False) -> None:
    """Gives the prim ops that can hold its transform, through specs, because USD's own calls must not be mixed with
    a block.
    """
    prim, schema = body.prim, UsdGeom.Xformable(body.prim)
    layer = _layer(stage, prim)
    spec = Sdf.CreatePrimInLayer(layer, prim.GetPath())
    reset = ["!resetXformStack!"] if schema.GetResetXformStack() else []
    scale = np.sqrt((local[:3, :3] ** 2).sum(axis=0))
    axes = local[:3, :3] / scale
    if np.abs(axes.T @ axes - np.eye(3)).max() > 1e-9 or np.linalg.det(axes) < 0 or not _even(body.offset):
        body.matrix = _attribute(spec, f"xformOp:transform{OWN}", Sdf.ValueTypeNames.Matrix4d)
        _set_order(spec, [*reset, body.matrix.name])
        return
    names = [str(op.GetOpName()) for op in schema.GetOrderedXformOps()]
    animated = any(prim.GetAttribute(name).GetNumTimeSamples() for name in STANDARD if prim.HasAttribute(name))
    suffix = OWN if animated else ""
    types = Sdf.ValueTypeNames
    body.place = _attribute(spec, STANDARD[0] + suffix, _type(prim, STANDARD[0] + suffix, types.Double3))
    body.turn = _attribute(spec, STANDARD[1] + suffix, _type(prim, STANDARD[1] + suffix, types.Quatd))
    body.vector = _VECTORS[str(body.place.typeName)]
    body.quaternion = _QUATERNIONS[str(body.turn.typeName)]
    if suffix or with_scale or names != list(STANDARD):
        kept = _attribute(spec, STANDARD[2] + suffix, _type(prim, STANDARD[2] + suffix, types.Double3))
        kept.default = _VECTORS[str(kept.typeName)](*scale.tolist())
        _set_order(spec, [*reset, *(name + suffix for name in STANDARD)])


def _layer(stage: Any, prim: Any) -> Any:
    session = stage.GetSessionLayer()
    if session is not None:
        spec = session.GetPrimAtPath(prim.GetPath())
        if spec and any(name.startswith("xformOp") for name in spec.properties.keys()):  # noqa: SIM118
            return session
    return stage.GetRootLayer()


def _attribute(spec: Any, name: str, kind: Any) -> Any:
    found = spec.layer.GetAttributeAtPath(spec.path.AppendProperty(name))
    return found if found else Sdf.AttributeSpec(spec, name, kind)


def _type(prim: Any, name: str, default: Any) -> Any:
    return prim.GetAttribute(name).GetTypeName() if prim.HasAttribute(name) else default


def _set_order(spec: Any, names: list[str]) -> None:
    path = spec.path.AppendProperty("xformOpOrder")
    order = spec.layer.GetAttributeAtPath(path)
    if not order:
        order = Sdf.AttributeSpec(spec, "xformOpOrder", Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform)
    order.default = names


def _even(matrix: Floats) -> bool:
    """Whether a matrix scales equally in all directions, so that a rotation below it causes no shear."""
    gram = matrix[:3, :3].T @ matrix[:3, :3]
    return bool(np.abs(gram - np.eye(3) * gram[0, 0]).max() <= 1e-9 * abs(gram[0, 0]))


def _quaternions(linear: Floats) -> Floats:
    """(n, 4) w, x, y, z, w >= 0, of rotations times positive scales along their own axes (n, 3, 3)."""
    return transforms.quaternions(linear / np.sqrt((linear * linear).sum(axis=1))[:, None, :])
