"""Collects the stage's visible surfaces as triangles in metres; static ones and moving ones are separate."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.base.limits import check
from graph.base.records import dataclass, field
from graph.sim import transforms
from graph.sim.scene.scan import Scan, scan_stage
from graph.sim.scene.stage import Warn, ignore_warning
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, Usd, UsdGeom, UsdShade

from .instancing import Copies, castable, copies_of, for_rendering, hidden
from .shapes import Shape, exact_solid, surface_of
from .subsets import Part, SolidPart, parts_of
from .surfaces import Mesh, Plane, Solid
from .tessellation import axis_vector


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


NAMED = 3
"""Further prims named in one line."""


class Complaints:
    """Collects mistakes of prims and reports each kind in one line: the first prim in full, the others by name."""

    def __init__(self, warn: Warn) -> None:
        self._warn = warn
        self._kinds: dict[tuple[str, str], list[tuple[str, str]]] = {}

    def add(self, code: str, path: str, message: str) -> None:
        """Adds a mistake of a prim; messages that differ only in their numbers are of one kind."""
        kind = code, re.sub(r"-?\d[\d.e+-]*", "#", message)
        entries = self._kinds.setdefault(kind, [])
        if all(path != known for known, _ in entries[:1]):
            entries.append((path, message))

    def flush(self) -> None:
        """Gives the warnings, in the order of their first occurrence; all mistakes of one prim in one line."""
        lines: dict[tuple[str, str], list[str]] = {}
        for (code, _), entries in self._kinds.items():
            path, message = entries[0]
            others = list(dict.fromkeys(other for other, _ in entries[1:]))
            if others:
                more = f" and {len(others) - NAMED} more" if len(others) > NAMED else ""
                message = f"{message}; the same holds for {', '.join(others[:NAMED])}{more}"
            lines.setdefault((code, path), []).append(message)
        for (code, path), messages in lines.items():
            self._warn(code, path, "; ".join(messages))
        self._kinds.clear()


GRID = 1e-9
"""Vertices of moving meshes are rounded to this grid [m], so that copies of one mesh are equal to the last bit."""

FARTHEST = 1e15
"""Beyond this distance [m] float32 cannot resolve a shape."""

SHAPE_ATTRIBUTES = ("points", "visibility", "size", "radius", "height", "widths")
"""Attributes that commonly have time samples, and are read only once."""

SKINNING = ("primvars:skel:jointIndices", "skel:blendShapes")
"""Attributes of prims that UsdSkel deforms."""

SANE_SIZES = 1e-5, 1e7
"""Plausible sizes of meshes [m]; outside, a scale or unit is probably wrong and float32 too coarse."""


@dataclass
class Collector:
    """Collects the surfaces of one stage; mistakes of prims go to `complaints`.

    exact: whether solids keep their closed form.
    """

    scan: Scan
    tolerance: float
    refine: bool
    exact: bool
    complaints: Complaints
    shapes: dict[tuple[str, float], tuple[Part | SolidPart, ...]] = field(default_factory=dict)
    bodies: dict[str, Floats] = field(default_factory=dict)
    found: list[tuple[Mesh | Plane, Any]] = field(default_factory=list)
    triangles: int = 0

    def add(self, prims: list[tuple[Any, str]]) -> None:
        """Adds gprims with their paths."""
        if not prims:
            return
        bodies = [self.scan.carrier_of(path) for _, path in prims]
        world = np.stack([self.scan.world_matrix(prim) for prim, _ in prims])
        good = transforms.all_usable(world)
        frames = world.copy()
        frames[:, :3] *= self.scan.meters_per_unit
        for number in np.flatnonzero(good).tolist():
            if bodies[number] is not None:
                frames[number] = self._to_frame(world[number][None], bodies[number])[0]
        mirrored, scales = _mirrored(frames), _scales(frames, good).tolist()
        for number, (prim, path) in enumerate(prims):
            if not good[number]:
                self.complaints.add(
                    "bad-transform", path, "its transform is flat, not finite or not affine; rays do not see it"
                )
            elif prim.IsA(UsdGeom.Plane) and endless(prim):
                self.found.append((_endless_plane(prim, path, bodies[number], frames[number]), prim))
            else:
                for part in self._parts(prim, path, scales[number]):
                    name = f"{path}/{part.name}" if part.name else path
                    where = frames[number], bool(mirrored[number])
                    self._place(part, name, name, bodies[number], where, self._bound(prim, part))

    def add_copies(self, prim: Any, path: str) -> None:
        """Adds all copies that a point instancer makes."""
        if not for_rendering(prim):
            return
        body, base = self.scan.carrier_of(path), self.scan.world_matrix(prim)
        for copies in copies_of(prim, lambda where, message: self.complaints.add("bad-geometry", where, message)):
            self._add_copies(copies, path, body, base)

    def _add_copies(self, copies: Copies, path: str, body: str | None, base: Floats) -> None:
        world = base @ copies.matrices
        good = transforms.all_usable(world)
        if not good.all():
            few = f"{int((~good).sum())} of its copies are flat, not finite or not affine; rays do not see them"
            self.complaints.add("bad-transform", path, few)
        frames, numbers = self._to_frame(world[good], body), copies.numbers[good]
        if not len(frames):
            return
        source = str(copies.prim.GetPath())
        # Copies of similar size share one tessellation: for the largest of each power of two.
        scales = np.exp2(np.ceil(np.log2(_scales(frames)) - 1e-9))
        parts = {scale: self._parts(copies.prim, source, scale) for scale in np.unique(scales).tolist()}
        bound = {part.name: self._bound(copies.prim, part) for each in parts.values() for part in each}
        where = zip(frames, _mirrored(frames).tolist(), strict=True)
        for number, place, scale in zip(numbers.tolist(), where, scales.tolist(), strict=True):
            name = f"{path}[{number}]{copies.name}"
            for part in parts[scale]:
                below = f"/{part.name}" if part.name else ""
                self._place(part, name + below, source + below, body, place, bound[part.name])

    def finished(self) -> tuple[Mesh | Plane, ...]:
        """All collected surfaces, with their bound materials."""
        prims = list({prim.GetPath(): prim for _, prim in self.found}.values())
        if not prims:
            return ()
        materials, _ = UsdShade.MaterialBindingAPI.ComputeBoundMaterials(prims, UsdShade.Tokens.full)
        paths = {
            prim.GetPath(): str(material.GetPath()) if material else None
            for prim, material in zip(prims, materials, strict=True)
        }
        return tuple(part.bound_to(paths[prim.GetPath()]) for part, prim in self.found)

    def _place(
        self, part: Part | SolidPart, path: str, source: str, body: str | None, where: tuple[Floats, bool], bound: Any
    ) -> None:
        """where: the matrix to the body or world, and whether it mirrors."""
        if not np.abs(where[0][:3, 3]).max() < FARTHEST:
            self.complaints.add("bad-geometry", path, f"it is farther than {FARTHEST:g} m away; rays do not see it")
            return
        found: Mesh
        form = part.form.placed(where[0]) if isinstance(part, SolidPart) else None
        # standing boxes are exact as triangles, and faster
        if isinstance(part, SolidPart) and form and (form.kind != "box" or body is not None) and form.usable:
            found = Solid(path, body, form, lambda: _moved(part.shape, where, body is not None), source, where[0])
            count = 0 if body is not None else len(part.shape[1])  # triangles of what moves are rarely made
        else:
            shape = part.shape if isinstance(part, SolidPart) else (part.vertices, part.triangles)
            moved = _moved(shape, where, body is not None)
            found, count = Mesh(path, body, *moved, None, source, where[0]), len(shape[1])
        self.triangles += count
        what = f"{path}: with it the scene has too many triangles; thin out its instancers, or raise mesh.tolerance"
        check("scene.triangles", self.triangles, what)
        self.found.append((found, bound))

    def _parts(self, prim: Any, path: str, scale: float) -> tuple[Part | SolidPart, ...]:
        """The prim's own surfaces; instances of one prototype share them."""
        source = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
        flat = prim.IsA(UsdGeom.Mesh) and not self.refine
        key = (str(source.GetPath()), 0.0 if flat else scale)
        if key not in self.shapes:
            self.shapes[key] = self._read(prim, path, scale)
        return self.shapes[key]

    def _read(self, prim: Any, path: str, scale: float) -> tuple[Part | SolidPart, ...]:
        def complain(message: str) -> None:
            self.complaints.add("bad-geometry", path, message)

        self._say_what_is_not_played(prim, path)
        solid = exact_solid(prim, self.tolerance / scale, complain) if self.exact else None
        if solid is not None:
            self._say_if_odd(path, float(np.subtract(*solid[0].bounds()[::-1]).max()) * scale)
            return (SolidPart(*solid),)
        surface = surface_of(prim, self.tolerance / scale, complain, refine=self.refine)
        if surface is None:
            return ()
        size = _size(surface.vertices) * scale
        if not _has_area(surface.vertices, surface.triangles):
            complain("its faces have no area; nothing can hit it")
        if _odd(size):
            size = _size(surface.vertices[np.unique(surface.triangles)]) * scale  # without points that no face uses
            self._say_if_odd(path, size)
        return parts_of(prim, surface, complain)

    def _say_if_odd(self, path: str, size: float) -> None:
        if _odd(size):
            about = f"it is about {size:.2g} m large; check metersPerUnit and the scales above it"
            self.complaints.add("odd-scale", path, about)

    def _say_what_is_not_played(self, prim: Any, path: str) -> None:
        """Warns of skinning, and of time samples other than transforms: rays see the first sample."""
        if any(prim.HasAttribute(name) for name in SKINNING):
            text = "a skeleton or blend shapes deform it (UsdSkel); rays see its points as they are authored"
            self.complaints.add("skinned-shape", path, text)
        names = [name for name in SHAPE_ATTRIBUTES if prim.HasAttribute(name)]
        varying = [name for name in names if prim.GetAttribute(name).ValueMightBeTimeVarying()]
        if varying:
            text = f"its {', '.join(varying)} have time samples; rays see the first of them"
            self.complaints.add("animated-shape", path, text)

    def _bound(self, prim: Any, part: Part | SolidPart) -> Any:
        """The prim whose material binding applies."""
        return prim.GetChild(part.name) if part.name else prim

    def _to_frame(self, world: Floats, body: str | None) -> Floats:
        """(n, 4, 4) prim to world in stage units, to: prim to its body's rigid frame (or the world) in metres."""
        out = world.copy()
        out[:, :3] *= self.scan.meters_per_unit
        if body is None:
            return out
        if body not in self.bodies:
            self.bodies[body] = transforms.inverse_rigid(self.scan.body_pose(body))
        local: Floats = np.round(self.bodies[body] @ out, 12)
        return local


def _moved(shape: Shape, where: tuple[Floats, bool], moves: bool) -> Shape:
    """A shape after a transform that may mirror; moves: its vertices are rounded to the grid."""
    vertices, triangles = transforms.transformed(where[0], shape[0]), shape[1]
    if where[1]:
        triangles = np.ascontiguousarray(triangles[:, ::-1])
    if moves:
        vertices = np.round(vertices / GRID) * GRID + 0.0  # also makes -0.0 and 0.0 equal in their bytes
    return vertices, triangles


def _endless_plane(prim: Any, path: str, body: str | None, frame: Floats) -> Plane:
    axis = axis_vector(str(UsdGeom.Plane(prim).GetAxisAttr().Get(EARLIEST)))
    normal = np.linalg.inv(frame[:3, :3]).T @ axis
    return Plane(path, body, frame[:3, 3].copy(), normal / np.linalg.norm(normal))


def _mirrored(frames: Floats) -> NDArray[np.bool_]:
    with np.errstate(all="ignore"):
        return np.asarray(np.linalg.det(frames[:, :3, :3]) < 0)


def _scales(frames: Floats, good: NDArray[np.bool_] | None = None) -> Floats:
    """The largest scale of each matrix; 1 for invalid ones."""
    linear = frames[:, :3, :3]
    if good is not None and not good.all():
        linear = np.where(good[:, None, None], linear, np.eye(3))
    return np.asarray(np.linalg.norm(linear, ord=2, axis=(1, 2)))


def _odd(size: float) -> bool:
    return bool(size) and not SANE_SIZES[0] <= size <= SANE_SIZES[1]


def _size(vertices: Floats) -> float:
    return float(np.ptp(vertices, axis=0).max(initial=0.0))


def _has_area(vertices: Floats, triangles: NDArray[Any], block: int = 4096) -> bool:
    """Whether any triangle has an area; for most meshes one of the first has."""
    for first in range(0, len(triangles), block):
        a, b, c = np.asarray(vertices, np.float64)[triangles[first : first + block].T.astype(np.intp)]
        with np.errstate(all="ignore"):
            if np.any(np.cross(b - a, c - a) != 0.0):
                return True
    return False


def endless(plane: Any) -> bool:
    """Whether a Plane is infinite: it has no authored width or length."""
    schema = UsdGeom.Plane(plane)
    return not (schema.GetWidthAttr().HasAuthoredValue() or schema.GetLengthAttr().HasAuthoredValue())
