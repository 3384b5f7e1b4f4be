"""`graph inspect`: one frame of a sensor as consumers get it: header, every channel, and the prims that were hit."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import RunError, UserError

from .arguments import add_allow, add_nodes, add_overrides, add_skip_outside, session_of
from .printing import aligned, note_line, say, say_json, tell

if TYPE_CHECKING:
    from graph.session.open import Session
    from graph.sim.app import App
    from graph.sim.renderer.products import RenderProduct
    from sensors.annotators.annotator import Annotator
    from sensors.frame import Frame


SIZES = ("width", "height")
DEFAULT = (1280, 720)


def product_size(app: App, path: str) -> tuple[int, int]:
    """Width and height [px] of the render product that the file has of a sensor, else 1280 x 720.

    In this order: a node of the graphs that renders it, a RenderProduct prim of the scene, the settings that a
    configuration keeps beside a depth camera.
    """
    from graph.sim.usd import UsdRender

    for graph in app.graphs.values():
        for node in graph.nodes.values():
            sensors = [name for name in node.type.inputs_as("sensor") if path in map(str, node.get(name) or ())]
            if sensors and all(name in node.type.inputs for name in SIZES):
                width, height = (int(node.get(name)) for name in SIZES)
                if width > 0 and height > 0:
                    return width, height
    for prim in app.stage.Traverse():
        product = UsdRender.Product(prim)
        if product and path in map(str, product.GetCameraRel().GetTargets()):
            width, height = product.GetResolutionAttr().Get()
            return int(width), int(height)
    return DEFAULT


LEVELS = ("NONE", "BASIC", "EXTRA", "FULL")
FIRST_VALUES = 4


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("file", metavar="FILE", type=Path, help="graph file (.yaml, .json or .usda)")
    parser.add_argument("--sensor", metavar="PATH", help="the sensor's prim (default: the only one of the scene)")
    parser.add_argument("--aux", choices=LEVELS, help="auxiliary level to read it with (default: the prim's)")
    parser.add_argument(
        "--updates", type=int, metavar="N", help="run N app updates and take the newest frame (default: the first one)"
    )
    add_overrides(parser)
    parser.add_argument("--skip-unknown", action="store_true", help="leave nodes of unknown types out, with a warning")
    add_nodes(parser)
    add_allow(parser)
    add_skip_outside(parser)
    parser.add_argument("--json", action="store_true", help="print it as JSON")


def run(args: argparse.Namespace) -> int:
    """Runs the command: plays the file until the sensor has a frame, with object ids and normals switched on."""
    from sensors.channels import CHANNELS

    from .idle_parts import wired_sensors
    from .run import show_log

    if args.updates is not None and args.updates < 1:
        raise UserError(f"--updates {args.updates}: give a number of updates above 0")
    show_log()
    settings = {**{one.setting: True for one in CHANNELS.values() if one.setting}, **args.settings}
    session = session_of(args, settings=settings, on_error="continue")
    with session.app as app:
        named = wired_sensors(app, session.runner)
        told = inspect(session, find_sensor(app, args.sensor, named), aux=args.aux, updates=args.updates)
        told = {"file": str(args.file), **told}
        warnings = [(warning.code, warning.where, warning.message) for warning in app.warnings]
    if args.json:
        say_json({**told, "warnings": [dict(zip(_WARNING, one, strict=True)) for one in warnings]})
    else:
        for line in as_text(told):
            say(line)
        for warning in warnings:
            tell(note_line(warning))
    return 0


_WARNING = ("code", "where", "message")


def find_sensor(app: App, path: str | None, named: Iterable[str] = ()) -> str:
    """The path of the sensor: the given one, else the only one of the stage or of those that nodes name.

    Raises UserError, with the sensors of the stage, for a prim that is not a sensor.
    """
    from graph.base.suggest import did_you_mean
    from graph.sim.usd import Usd
    from sensors.products import sensor_problem

    prims = [str(prim.GetPath()) for prim in app.stage.Traverse(Usd.TraverseInstanceProxies())]
    sensors = [prim for prim in prims if sensor_problem(app.stage, prim) is None]
    if path is None:
        used = [one for one in dict.fromkeys(named) if one in sensors]
        for only in (sensors, used):
            if len(only) == 1:
                return only[0]
        there = f"it has {', '.join(sensors)}; choose with --sensor" if sensors else "it has none that can be rendered"
        raise UserError(f"which sensor of the scene? {there}")
    if path in sensors:
        return path
    if path in prims:
        raise UserError(f"--sensor {sensor_problem(app.stage, path)}")
    near = did_you_mean(path, sensors) or f"; there are {', '.join(sensors) or 'none that can be rendered'}"
    raise UserError(f"--sensor {path}: there is no such sensor{near}")


def inspect(session: Session, path: str, *, aux: str | None = None, updates: int | None = None) -> dict[str, Any]:
    """Plays a session until the sensor has a frame, for at most `updates`; returns the newest frame as plain data.

    aux: auxiliary level to read it with; None means the prim's. Raises RunError, with the reason, if no frame comes.
    """
    from graph.session.step_limit import check_steps
    from sensors.annotators.annotator import Annotator
    from sensors.annotators.registry import find_annotator
    from sensors.channels import Consumer
    from sensors.prim import write_aux_level
    from sensors.products import render_product
    from sensors.sensor_types import sensor_types

    from .explain_clocks import updates_of

    app = session.app
    if aux is not None:
        write_aux_level(app.stage.GetPrimAtPath(path), aux)
    product = render_product(app, path, product_size(app, path))
    kind = sensor_types()[product.sensor.type_name]
    is_points = "flags" in kind.measures  # then the elements can be made into a GenericModelOutput
    output = Annotator(find_annotator("GenericModelOutput"), app=app).attach(product) if is_points else None
    beside = kind.measures & {"objId"} if is_points else kind.measures  # hit prims are shown at every level
    product.sensor.require(Consumer("graph inspect"), beside, ignore_aux=True)
    most = updates or max(1, updates_of(session))
    app.play()
    check_steps(app)
    done, seen_in = 0, 0
    while done < most and not app.exit_requested and (updates is not None or product.frame is None):
        app.update()
        done += 1
        if product.new_frame:
            seen_in = done - 1
    if product.frame is None:
        raise RunError(f"{path}: no frame in {done:,} updates: {_why_not(app, product, done)}")
    return {"sensor": path, "update": seen_in, **_described(product, output, app)}


def _why_not(app: App, product: RenderProduct, done: int) -> str:
    if app.exit_requested:
        return "the graphs ended the run before"
    if not product.enabled:
        return f"its render product {product.path} is disabled"
    if not app.timeline.is_playing():
        return "the timeline does not play; a graph stopped or paused it"
    schedule = product.sensor.schedule
    rate, made = schedule.rate, product.created_at or Fraction(0)
    if app.external_time <= made:
        return "the renderer's clock did not move; physics makes no step in these updates"
    if rate and schedule.accumulates:
        first = Fraction(math.ceil(made * rate) + 1) / rate
        if first > app.external_time:
            needed = math.ceil(done * first / app.external_time)
            return f"at {float(rate):g} Hz its first scan ends at {float(first):g} s; give --updates {needed} or more"
    return "no tick fell due; graph explain shows its schedule"


def _described(product: RenderProduct, output: Annotator | None, app: App) -> dict[str, Any]:
    from sensors import parse_generic_model_output_data

    frame = product.frame
    if output is None:
        channels = {
            name: _array(name, array) | (_values(name, array) if array.size else {})
            for name, array in frame.arrays.items()
        }
        return {"header": _frame_header(frame), "channels": channels, "hits": _shown(app, product)}
    gmo = parse_generic_model_output_data(output.get_data())
    ids = product.sensor.object_ids(resolve_all=True)
    return {
        "header": _header(gmo) | dict(frame.facts),
        "channels": _channels(gmo, app, product),
        "hits": _hits(frame, ids),
    }


def _frame_header(frame: Frame) -> dict[str, Any]:
    """The header of a frame that cannot be made into a GenericModelOutput."""
    found: dict[str, Any] = {"numElements": frame.count, "frameId": frame.frame_id, "timestampNs": frame.timestamp_ns}
    for name, pose in (("frameStart", frame.start), ("frameEnd", frame.end)):
        w, x, y, z = pose.orientation.tolist()
        found[name] = {
            "timestampNs": pose.timestamp_ns,
            "orientation_ijkw": [x, y, z, w],
            "posM": pose.position_m.tolist(),
        }
    return found


def _header(gmo: Any) -> dict[str, Any]:
    found: dict[str, Any] = {
        "magicNumber": f"{gmo.magicNumber:#010x}",
        "version": f"{gmo.majorVersion}.{gmo.minorVersion}.{gmo.patchVersion}",
        "sizeInBytes": gmo.sizeInBytes,
        "numElements": gmo.numElements,
    }
    names = ("modality", "outputType", "auxType", "elementsCoordsType", "frameOfReference", "motionCompensationState")
    found |= {name: getattr(gmo, name).name for name in names}
    found |= {"frameId": gmo.frameId, "timestampNs": gmo.timestampNs}
    for name in ("frameStart", "frameEnd"):
        pose = getattr(gmo, name)
        found[name] = {
            "timestampNs": pose.timestampNs,
            "orientation_ijkw": pose.orientation.tolist(),
            "posM": pose.posM.tolist(),
        }
    found["filledAuxMembers"] = [bit.name for bit in gmo.filledAuxMembers] or ["NONE"]
    if gmo.auxType:
        found |= {"scanComplete": gmo.scanComplete, "azimuthOffset_deg": gmo.azimuthOffset}
    return found


def _channels(gmo: Any, app: App, product: RenderProduct) -> dict[str, Any]:
    from sensors.channels import CHANNELS
    from sensors.gmo import AUX_ARRAYS, ELEMENT_ARRAYS
    from sensors.sensor_types import sensor_types

    measures = sensor_types()[product.sensor.type_name].measures
    units = {
        "CARTESIAN": {"x": "m", "y": "m", "z": "m"},
        "SPHERICAL": {"x": "deg", "y": "deg", "z": "m"},
    }.get(gmo.elementsCoordsType.name, {})
    found = {}
    for name in (*ELEMENT_ARRAYS, *(name for name in AUX_ARRAYS if name in measures)):
        array = getattr(gmo, name)
        told = _array(name, array) | ({"unit": units[name]} if name in units else {})
        if len(array):
            told |= _values(name, array)
        elif gmo.numElements:
            told["empty_because"] = _why_empty(name, CHANNELS[name].level, gmo, app)
        found[name] = told
    return found


def _array(name: str, array: Any) -> dict[str, Any]:
    from sensors.channels import CHANNELS

    unit = CHANNELS[name].unit if name in CHANNELS else ""
    dtype = "record" if array.dtype.names else str(array.dtype)
    return {"dtype": dtype, "shape": list(array.shape), "unit": unit}


def _values(name: str, array: Any) -> dict[str, Any]:
    import numpy as np

    from sensors.channels import CHANNELS

    if name == "objId":
        from sensors import parse_object_ids

        numbers = parse_object_ids(array)
        return {"distinct": len(set(numbers)), "first": [f"{number:#034x}" for number in numbers[:FIRST_VALUES]]}
    if name in CHANNELS and CHANNELS[name].image:
        array = array.reshape(-1, *array.shape[2:])
    if array.dtype.names:
        rows = array[:FIRST_VALUES]
        return {"first": [{field: _short(row[field].tolist()) for field in array.dtype.names} for row in rows]}
    first = [_short(value) for value in array[:FIRST_VALUES].tolist()]
    finite = array[np.isfinite(array)]
    if not finite.size:
        return {"first": first}
    return {"min": finite.min().item(), "max": finite.max().item(), "first": first}


def _short(value: Any) -> Any:
    if isinstance(value, list):
        return [_short(part) for part in value]
    return float(f"{value:.7g}") if isinstance(value, float) else value


def _why_empty(name: str, level: Any, gmo: Any, app: App) -> str:
    from sensors.channels import CHANNELS

    if level > gmo.auxType:
        return f"needs --aux {level.name}"
    setting = CHANNELS[name].setting
    return f"needs --{setting}=true" if setting and not app.settings.get(setting, False) else "nobody fills it"


def _hits(frame: Any, ids: Mapping[int, str]) -> dict[str, int]:
    """Prim path -> number of elements that hit it, largest first."""
    from sensors import parse_object_ids

    counts: dict[str, int] = {}
    for number in parse_object_ids(frame.channel("objId")):
        path = ids.get(number, "") if number else ""
        counts[path or "(nothing)"] = counts.get(path or "(nothing)", 0) + 1
    return dict(sorted(counts.items(), key=lambda entry: (-entry[1], entry[0])))


def _shown(app: App, product: RenderProduct) -> dict[str, int]:
    """Prim path -> number of pixels that show it, largest first; empty for sensors without images."""
    import numpy as np

    from sensors.annotators.annotator import Annotator
    from sensors.annotators.registry import annotator_types
    from sensors.sensor_types import prim_types_of

    kind = annotator_types().get("instance_id_segmentation")
    if kind is None or product.sensor.type_name not in prim_types_of(kind.modality):
        return {}
    found = Annotator(kind, app=app).attach(product).get_data()
    numbers, pixels = np.unique(found["data"], return_counts=True)
    paths = found["info"]["idToLabels"]
    counts = {
        paths[number] if number else "(nothing)": count
        for number, count in zip(numbers.tolist(), pixels.tolist(), strict=True)
    }
    return dict(sorted(counts.items(), key=lambda entry: (-entry[1], entry[0])))


def as_text(told: Mapping[str, Any]) -> Iterator[str]:
    """The lines of text output."""
    header = told["header"]
    yield f"{told['file']}: {told['sensor']}, frame {header['frameId']} in update {told['update']}"
    yield ""
    yield "header"
    yield from aligned((name, _text(value)) for name, value in header.items())
    yield ""
    yield "channels"
    rows = []
    for name, one in told["channels"].items():
        row = [name, one["dtype"], "x".join(map(str, one["shape"])), one["unit"] or "-"]
        if "empty_because" in one:
            row += ["-", f"empty: {one['empty_because']}"]
        elif "first" not in one:
            row += ["-", "empty: no elements"]
        else:
            span = f"{one['distinct']} different" if "distinct" in one else _span(one)
            row += [span, "  ".join(_text(value) for value in one["first"])]
        rows.append(row)
    yield from aligned([("name", "dtype", "shape", "unit", "range", "first"), *rows])
    yield ""
    hits = told["hits"]
    if hits or "objId" in told["channels"]:
        yield "hits" if hits else "hits: none (object ids are off, or nothing was hit)"
    total = sum(hits.values())
    yield from aligned((path, f"{count:,}", f"{100 * count / total:.1f} %") for path, count in hits.items())


def _span(one: Mapping[str, Any]) -> str:
    return f"{one['min']:.6g} to {one['max']:.6g}" if "min" in one else "-"


def _text(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_text(part)}" for name, part in value.items())
    if isinstance(value, list):
        return " ".join(_text(part) for part in value) if value and isinstance(value[0], str) else _numbers(value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _numbers(values: list[Any]) -> str:
    return f"({', '.join(_text(value) for value in values)})"
