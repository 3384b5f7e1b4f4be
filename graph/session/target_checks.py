"""What would go wrong elsewhere: `graph check --target` looks at a file that works here with another product's eyes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING

from graph.sim import settings as keys

from .graph_links import Links

if TYPE_CHECKING:
    from pxr import Usd

    from graph.evaluate import Node
    from graph.sim.settings import Settings
    from graph.spec.file_spec import Note

FEWEST_UPDATES = 5
"""How long after play Isaac Sim 6.0 needs before a radar's render product may exist beside a lidar's."""


def target_notes(target: str, links: Links, stage: Usd.Stage, settings: Settings) -> Iterator[Note]:
    """Warnings about what works here and does not in the target (one of `TARGETS`)."""
    for rule in TARGETS[target]:
        yield from rule(links, stage, settings)


def _fif_race(links: Links, stage: Usd.Stage, settings: Settings) -> Iterator[Note]:
    """Motion BVH with a lidar and a radar whose product is made in the first updates: a crash in the first seconds."""
    if not settings.get(keys.MOTION_BVH):
        return
    makers = {kind: list(_makers(links, stage, kind)) for kind in ("OmniLidar", "OmniRadar")}
    if not makers["OmniLidar"]:
        return
    waited = {one for node in links.nodes for one in _after_countdown(links, node)}
    for node, prim in makers["OmniRadar"]:
        if node not in waited:
            yield (
                "fif-race",
                node.path,
                f"Isaac Sim 6.0 may crash: Motion BVH is on and {prim} is rendered beside a lidar in the first "
                f"{FEWEST_UPDATES} updates; make its product after a Countdown of {FEWEST_UPDATES}",
            )


def _radar_without_bvh(links: Links, stage: Usd.Stage, settings: Settings) -> Iterator[Note]:
    """A radar without Motion BVH: it gives nothing there. Where the file asks for it, the radar says so itself."""
    told = settings.get(keys.MOTION_BVH) or settings.get(keys.RADAR_NEEDS_MOTION_BVH)
    for _, prim in () if told else _makers(links, stage, "OmniRadar"):
        yield (
            "radar-motion-bvh-off",
            prim,
            f"Isaac Sim 6.0 gives no frames of a radar while Motion BVH is off; set {keys.MOTION_BVH} to true",
        )


def _radar_tick_rate(links: Links, stage: Usd.Stage, settings: Settings) -> Iterator[Note]:
    """A radar with a rate: there it renders in every update. Where the file has that too, the radar says so itself."""
    for _, prim in () if settings.get(keys.RADAR_IGNORES_TICK_RATE) else _makers(links, stage, "OmniRadar"):
        rate = stage.GetPrimAtPath(prim).GetAttribute("omni:sensor:tickRate").Get() or 0.0
        if rate > 0.0:
            yield (
                "radar-tick-rate-ignored",
                prim,
                f"Isaac Sim 6.0 renders it in every update, not at {rate:g} Hz; gate what it publishes "
                "(IsaacSimulationGate)",
            )


def _makers(links: Links, stage: Usd.Stage, prim_type: str) -> Iterator[tuple[Node, str]]:
    """The nodes that have prims of a type rendered, each with the prim."""
    for node in links.nodes:
        if node.type.outputs_as("product"):
            for name in node.type.inputs_as("sensor"):
                for path in map(str, node.get(name) or ()):
                    prim = stage.GetPrimAtPath(path)
                    if prim and prim.GetTypeName() == prim_type:
                        yield node, path


def _after_countdown(links: Links, node: Node) -> set[Node]:
    """The nodes that run when a Countdown that is long enough has ended; none for other nodes."""
    if node.type.id != "omni.graph.action.Countdown" or node.get("duration") < FEWEST_UPDATES:
        return set()
    starts = [link.target for link in links.out_of.get(node, ()) if link.execution and link.output == "finished"]
    return {one for start in starts for one in links.reached(start)}


Rule = Callable[[Links, "Usd.Stage", "Settings"], Iterator["Note"]]
TARGETS: Mapping[str, tuple[Rule, ...]] = {"isaacsim-6.0": (_fif_race, _radar_without_bvh, _radar_tick_rate)}
"""Product -> what is looked for."""
