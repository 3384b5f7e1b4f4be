"""Friction of contacts by the materials of both sides; MuJoCo's own rule is to use the larger friction.

Every collider belongs to a class of equal materials. Where MuJoCo's rule (that of the geom with the higher priority,
else the larger) gives the wanted friction of two classes, nothing more is needed; classes of static colliders get a
priority and a friction that suit most of the colliders that can hit them. All other pairs are written into the model as
explicit pairs, each with its own friction.

Static and dynamic friction: a pair with a larger static friction keeps it until its surfaces are twice found sliding,
or found sliding when they meet (faster than gravity alone can cause in two steps).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graph.base.records import dataclass
from graph.sim.physics.contact_materials import Material, touch
from graph.sim.physics.world_model import Collider
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

from .library import mujoco
from .restitution import Restitution

if TYPE_CHECKING:
    from .surfaces import Surfaces

SLIDING, RESTING, PATIENCE = 0.02, 0.01, 2
"""Static friction ends above the first of these speeds [m/s], found this many times, and returns below the second."""

LOOKS_HZ, FIRST_LOOKS = 20.0, 10
"""How often sliding is checked (at most once a step); so often at first in every step."""

MOST_PAIRS = 100_000
"""At most this many explicit pairs are written, because each costs time in every step."""

SMOOTH = 1e-5
"""Friction below this is treated as zero: the solver cannot resolve flatter friction pyramids."""

FIRM = (0.99, 0.995, 0.001, 0.5, 2.0)
"""MuJoCo's impedance of contacts, ten times as firm as its own default (0.9, 0.95).

With elliptic cones and that default bodies would sink in eight times as far as with pyramids. Measured in
`tests/stability`: a tower of 20 boxes is 3.7 mm too low (21 mm by the default, 5.7 mm with pyramids) at the same cost.
"""


@dataclass(frozen=True)
class Pair:
    """Two colliders, by number, with their own contact properties."""

    first: int
    second: int
    touch: Material


@dataclass(frozen=True)
class Plan:
    """Friction and priority by collider, the explicit pairs, and the restitution of contacts."""

    friction: Floats
    priority: NDArray[np.intp]
    pairs: tuple[Pair, ...]
    restitution: Restitution


def plan_contacts(
    colliders: Sequence[Collider],
    names: Sequence[str],
    still: NDArray[np.bool_],
    meets: NDArray[np.bool_] | None,
    warn: Warn,
) -> Plan:
    """The friction of each collider, and the explicit pairs.

    names: of the colliders in the model. still: (n,) static colliders, which do not collide with each other. meets: (k,
    k) by `Collider.mask`, which of them collide (None: all).
    """
    classes: dict[tuple[Material, bool], int] = {}
    number = np.array(
        [classes.setdefault((c.material, bool(s)), len(classes)) for c, s in zip(colliders, still, strict=True)],
        dtype=np.intp,
    )
    kinds = list(classes)
    count = np.bincount(number, minlength=len(kinds))
    wanted = {
        (a, b): touch(kinds[a][0], kinds[b][0])
        for a in range(len(kinds))
        for b in range(a, len(kinds))
        if not (kinds[a][1] and kinds[b][1])
    }
    friction = np.array([touch(material, material).sliding for material, _ in kinds])
    priority = np.zeros(len(kinds), dtype=np.intp)
    for a, (_, unmoved) in enumerate(kinds):
        if unmoved:
            _fit(a, wanted, friction, priority, count)
    own = [pair for pair, want in wanted.items() if _special(want) or _given(*pair, friction, priority) != want.sliding]
    members = [np.flatnonzero(number == a) for a in range(len(kinds))]
    pairs: list[Pair] = []
    for a, b in own:
        several = len(members[a]) * len(members[b])
        if len(pairs) + several > MOST_PAIRS:
            where = colliders[members[a][0]].path
            warn(
                "contact-pairs",
                where,
                f"{several} pairs of colliders like this one and like {colliders[members[b][0]].path} would need a "
                "contact of their own; they take the larger friction. Use fewer materials",
            )
            continue
        pairs.extend(Pair(i, j, wanted[a, b]) for i, j in _pairs(members[a], members[b], a == b, colliders, meets))
    shares = np.zeros((len(kinds), len(kinds)))
    for (a, b), want in wanted.items():
        shares[a, b] = shares[b, a] = want.restitution
    restitution = Restitution(dict(zip(names, number.tolist(), strict=True)), shares)
    return Plan(friction[number], priority[number], tuple(pairs), restitution)


def _special(want: Material) -> bool:
    return want.static > want.sliding


def _given(a: int, b: int, friction: Floats, priority: NDArray[np.intp]) -> float:
    """MuJoCo's own friction of two classes."""
    if priority[a] != priority[b]:
        return float(friction[a if priority[a] > priority[b] else b])
    return float(max(friction[a], friction[b]))


def _fit(
    a: int,
    wanted: dict[tuple[int, int], Material],
    friction: Floats,
    priority: NDArray[np.intp],
    count: NDArray[np.intp],
) -> None:
    """Gives a static class the friction, at a higher priority, that suits most of the classes that can hit it."""
    votes: dict[float, int] = {}
    plain = True
    for pair, want in wanted.items():
        if a in pair and not _special(want):
            votes[want.sliding] = votes.get(want.sliding, 0) + int(count[pair[0] if pair[1] == a else pair[1]])
            plain = plain and _given(*pair, friction, priority) == want.sliding
    if not plain:
        friction[a], priority[a] = max(votes, key=lambda value: votes[value]), 1


def _pairs(
    first: NDArray[np.intp],
    second: NDArray[np.intp],
    same: bool,
    colliders: Sequence[Collider],
    meets: NDArray[np.bool_] | None,
) -> Iterator[tuple[int, int]]:
    for i in first:
        for j in second:
            if same and j <= i:
                continue
            if meets is None or meets[colliders[i].mask, colliders[j].mask]:
                yield int(i), int(j)


def add_pairs(spec: Any, names: Sequence[str], plan: Plan, meet: Callable[[int, int], bool]) -> dict[str, Material]:
    """Writes the explicit pairs of colliders that can collide into a spec; returns their contact properties by name."""
    out = {}
    spec.default.pair.condim, spec.default.pair.solimp = 3, FIRM
    for pair in plan.pairs:
        if not meet(pair.first, pair.second):
            continue
        first, second = names[pair.first], names[pair.second]
        name = f"{first}|{second}"
        sliding, torsion, rolling = pair.touch.sliding, pair.touch.torsion, pair.touch.rolling
        made = spec.add_pair(
            name=name, geomname1=first, geomname2=second, friction=[sliding, sliding, torsion, rolling, rolling]
        )
        if pair.touch.static <= SMOOTH:
            made.condim = 1
        out[name] = pair.touch
    return out


class Contacts:
    """The explicit pairs of a model while it runs: switches friction when they slide."""

    def __init__(self, model: Any, touches: Mapping[str, Material]) -> None:
        """touches: by the names of pairs of the model."""
        self._model = model
        held = [(int(model.pair(name).id), touch) for name, touch in touches.items()]
        two = [(pair, touch) for pair, touch in held if touch.static > touch.sliding]
        self._pairs = np.array([pair for pair, _ in two], dtype=np.intp)
        self._friction = np.array([(touch.static, touch.sliding) for _, touch in two]).reshape(-1, 2)
        self.switching = bool(two)
        """Whether `step` has work to do."""
        first, second = model.pair_geom1[self._pairs].tolist(), model.pair_geom2[self._pairs].tolist()
        self._number = {(min(ends), max(ends)): number for number, ends in enumerate(zip(first, second, strict=True))}
        degree = np.bincount([*first, *second], minlength=model.ngeom)
        hubs = [one if degree[one] >= degree[other] else other for one, other in self._number]
        self._is_hub = np.zeros(model.ngeom + 1, dtype=np.bool_)  # the last entry is for contacts that are not of geoms
        self._is_hub[hubs] = True
        """Geoms such that one is in every pair, as few as possible: most contacts are between others."""
        self.surfaces: Surfaces | None = None
        """Moving surfaces: their velocities do not count as sliding."""
        self._slides, self._touching = set[int](), set[int]()
        self._fast: dict[int, int] = {}
        self._clearly = 0.0
        self._every = self._wait = 1
        self._first = FIRST_LOOKS
        if two:
            model.pair_friction[self._pairs, :2] = self._friction[:, :1]

    def set_dt(self, dt: float) -> None:
        """Sets a new time step [s]."""
        self._clearly = SLIDING + 2 * dt * float(np.linalg.norm(self._model.opt.gravity))
        self._every = max(round(1 / (LOOKS_HZ * dt)), 1)
        self._wait = 1

    def step(self, data: Any) -> None:
        """After a step: finds which pairs slide now. Pairs without contact keep their state."""
        self._wait -= 1
        if self._wait:
            return
        if not data.ncon:
            self._wait = 1
            return
        self._first = max(self._first - 1, 0)
        self._wait = 1 if self._first else self._every
        contact = data.contact
        geoms = contact.geom
        rows = np.flatnonzero((self._is_hub[geoms[:, 0]] | self._is_hub[geoms[:, 1]]) & (contact.efc_address >= 0))
        speeds: dict[int, float] = {}
        if len(rows):
            own = self.surfaces.own[rows, 1:3] if self.surfaces is not None and len(self.surfaces.own) else None
            sliding = self._speeds(data, contact.efc_address[rows], contact.friction[rows], own).tolist()
            for (one, other), speed in zip(geoms[rows].tolist(), sliding, strict=True):
                number = self._number.get((one, other) if one < other else (other, one))
                if number is not None:
                    speeds[number] = max(speeds.get(number, 0.0), speed)
        for number, speed in speeds.items():
            self._look_at(number, speed)
        self._touching = set(speeds)

    def _look_at(self, number: int, speed: float) -> None:
        """Decides whether a touching pair slides."""
        fast = self._fast[number] = self._fast.get(number, 0) + 1 if speed > SLIDING else 0
        before = number in self._slides
        slides = speed >= RESTING if before else fast >= PATIENCE
        slides = slides or (number not in self._touching and speed > self._clearly)
        if slides != before:
            (self._slides.add if slides else self._slides.discard)(number)
            self._model.pair_friction[self._pairs[number], :2] = self._friction[number, int(slides)]

    def _speeds(self, data: Any, rows: NDArray[np.integer[Any]], friction: Floats, own: Floats | None = None) -> Floats:
        """Sliding speeds at contacts [m/s]; own: (n, 2) of moving surfaces."""
        velocity, (a, b) = data.efc_vel, (0.0, 0.0) if own is None else own.T
        if self._model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC:
            out: Floats = np.hypot(velocity[rows + 1] - a, velocity[rows + 2] - b)
            return out
        # a pyramid's edges are the normal velocity + and - friction times that of sliding
        u = (velocity[rows] - velocity[rows + 1]) / (2 * np.maximum(friction[:, 0], 1e-9))
        v = (velocity[rows + 2] - velocity[rows + 3]) / (2 * np.maximum(friction[:, 1], 1e-9))
        out = np.hypot(u - a, v - b)
        return out
