"""What sensor prims lose in another product."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from graph.base.errors import UserError
from graph.base.exact import shortest
from graph.session.graph_links import named_channels
from graph.sim import settings as keys

from .case import Case, Found, finds

if TYPE_CHECKING:
    from pxr import Usd

    from graph.evaluate import Node

LIDAR, RADAR, CAMERA = "OmniLidar", "OmniRadar", "Camera"
CORE = "omni:sensor:Core:"
FEWEST_UPDATES = 5
"""How long after play Isaac Sim 6.0 needs before a radar's render product may exist beside a lidar's."""
LOWEST_SCAN_RATE = 0.466
"""In Hz: below it, offsets of points within a scan overflow 32 bits of nanoseconds."""
GPU_BUFFERS = ("/app/sensors/nv/lidar/outputBufferOnGPU", "/app/sensors/nv/radar/outputBufferOnGPU")


@finds("lidar-partial-scan")
def _partial(case: Case) -> Iterator[Found]:
    for prim in case.prims(LIDAR):
        rate, scan = _rate(prim), _value(prim, f"{CORE}scanRateBaseHz")
        if rate and scan and float(rate) != float(scan):
            yield (
                f"{prim.GetPath()}.omni:sensor:tickRate",
                f"tickRate is {shortest(rate)} Hz, scanRateBaseHz {scan:g} Hz",
            )
        elif _value(prim, f"{CORE}accumulateOutputs") is False or _value(prim, f"{CORE}partialOutputs"):
            yield f"{prim.GetPath()}.{CORE}accumulateOutputs", "accumulateOutputs is off"


@finds("sensor-every-frame")
def _every_frame(case: Case) -> Iterator[Found]:
    for prim in (*case.prims(LIDAR), *case.prims(CAMERA)):
        if (prim.GetTypeName() == LIDAR or _has_api(prim)) and _rate(prim) == 0:
            yield f"{prim.GetPath()}.omni:sensor:tickRate", "it has no tickRate"


@finds("sensor-api-missing")
def _api_missing(case: Case) -> Iterator[Found]:
    for prim in case.prims(LIDAR, RADAR, CAMERA):
        if (rate := _rate(prim)) and not _has_api(prim):
            yield f"{prim.GetPath()}.omni:sensor:tickRate", f"its rate of {shortest(rate)} Hz needs OmniSensorAPI"


@finds("radar-motion-bvh-off")
def _radar_without_bvh(case: Case) -> Iterator[Found]:
    for prim in () if case.setting(keys.MOTION_BVH) else case.rendered(RADAR):
        yield str(prim.GetPath()), "it is rendered while Motion BVH is off"


@finds("radar-tick-rate-ignored")
def _radar_tick_rate(case: Case) -> Iterator[Found]:
    for prim in case.rendered(RADAR):
        if rate := _rate(prim):
            yield f"{prim.GetPath()}.omni:sensor:tickRate", f"it does not render at {shortest(rate)} Hz there"


@finds("fif-race")
def _fif_race(case: Case) -> Iterator[Found]:
    if not case.setting(keys.MOTION_BVH) or not case.rendered(LIDAR):
        return
    waited = {one for node in case.links.nodes for one in _after_countdown(case, node)}
    for node, path in case.links.makers:
        prim = case.stage.GetPrimAtPath(path)
        if prim and prim.GetTypeName() == RADAR and node not in waited:
            yield node.path, f"{path} is rendered beside a lidar in the first {FEWEST_UPDATES} updates"


def _after_countdown(case: Case, node: Node) -> set[Node]:
    """The nodes that run when a Countdown that is long enough has ended; none for other nodes."""
    if node.type.id != "omni.graph.action.Countdown" or node.get("duration") < FEWEST_UPDATES:
        return set()
    starts = [one.target for one in case.links.out_of.get(node, ()) if one.execution and one.output == "finished"]
    return {one for start in starts for one in case.links.reached(start)}


@finds("motion-compensation-off")
def _not_compensated(case: Case) -> Iterator[Found]:
    for prim in () if case.setting(keys.MOTION_BVH) else case.prims(LIDAR):
        if _value(prim, f"{CORE}outputMotionCompensationState") == "COMPENSATED":
            yield f"{prim.GetPath()}.{CORE}outputMotionCompensationState", "it is COMPENSATED and Motion BVH is off"


@finds("aux-last-product-wins")
def _one_level(case: Case) -> Iterator[Found]:
    from sensors.prim import read_aux_level

    levels = {str(prim.GetPath()): read_aux_level(prim).name for prim in case.rendered(LIDAR, RADAR)}
    if len(set(levels.values())) > 1:
        told = ", ".join(f"{path} {level}" for path, level in levels.items())
        yield next(iter(levels)), f"the rendered sensors have different auxiliary levels: {told}"


@finds("aux-output-type-ignored")
def _aux_output_type(case: Case) -> Iterator[Found]:
    yield from _authored(case, (f"{CORE}auxOutputType", "omni:sensor:WpmDmat:auxOutputType"))


@finds("report-rate-ignored")
def _report_rate(case: Case) -> Iterator[Found]:
    yield from _authored(case, (f"{CORE}reportRateBaseHz",))


@finds("ovrtx-vocabulary")
def _words_of_ovrtx(case: Case) -> Iterator[Found]:
    yield from _authored(case, ("omni:sensor:frameRate", f"{CORE}partialOutputs", f"{CORE}includeInvalidPoints"))


@finds("isaac-vocabulary")
def _words_of_isaac(case: Case) -> Iterator[Found]:
    names = ("omni:sensor:tickRate", f"{CORE}accumulateOutputs", f"{CORE}skipDroppingInvalidPoints")
    yield from _authored(case, names)


def _authored(case: Case, names: tuple[str, ...]) -> Iterator[Found]:
    """The sensor prims that author attributes of these names; inline prims by their own words, not their config's."""
    for prim in case.prims(LIDAR, RADAR, CAMERA):
        inline = case.spec.scene.prims.get(str(prim.GetPath()))
        written = None if inline is None else inline.get("attributes") or {}
        given = [
            name
            for name in names
            if (name in written if written is not None else prim.GetAttribute(name).HasAuthoredValue())
        ]
        if given:
            words = " and ".join(name.rpartition(":")[2] for name in given)
            yield f"{prim.GetPath()}.{given[0]}", f"it authors {words}"


@finds("scan-rate-too-low")
def _slow_scan(case: Case) -> Iterator[Found]:
    for prim in case.prims(LIDAR):
        rate = _value(prim, "tickgraph:scanRateBaseHz") or _value(prim, f"{CORE}scanRateBaseHz")
        with suppress(ValueError, ZeroDivisionError):
            from graph.base.exact import rate as exact_rate

            if rate and 0 < exact_rate(rate) < exact_rate(LOWEST_SCAN_RATE):
                yield f"{prim.GetPath()}.{CORE}scanRateBaseHz", f"it scans at {rate} Hz"


@finds("output-buffer-on-gpu")
def _gpu_buffers(case: Case) -> Iterator[Found]:
    yield from ((key, f"it is {case.setting(key)}") for key in GPU_BUFFERS if case.setting(key))


@finds("multi-tick-off")
def _no_multi_tick(case: Case) -> Iterator[Found]:
    rated = [str(prim.GetPath()) for prim in case.prims(LIDAR, CAMERA) if _rate(prim)]
    if rated and not case.setting(keys.MULTI_TICK):
        yield keys.MULTI_TICK, f"it is off, and {', '.join(rated[:4])} have a tickRate"


# -- what consumers ask of a sensor ------------------------------------------------------------------------------------


@finds("aux-level-too-low")
def _level_too_low(case: Case) -> Iterator[Found]:
    from sensors.channels import CHANNELS
    from sensors.prim import read_aux_level

    for asker, prim, channels in _asks(case):
        level = read_aux_level(prim)
        above = {name: CHANNELS[name].level for name in channels if name in CHANNELS and CHANNELS[name].level > level}
        if above:
            needed = max(above.values()).name
            yield (
                str(prim.GetPath()),
                f"{asker} asks for {', '.join(sorted(above))}, which need aux_output_level {needed}; "
                f"it has {level.name}",
            )


@finds("normals-off")
def _no_normals(case: Case) -> Iterator[Found]:
    yield from _asked_in_vain(case, "hitNormals")


@finds("stable-ids-off")
def _no_ids(case: Case) -> Iterator[Found]:
    yield from _asked_in_vain(case, "objId")
    for node in case.links.nodes:
        if node.type.inputs_as("product") and node.type.find("inputs", "enableObjectIdMap"):
            from sensors.channels import STABLE_IDS

            if node.get("enableObjectIdMap") and not case.setting(STABLE_IDS):
                yield f"{node.path}.inputs:enableObjectIdMap", "it publishes a map of ids that are off"


def _asked_in_vain(case: Case, channel: str) -> Iterator[Found]:
    from sensors.channels import CHANNELS

    for asker, prim, channels in () if case.setting(CHANNELS[channel].setting) else _asks(case):
        if channel in channels:
            yield asker, f"it asks {prim.GetPath()} for {channel}"


@finds("object-id-map-off")
def _no_map(case: Case) -> Iterator[Found]:
    for node, prim, channels in case.consumers():
        if "objId" in channels and node.type.find("inputs", "enableObjectIdMap") and not node.get("enableObjectIdMap"):
            yield f"{node.path}.inputs:enableObjectIdMap", f"it publishes ids of what {prim.GetPath()} hits"


def _asks(case: Case) -> Iterator[tuple[str, Usd.Prim, frozenset[str]]]:
    """What asks a sensor for quantities beyond the points: a node or a place of a script, the sensor, the channels."""
    yield from ((node.path, prim, channels) for node, prim, channels in case.consumers())
    for one in case.by_script:
        if channels := named_channels(one.names):
            yield one.subject, case.stage.GetPrimAtPath(one.prim), channels


@finds("flat-scan-3d")
def _not_flat(case: Case) -> Iterator[Found]:
    from sensors.lidar.flat_scan import require_level_beams
    from sensors.lidar.prim import read_config

    for node, prim in _scans(case, ("isaacsim.sensors.rtx.IsaacComputeRTXLidarFlatScan",)):
        try:
            require_level_beams(str(prim.GetPath()), read_config(prim))
        except UserError as error:
            yield node.path, str(error).partition("; ")[0]


@finds("scan-not-spherical")
def _not_spherical(case: Case) -> Iterator[Found]:
    types = ("isaacsim.sensors.rtx.IsaacComputeRTXLidarFlatScan", "isaacsim.sensors.rtx.IsaacCreateRTXLidarScanBuffer")
    for node, prim in _scans(case, types):
        if _value(prim, f"{CORE}elementsCoordsType") == "CARTESIAN":
            yield node.path, f"it reads {prim.GetPath()}, whose elementsCoordsType is CARTESIAN"


def _scans(case: Case, types: tuple[str, ...]) -> Iterator[tuple[Node, Usd.Prim]]:
    """The nodes of these types (of helpers: those that publish a laser scan) with the lidars that they read."""
    for node in case.links.nodes:
        if node.type.id in types or (len(types) == 1 and node.type.inputs.keys() >= {"type", "fullScan"}):
            if "type" in node.type.inputs and node.get("type") != "laser_scan":
                continue
            yield from ((node, prim) for prim in case.sensors_behind(node) if prim.GetTypeName() == LIDAR)


# -- reading prims -----------------------------------------------------------------------------------------------------


def _value(prim: Usd.Prim, name: str) -> Any:
    attribute = prim.GetAttribute(name)
    return attribute.Get() if attribute else None


def _rate(prim: Usd.Prim) -> Any:
    """The authored rate [Hz], 0 without one; None if it is wrong, which other checks report."""
    from sensors.prim import read_tick_rate

    with suppress(UserError):
        return read_tick_rate(prim)
    return None


def _has_api(prim: Usd.Prim) -> bool:
    from sensors.prim import has_sensor_api

    return has_sensor_api(prim)
