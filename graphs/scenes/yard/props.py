"""Things that stand many times: built once as prototypes, placed by instanceable references."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from pxr import Usd, UsdGeom

from .ground import HALF_LENGTH, HALF_WIDTH
from .mesh import Mesh, material, place

PANEL = 2.5
"""Length of a fence panel [m]."""

Placement = tuple[float, float, float, float, float]
"""x, y, z [m], turn about z [deg], scale."""


def build_prototypes(stage: Usd.Stage, root: str) -> None:
    """Write the prototypes below `root`, a class prim that nothing renders by itself; each brings its own materials."""
    stage.CreateClassPrim(root)
    for name, build in (
        ("Fence", _fence),
        ("Rack", _rack),
        ("Container", _container),
        ("Tree", _tree),
        ("Lamp", _lamp),
        ("Bollard", _bollard),
    ):
        UsdGeom.Xform.Define(stage, f"{root}/{name}")
        build(stage, f"{root}/{name}")


def place_instances(stage: Usd.Stage, root: str, prototypes: str) -> None:
    """Write every instance of every prototype below `root`."""
    for name, placements in (
        ("Fence", _fence_line()),
        ("Rack", RACKS),
        ("Container", CONTAINERS),
        ("Tree", _trees()),
        ("Lamp", [(x, y, 0, turn, 1) for y, turn in ((-18.5, 90), (10.6, -90)) for x in (-15, 0, 14)]),
        (
            "Bollard",
            [(x, 10.7, 0, 0, 1) for x in (-9.6, -5.4, -3.6, 0.6, 2.4, 6.6)]
            + [(-28.5, y, 0, 0, 1) for y in (-4.4, 4.4)],
        ),
    ):
        scope = f"{root}/{name}s"
        UsdGeom.Scope.Define(stage, scope)
        for index, (x, y, z, turn, scale) in enumerate(placements):
            prim = UsdGeom.Xform.Define(stage, f"{scope}/{name}_{index:02d}").GetPrim()
            prim.GetReferences().AddInternalReference(f"{prototypes}/{name}")
            prim.SetInstanceable(True)
            place(prim, (x, y, z), turn, scale)


RACKS: list[Placement] = [
    *((x, y, 0.0, 90.0, 1.0) for x in (17.0, 22.0) for y in (-6.0, -3.2, -0.4, 2.4)),
    *((x, 17.6, 0.02, 0.0, 1.0) for x in (-7.5, -1.5, 4.5)),
]

CONTAINERS: list[Placement] = [
    (-19.0, -16.6, 0, 0, 1),
    (-12.6, -16.6, 0, 0, 1),
    (-19.0, -16.6, 2.6, 0, 1),
    (-25.4, -14.0, 0, 90, 1),
    (-5.6, -16.9, 0, 4, 1),
]


def _fence_line() -> Iterable[Placement]:
    """Panels around the yard, with a gap in the west for the gate."""
    for x in np.arange(-HALF_LENGTH, HALF_LENGTH, PANEL):
        yield (float(x), -HALF_WIDTH, 0, 0, 1)
        yield (float(x), HALF_WIDTH, 0, 0, 1)
    for y in np.arange(-HALF_WIDTH, HALF_WIDTH, PANEL):
        yield (HALF_LENGTH, float(y), 0, 90, 1)
        if not -2.5 <= y < 2.5:
            yield (-HALF_LENGTH, float(y), 0, 90, 1)


def _trees() -> list[Placement]:
    """Trees on the mounds and one on the island, each turned and sized its own way."""
    spots = [
        (-36, -24),
        (-27, -25),
        (-14, -26),
        (-2, -24.5),
        (9, -26),
        (21, -25),
        (35, -14),
        (36, 2),
        (34, 17),
        (-35, 10),
        (-20, 25),
        (4, 25.5),
        (18, 24.5),
    ]
    draw = np.random.default_rng(7)
    trees = [(float(x), float(y), 0.5, float(draw.uniform(0, 360)), float(draw.uniform(0.85, 1.4))) for x, y in spots]
    return [*trees, (8.5, -12.0, 0.25, 40.0, 0.8)]


def _fence(stage: Usd.Stage, root: str) -> None:
    steel = material(stage, f"{root}/Looks/Steel", "steel", (0.35, 0.42, 0.38), "paint")
    panel = Mesh().add_box((0, 0, 1.05), (0.08, 0.08, 2.1))
    for z in (0.3, 1.7):
        panel.add_box((PANEL / 2, 0, z), (PANEL, 0.04, 0.05))
    for x in np.linspace(0.14, PANEL - 0.14, 18):
        panel.add_box((x, 0, 1.0), (0.05, 0.02, 1.9))
    panel.define(stage, f"{root}/Panel", steel)


def _rack(stage: Usd.Stage, root: str) -> None:
    steel = material(stage, f"{root}/Looks/Steel", "steel", (0.1, 0.25, 0.6), "paint")
    wood = material(stage, f"{root}/Looks/Wood", "wood", (0.6, 0.45, 0.3))
    card = material(stage, f"{root}/Looks/Cardboard", "cardboard", (0.65, 0.5, 0.35))
    frame, pallets, boxes = Mesh(), Mesh(), Mesh()
    for x in (-1.35, 1.35):
        for y in (-0.5, 0.5):
            frame.add_box((x, y, 2.1), (0.1, 0.08, 4.2)).add_box((x, y, 0.01), (0.18, 0.16, 0.02))
        for z in np.arange(0.3, 4.0, 0.6):
            frame.add_box((x, 0, z), (0.04, 0.95, 0.04))
    draw = np.random.default_rng(11)
    for level in (0.0, 1.5, 3.0):
        if level:
            for y in (-0.5, 0.5):
                frame.add_box((0, y, level - 0.06), (2.62, 0.05, 0.12))
        for x in (-0.65, 0.65):
            add_pallet(pallets, (x, 0.0, level))
            for row in range(int(draw.integers(1, 4))):
                for along in (-0.27, 0.27):
                    size = (0.5, float(draw.uniform(0.6, 0.76)), 0.34)
                    boxes.add_box((x + along, 0, level + 0.145 + 0.35 * row + 0.17), size, float(draw.uniform(-3, 3)))
    frame.define(stage, f"{root}/Frame", steel)
    pallets.define(stage, f"{root}/Pallets", wood)
    boxes.define(stage, f"{root}/Boxes", card)


def add_pallet(mesh: Mesh, base: tuple[float, float, float]) -> None:
    """A pallet standing on `base` (its middle), 1.2 x 0.8 x 0.144 m: three runners, nine blocks, seven deck boards."""
    x, y, z = base
    for across in (-0.35, 0.0, 0.35):
        mesh.add_box((x, y + across, z + 0.011), (1.2, 0.1, 0.022))
        mesh.add_box((x, y + across, z + 0.111), (1.2, 0.1, 0.022))
        for along in (-0.55, 0.0, 0.55):
            mesh.add_box((x + along, y + across, z + 0.061), (0.1, 0.1, 0.078))
    for along in np.linspace(-0.54, 0.54, 7):
        mesh.add_box((x + along, y, z + 0.133), (0.12, 0.8, 0.022))


def _container(stage: Usd.Stage, root: str) -> None:
    steel = material(stage, f"{root}/Looks/Steel", "steel", (0.6, 0.2, 0.12), "paint")
    shell = Mesh()
    length, width, height = 6.06, 2.44, 2.59
    along = np.arange(-length / 2 + 0.1, length / 2 - 0.09, 0.07)
    fold = 0.036 * (np.arange(len(along)) // 2 % 2)
    for side in (-1, 1):
        low = np.stack([along, side * (width / 2 - 0.04 - fold), np.full_like(along, 0.15)], axis=-1)
        shell.add_grid(np.stack([low, low + (0, 0, height - 0.25)], axis=1)[::-side])
    shell.add_grid(
        np.stack(
            [np.stack([along, np.full_like(along, y), height - 0.03 - fold / 2], axis=-1) for y in (-1.2, 1.2)], axis=1
        )
    )
    for x in (-length / 2 + 0.06, length / 2 - 0.06):
        for y in (-width / 2 + 0.06, width / 2 - 0.06):
            shell.add_box((x, y, height / 2), (0.12, 0.12, height))
        shell.add_box((x, 0, 0.08), (0.12, width, 0.16)).add_box((x, 0, height - 0.06), (0.12, width, 0.12))
    for y in (-width / 2 + 0.04, width / 2 - 0.04):
        shell.add_box((0, y, 0.08), (length, 0.08, 0.16)).add_box((0, y, height - 0.04), (length, 0.08, 0.08))
    shell.add_box((-length / 2 + 0.08, 0, height / 2), (0.04, width - 0.2, height - 0.2))
    for y in (-0.6, 0.6):
        shell.add_box((length / 2 - 0.05, y, height / 2), (0.05, 1.14, height - 0.24))
        for bar in (-0.3, 0.3):
            shell.add_tube([(length / 2, y + bar, 0.15), (length / 2, y + bar, height - 0.12)], 0.017, sides=8)
    shell.define(stage, f"{root}/Shell", steel)


def _tree(stage: Usd.Stage, root: str) -> None:
    bark = material(stage, f"{root}/Looks/Bark", "bark", (0.35, 0.25, 0.18))
    leaf = material(stage, f"{root}/Looks/Leaf", "leaf_grass", (0.2, 0.45, 0.15))
    draw = np.random.default_rng(3)
    wood, leaves = Mesh(), Mesh()
    trunk = np.array([(0.06 * np.sin(z), 0.05 * np.cos(1.3 * z), z) for z in np.linspace(-0.8, 4.2, 12)])
    wood.add_tube(trunk, np.linspace(0.2, 0.06, 12), sides=10)
    for start in trunk[5:]:
        for turn in draw.uniform(0, 2 * np.pi, 3):
            reach = draw.uniform(0.8, 1.6)
            path = [
                start + reach * t * np.array([np.cos(turn), np.sin(turn), 0.35 + 0.3 * t]) for t in np.linspace(0, 1, 5)
            ]
            wood.add_tube(path, np.linspace(0.05, 0.012, 5), sides=6)
            for centre in path[2:]:
                for _ in range(9):
                    _add_leaf(leaves, centre + draw.normal(0, 0.22, 3), draw)
    wood.define(stage, f"{root}/Wood", bark)
    leaves.define(stage, f"{root}/Leaves", leaf)


def _add_leaf(mesh: Mesh, centre: np.ndarray, draw: np.random.Generator) -> None:
    first = draw.normal(size=3)
    first /= np.linalg.norm(first)
    second = np.cross(first, draw.normal(size=3))
    second /= np.linalg.norm(second)
    mesh.add(centre + 0.12 * np.array([first, 0.6 * second, -first, -0.6 * second]), [(0, 1, 2, 3)])


def _lamp(stage: Usd.Stage, root: str) -> None:
    steel = material(stage, f"{root}/Looks/Steel", "steel", (0.5, 0.5, 0.5))
    post = Mesh().add_box((0, 0, 0.2), (0.3, 0.3, 0.4))
    angles = np.radians(np.linspace(180, 90, 8))
    arm = [
        (0, 0, 0.4),
        (0, 0, 5.0),
        *((0.8 + 0.8 * np.cos(a), 0, 5.2 + 0.6 * np.sin(a)) for a in angles),
        (1.4, 0, 5.8),
    ]
    post.add_tube(arm, np.linspace(0.08, 0.04, len(arm)), sides=12)
    post.add_box((1.6, 0, 5.77), (0.6, 0.22, 0.09))
    post.define(stage, f"{root}/Post", steel)


def _bollard(stage: Usd.Stage, root: str) -> None:
    steel = material(stage, f"{root}/Looks/Steel", "steel", (0.85, 0.7, 0.1), "paint")
    profile = [
        (0.1, 0.0),
        (0.1, 0.75),
        *((0.1 * np.cos(a), 0.75 + 0.1 * np.sin(a)) for a in np.radians((20, 40, 60, 80))),
    ]
    Mesh().add_tube([(0, 0, z) for _, z in profile], [r for r, _ in profile], sides=24).define(
        stage, f"{root}/Post", steel
    )
