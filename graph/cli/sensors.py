"""`graph sensors`: lists the shipped sensor configurations, or describes one with its variants."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from .printing import aligned, on_terminal, print_table, safe_line, say, say_json

if TYPE_CHECKING:
    from sensors.configs.catalog import Variant
    from sensors.configs.shipped import AnyAsset

CAMERA_AXES = "x right, y up, z back: the camera looks along -z"
ANGLES = ("azimuth_deg", "elevation_deg")
HEADINGS = ("NAME", "HZ", "RAYS", "AZIMUTH", "ELEVATION", "RANGE m", "VARIANTS")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("name", nargs="?", metavar="NAME", help="a configuration, by any of its spellings")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")


def run(args: argparse.Namespace) -> int:
    """Runs the command. Raises UserError for an unknown name."""
    from sensors.configs.shipped import all_assets, find_asset

    if args.name is None:
        if args.json:
            say_json([described(asset) for asset in all_assets()])
        else:
            print_table([row(described(asset), on_terminal()) for asset in all_assets()], HEADINGS)
        return 0
    asset, variant = find_asset(args.name)
    found = described(asset, variant)
    if args.json:
        say_json(found)
    else:
        for line in _page(asset, found):
            say(line)
    return 0


def described(asset: AnyAsset, variant: Variant = None) -> dict[str, Any]:
    """An asset as plain data: its spellings, its variants, the figures of one variant (None: its default)."""
    from sensors.configs.shipped import AXES

    figures = asset.figures(variant)
    return {
        "name": asset.short_name,
        "asset": asset.path,
        "spellings": list(asset.spellings),
        "source": asset.source,
        "axes": CAMERA_AXES if figures["modality"] == "camera" else AXES,
        "variant": variant if variant is not None else asset.default,
        "variants": list(asset.variants),
        **figures,
    }


def row(found: Mapping[str, Any], short: bool) -> Sequence[str]:
    """The cells of a line; short: angles from 10 degrees on as whole ones, so that 80 columns hold them."""
    return (
        found["name"],
        "-" if found["scan_rate_hz"] is None else f"{found['scan_rate_hz']:g}",
        f"{found['rays_per_scan']:,}",
        *(_short_span(found[key]) if short else _span(found[key], "..") for key in ANGLES),
        _span(found["range_m"], "..").replace("e+0", "e"),
        str(len(found["variants"]) or 1),
    )


def _short_span(edges: Sequence[float]) -> str:
    return "..".join(f"{edge:.0f}" if abs(edge) >= 10 else f"{edge:.2g}" for edge in edges)


def _span(edges: Sequence[float], to: str) -> str:
    return to.join(f"{edge:.4g}" for edge in edges)


def _page(asset: AnyAsset, found: Mapping[str, Any]) -> Iterator[str]:
    yield f"{found['name']} ({found['asset']})"
    if found["variant"] is not None:
        yield f"figures of variant {_choice(found['variant'])}"
    yield ""
    kind = found["modality"]
    yield from aligned({"camera": _camera_rows, "lidar": _lidar_rows, "radar": _radar_rows}[kind](found))
    yield ""
    yield "in a graph file:"
    variant = f", variant: {_choice(found['variant'])}" if found["variant"] is not None else ""
    turned = ", rotate: [90, 0, -90]" if kind == "camera" else ""
    name = f"/World/{kind.capitalize()}"
    yield f"  {name}: {{type: {asset.prim_type}, config: {found['name']}{variant}, translate: [0, 0, 1]{turned}}}"
    if found["variants"]:
        yield ""
        yield f"variants ({len(found['variants'])}):"
        yield from (f"  {_choice(variant)}" for variant in found["variants"])
    yield ""
    yield f"spellings: {', '.join(found['spellings'])}"
    yield safe_line(f"source: {found['source']}")


def _lidar_rows(found: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    turns = f", {'clockwise' if found['rotation'] == 'CW' else 'counter-clockwise'}" if found["rotation"] else ""
    return (
        ("type", f"{found['modality']}, {found['scan_type'].lower().replace('_', ' ')}{turns}"),
        ("scan rate", f"{found['scan_rate_hz']:g} Hz (its tickRate, unless you author another)"),
        ("firing rate", f"{found['firing_rate_hz']:,g} Hz"),
        ("emitters", f"{found['emitters']:,} emitters at {found['elevations']:,} elevations"),
        ("rays a scan", f"{found['rays_per_scan']:,}"),
        ("azimuth", _span(found["azimuth_deg"], " to ") + "°"),
        ("elevation", _span(found["elevation_deg"], " to ") + "°"),
        ("range", _span(found["range_m"], " to ") + " m"),
        ("returns", str(found["returns"])),
        ("wavelength", f"{found['wavelength_nm']:g} nm"),
        ("axes", found["axes"]),
    )


def _camera_rows(found: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    width, height = found["resolution"]
    across, down = (2 * found[key][1] for key in ("azimuth_deg", "elevation_deg"))
    depth = (("baseline", f"{found['baseline_mm']:g} mm"),) if found["baseline_mm"] else ()
    shutter = f", {found['shutter']} shutter" if found["shutter"] else ""
    return (
        ("type", f"camera{shutter}"),
        ("frame rate", f"{found['scan_rate_hz']:g} Hz at most (author omni:sensor:tickRate; else every update)"),
        ("image", f"{width} x {height} pixels: the size to give its render product"),
        ("field of view", f"{across:.4g}° x {down:.4g}° through the middle, edge to edge"),
        ("lens", f"{found['lens']}, focal length {found['focal_length_px']:g} px"),
        *depth,
        ("range", _span(found["range_m"], " to ") + " m"),
        ("axes", found["axes"]),
    )


def _radar_rows(found: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    return (
        ("type", "radar"),
        ("frame rate", "every update, unless you author omni:sensor:tickRate"),
        ("rays a scan", f"{found['rays_per_scan']:,}"),
        ("azimuth", _span(found["azimuth_deg"], " to ") + "°"),
        ("elevation", _span(found["elevation_deg"], " to ") + "°"),
        ("range", f"{_span(found['range_m'], ' to ')} m, resolution {found['range_resolution_m']:g} m"),
        (
            "velocity",
            f"folds at {' and '.join(f'{one:g}' for one in found['velocities_mps'])} m/s, "
            f"resolution {found['velocity_resolution_mps']:g} m/s",
        ),
        ("wavelength", f"{found['wavelength_mm']:g} mm"),
        ("axes", found["axes"]),
    )


def _choice(variant: Any) -> str:
    """A variant as a graph file writes it."""
    return variant if isinstance(variant, str) else "{" + ", ".join(f"{k}: {v}" for k, v in variant.items()) + "}"
