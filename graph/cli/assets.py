"""`graph assets`: what a scene, graph file or script wants from other files, and where each is looked for."""

from __future__ import annotations

import argparse
import ast
from collections.abc import Iterator, Sequence
from pathlib import Path

from .arguments import add_allow
from .printing import counted, print_table, say, say_json

SCENES = (".usd", ".usda", ".usdc", ".usdz")
Wanted = tuple[str, str, str, str]
"""Asset path as written; `found`, `stand-in`, `missing` or `outside`; its place; who names it."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("file", metavar="FILE", type=Path, help="USD scene, graph file, or Python script (only read)")
    parser.add_argument("--json", action="store_true", help="print the list as JSON and nothing else on stdout")
    add_allow(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command."""
    found = list({one[0]: one for one in _wanted(args.file, args.allow)}.values())
    if args.json:
        say_json({"assets": [dict(zip(("asset", "state", "place", "wanted_by"), one, strict=True)) for one in found]})
        return 0
    if found:
        print_table([(state, asset, place) for asset, state, place, _ in found], ("state", "asset", "where"))
    missing = sum(state == "missing" for _, state, _, _ in found)
    say(f"{args.file}: {counted(len(found), 'assets')}, {missing} missing")
    return 0


def _wanted(file: Path, allow: Sequence[Path]) -> Iterator[Wanted]:
    if file.suffix.lower() == ".py":
        yield from _of_script(file)
    elif file.suffix.lower() in SCENES:
        yield from _of_scene(file.absolute(), [file.absolute().parent, *allow])
    else:
        yield from _of_graph_file(file, allow)


def _of_scene(scene: Path, roots: Sequence[Path]) -> Iterator[Wanted]:
    from graph.sim.scene.layers import wanted_assets
    from graph.sim.scene.stage import register_schemas

    register_schemas()
    yield from ((asset, *rest) for asset, rest in wanted_assets(scene, roots).items())


def _of_graph_file(file: Path, allow: Sequence[Path]) -> Iterator[Wanted]:
    from graph.base.errors import UserError
    from graph.files import examine

    examined = examine(file, allow=allow)
    spec = examined.spec
    if spec is None:
        raise UserError(examined.problems)
    roots = [file.absolute().parent, *allow]
    for model in (spec.scene.usd, spec.scene.mjcf):
        if model is not None:
            yield str(model), "found", str(model), str(file)
            if model.suffix.lower() in SCENES:
                yield from _of_scene(model, roots)
    for path, keys in spec.scene.prims.items():
        if isinstance(asset := keys.get("reference"), str):
            one = _looked_up(asset, file.absolute().parent, path)
            yield one
            if one[1] == "found":
                yield from _of_scene(Path(one[2]), roots)


def _of_script(file: Path) -> Iterator[Wanted]:
    """The texts in a script that name assets; what stands before `/Isaac/` is known only when it runs."""
    from graph.isaac.syntax import read_script

    script = read_script(file)
    for node in script.nodes:
        text = node.value if isinstance(node, ast.Constant) else None
        if isinstance(text, str) and text.lower().endswith(SCENES) and "\n" not in text:
            yield _looked_up(text, file.absolute().parent, f"{file}:{getattr(node, 'lineno', 1)}")


def _looked_up(asset: str, folder: Path, by: str) -> Wanted:
    from graph.sim.scene import assets

    try:
        file = assets.mapped(asset) or folder / asset
    except ValueError as error:
        return asset, "outside", str(error), by
    if file.is_file():
        return asset, "found", str(file), by
    if stand_in := assets.stand_in(asset):
        return asset, "stand-in", stand_in.what, by
    return asset, "missing", assets.looked_for(asset, folder), by
