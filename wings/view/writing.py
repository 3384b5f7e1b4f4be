"""Writes the page of a recording and its pictures: `view.html` and PNG files."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import UserError
from graph.base.extras import install_command
from graph.base.outputs import make_folder, replacing, write
from graph.base.shorten import printable
from graph.recording.contents.file_names import file_names
from graph.sim.messages.message import SENSOR

from .boundary import embedded, policy
from .clouds import CloudPanel, titled
from .collecting import Collected, Picture, collect, source_of
from .pictures import top_view
from .scene import cloud_groups, scene
from .times import clocks

if TYPE_CHECKING:
    from graph.recording.run_reader import RunReader

PAGE = "view.html"
SCRIPTS = ("page.js", "scene.js", "panels.js")
PICTURE_PERIOD = 1.0
"""Seconds of simulation between the PNG files of a topic."""
MEGABYTE = 1_000_000
SCRIPT_SIZE = 5 * MEGABYTE
"""Of plotly's script, about."""


def write_view(
    run: RunReader, sizes: Mapping[str, float], said: Mapping[str, str], summary: str, out: Path, megabytes: float
) -> tuple[list[Path], list[str]]:
    """Writes the page and the pictures of these topics into the folder `out`.

    sizes, said: by topic the mean size [bytes] of a message, and a line about it. summary: about the run. megabytes:
    the size that the page keeps below, about.
    Returns the files, and a line about each message that is left out. Raises UserError without plotly.
    """
    plotly = plotly_code()
    found = collect(run, sizes, max(1, int(megabytes * MEGABYTE) - SCRIPT_SIZE))
    script = "".join(map(_asset, SCRIPTS))
    page = Template(_asset("page.html")).substitute(
        title=html.escape(printable(Path(run.name).name or run.name)),
        summary=html.escape(printable(summary)),
        policy=policy(plotly, script),
        style=_asset("page.css"),
        script=script,
        plotly=plotly,
        data=embedded(page_data(run, found, said)),
    )
    file = make_folder(out) / PAGE
    write(file, page)
    return [file, *write_pictures(found, out)], found.problems


def page_data(run: RunReader, found: Collected, said: Mapping[str, str]) -> dict[str, Any]:
    """What the page's script draws."""
    stamps = [one for topic in found.times.values() for one in topic.stamps]
    warnings = (run.report or {}).get("warnings", [])
    noted = [["recording", "", note] for note in (*run.notes, *found.problems)]
    rows = [{**row, "clock": True} for row in clocks(run.report, found.times)]
    radars = [data for panel in found.clouds.values() if (data := radar_data(panel))]
    groups = cloud_groups(found, {name: topic.metadata.get(SENSOR, "") for name, topic in run.recorded.items()})
    return {
        "scene": scene(found, [group["clouds"][0] for group in groups]),
        "start": min(stamps, default=0) / 1e9,
        "end": max(stamps, default=0) / 1e9,
        "palette": _scale(),
        "topics": [[name, run.recorded[name].type_name, said.get(name, "")] for name in found.counts],
        "warnings": [*noted, *([_text(one, key) for key in ("code", "where", "message")] for one in _dicts(warnings))],
        "clouds": [
            {
                **panel.data(),
                "count": found.counts[name],
                "ranges": _sources(found.ranges.get(name, ())) or None,
            }
            for name, panel in found.clouds.items()
        ],
        "groups": [group for group in groups if not {one["topic"] for one in radars} & set(group["topics"])],
        "radars": radars,
        "pictures": [
            {"topic": name, "count": found.counts[name], "frames": _sources(pictures)}
            for name, pictures in found.pictures.items()
        ],
        "values": [data for series in found.values.values() if (data := series.data())["quantities"]],
        "poses": found.poses,
        "boxes": [{"topic": name, "frames": shown} for name, shown in found.boxes.items()],
        "lenses": list(found.lenses.values()),
        "rows": [*rows, *(topic.data() for topic in found.times.values())],
    }


def _sources(pictures: Iterable[Picture]) -> list[dict[str, Any]]:
    return [source_of(one) for one in sorted(pictures, key=lambda one: one.stamp_ns)]


def radar_data(panel: CloudPanel) -> dict[str, Any] | None:
    """Range, velocity and place of every detection, for a cloud with radial velocities; else None."""
    names = {name for frame in panel.frames for name in frame.values}
    velocity = next((name for name in sorted(names) if "radial" in name.lower()), None)
    if velocity is None:
        return None
    colour = next((name for name in ("rcs", "intensity", "snr") if name in names), velocity)
    shown = [frame for frame in panel.frames if {velocity, colour} <= frame.values.keys()]  # fields may change
    frames = [
        {
            "t": frame.stamp_ns / 1e9,
            "v": _rounded(frame.values[velocity]),
            "r": _rounded(frame.values["range [m]"]),
            "x": _rounded(frame.local[:, 0]),
            "y": _rounded(frame.local[:, 1]),
            "c": _rounded(frame.values[colour]),
        }
        for frame in shown
    ]
    strengths = [one for frame in shown for one in np.nan_to_num(frame.values[colour]).tolist()]
    low, high = np.percentile(strengths, (1, 99)) if strengths else (0.0, 1.0)
    return {
        "topic": panel.topic,
        "colour": "intensity [dB]" if colour == "intensity" else titled(colour),
        "low": float(low),
        "high": float(high),
        "frames": frames,
    }


def write_pictures(found: Collected, out: Path) -> list[Path]:
    """One PNG a second of each camera, each range image and each cloud from above."""
    written: list[Path] = []
    names = file_names([*found.pictures, *found.ranges, *found.clouds], ("", "_range", "_top"))

    def write(what: str, pictures: Iterable[tuple[int, Callable[[], Any]]]) -> None:
        due = -np.inf
        for stamp_ns, image in pictures:
            if stamp_ns / 1e9 < due:
                continue
            due = stamp_ns / 1e9 + PICTURE_PERIOD - 1e-9
            path = out / f"{what}_{stamp_ns // 1_000_000:08d}ms.png"
            with replacing(path) as stream:
                image().save(stream, "PNG")
            written.append(path)

    for kinds, suffix in ((found.pictures, ""), (found.ranges, "_range")):
        for name, pictures in kinds.items():
            write(names[name] + suffix, ((one.stamp_ns, partial(_image, one)) for one in pictures))
    for name, panel in found.clouds.items():
        if (span := panel.span()) is not None:
            views = (
                (one.stamp_ns, partial(top_view, one.places, *span, one.pose))
                for one in panel.frames
                if len(one.places)
            )
            write(f"{names[name]}_top", views)
    return written


def _image(picture: Picture) -> Any:
    return picture.image


def _rounded(values: Any) -> list[float]:
    return [float(f"{one:.5g}") for one in np.nan_to_num(np.asarray(values, np.float64)).tolist()]


def _dicts(value: Any) -> list[Mapping[str, Any]]:
    return [one for one in value if isinstance(one, dict)] if isinstance(value, list) else []


def _text(value: Mapping[str, Any], key: str) -> str:
    return str(value.get(key, ""))


def _asset(name: str) -> str:
    return (files(__package__) / "page" / name).read_text(encoding="utf-8")


def _scale() -> list[list[Any]]:
    from plotly.colors import get_colorscale

    return [[float(place), colour] for place, colour in get_colorscale("Turbo")]


def plotly_code() -> str:
    """The script of plotly.js, for the page to carry."""
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise UserError(f"graph view needs plotly. Run: {install_command('view')}") from None
    return str(get_plotlyjs()).replace("</script", "<\\/script")
