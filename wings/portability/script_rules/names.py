"""Rules on what a script names: modules, extensions, classes, annotators, properties."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from graph.base.suggest import did_you_mean
from graph.isaac.names import names_of
from graph.isaac.syntax import Script
from wings.portability.renamed import ANNOTATORS, CLASSES, COMPLETE, DEPRECATED, GONE, PARSERS, STILL_THERE, replacement

from .reading import Found, argument, finds


@finds("import-renamed")
def _gone(script: Script) -> Iterator[Found]:
    for name, place in script.imports:
        if instead := replacement(name, GONE):
            yield place, f"{name} is now in {instead}"


@finds("module-unknown")
def _unknown(script: Script) -> Iterator[Found]:
    for name, place in script.imports:
        package = next((one for one in sorted(COMPLETE, key=len)[::-1] if name.startswith(f"{one}.")), "")
        module = name.removeprefix(f"{package}.").partition(".")[0]
        known = not package or module in (*COMPLETE[package].split(), "*") or names_of(f"{package}.{module}").known
        if not known and not replacement(name, GONE):
            yield place, f"{package} has no module {module}{did_you_mean(module, COMPLETE[package].split())}"


@finds("module-deprecated")
def _deprecated(script: Script) -> Iterator[Found]:
    told: set[str] = set()
    for name, place in script.imports:
        module = next((one for one in sorted(DEPRECATED, key=len)[::-1] if f"{name}.".startswith(f"{one}.")), "")
        if module and not replacement(name, GONE) and module not in told and not name.startswith(STILL_THERE):
            told.add(module)
            yield place, f"{module} gives way to {DEPRECATED[module]}"


@finds("extension-renamed")
def _extensions(script: Script) -> Iterator[Found]:
    for call, name in script.called:
        if name.endswith(("enable_extension", "set_extension_enabled_immediate", "set_extension_enabled")):
            extension = script.value_of(argument(call, 0, "name"))
            if isinstance(extension, str) and (instead := replacement(extension, GONE)):
                yield call, f"{extension} is now {instead}"


@finds("class-deprecated")
def _classes(script: Script) -> Iterator[Found]:
    for call, name in script.called:
        called = name.rpartition(".")[2]
        if called == "execute" and name.startswith("omni.kit.commands"):
            called = str(script.value_of(argument(call, 0, "name"))).removesuffix("Command")
        if instead := CLASSES.get(called):
            yield call, f"{called} gives way to {instead}"


@finds("gmo-parser-deprecated")
def _parsers(script: Script) -> Iterator[Found]:
    for call, name in script.called:
        if instead := PARSERS.get(name.rpartition(".")[2]):
            yield call, f"{name.rpartition('.')[2]} gives way to {instead}"


@finds("annotator-deprecated")
def _annotators(script: Script) -> Iterator[Found]:
    for node in script.nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and (instead := ANNOTATORS.get(node.value)):
            yield node, f"{node.value} gives way to {instead}"


@finds("next-render-simulation-deprecated")
def _one_product(script: Script) -> Iterator[Found]:
    for call, name in script.called:
        if name.endswith(("next_render_simulation_async", "next_sensor_data_async")):
            yield call, f"{name.rpartition('.')[2]} waits for one render product"


@finds("gmo-attribute-missing")
def _no_such_property(script: Script) -> Iterator[Found]:
    for node in script.nodes:
        if not isinstance(node, ast.Attribute) or node.attr not in ("azimuth", "elevation", "distance"):
            continue
        if script.name_of(node.value).endswith(("parse_generic_model_output_data()", "get_gmo_data()")):
            yield node, f".{node.attr} does not exist"


@finds("object-id-without-entry")
def _subscripted(script: Script) -> Iterator[Found]:
    for node in script.nodes:
        if not isinstance(node, ast.Subscript) or not isinstance(node.ctx, ast.Load):
            continue
        if script.name_of(node.value).endswith(("parse_stable_id_map_data()", "decode_stable_id_mapping()")):
            yield node, "the map is subscripted"
