"""The hero of the README: what all sensors of the yard see, and when."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from drawing import (
    BACK,
    BLUE,
    GREEN,
    HEIGHTS,
    INK,
    RED,
    SECOND,
    SOFT,
    YELLOW,
    Runs,
    axes,
    badge,
    figure,
    image_at,
    messages,
    save,
    scans,
    transforms,
)
from lens import Lens, blank, halved
from matplotlib.colors import to_rgb

from graph.recording.contents.poses import TransformLog
from graph.recording.run_reader import RunReader, open_run

CAMERA = "/World/SensorGraph/camera_product"
YARD = "graphs/yard.yaml"
TIME = 2.4


def yard_run(runs: Runs) -> Path:
    """The yard with a larger image, so that it can be looked at."""
    size = ("--set", f"{CAMERA}.width=640", "--set", f"{CAMERA}.height=360", "--fidelity", "camera.samples=4")
    return runs.play("yard", YARD, "--duration", "3", *size)


def yard(runs: Runs) -> None:
    """The hero: the cloud of a second, what camera and radar see at one time, and the ticks of all."""
    made = figure(
        1060, "A delivery robot crosses a yard: lidars, radar, camera, each at its own rate", f"graph run {YARD}"
    )
    with open_run(yard_run(runs)) as run:
        log = transforms(run)
        _yard_cloud(axes(made, 24, 66, 1010, 640), run, log)
        seen = axes(made, 1050, 66, 526, 296)
        seen.imshow(image_at(run, "/camera/rgb", TIME)[..., :3], aspect="auto")
        seen.set(xticks=[], yticks=[])
        badge(seen, f"camera, 10 Hz, at {TIME:g} s")
        _yard_radar(axes(made, 1110, 392, 466, 256), run)
        _ticks(axes(made, 236, 730, 1340, 232), run)
    save(made, "yard")


def _yard_cloud(axis: Any, run: RunReader, log: TransformLog) -> None:
    size = (2020, 1280)
    robot = log.poses("Chassis", np.array([round(TIME * SECOND)]))[0]
    lens = Lens((-17.5, -17, 11.5), (-1.2, 0.2, 0.3), size, 62)
    picture = blank(size)
    top = scans(run, "/top/points", log, TIME - 0.95, TIME + 0.01)
    places = np.concatenate([one.in_world() for one in top])
    heights = HEIGHTS(np.clip((places[:, 2] + 0.1) / 5.6, 0, 1) ** 0.75)[:, :3]
    ground = places[:, 2] < 0.08
    heights[ground] = to_rgb("#35477d")
    lens.draw(picture, places, heights, 0.055, 62)
    axis.imshow(halved(picture), extent=(0, size[0], size[1], 0), aspect="auto", interpolation="nearest")
    axis.set(xticks=[], yticks=[], xlim=(0, size[0]), ylim=(size[1], 0))

    def line(points: Any, **more: Any) -> None:
        at, _ = lens.project(np.asarray(points))
        axis.plot(at[:, 0], at[:, 1], **more)

    front = scans(run, "/front/points", log, TIME - 0.01, TIME + 0.01)[0].in_world()
    line(front, linestyle="none", marker=".", markersize=2.6, color="#ffffff")
    radar = scans(run, "/radar/points", log, TIME - 0.01, TIME + 0.01)[0]
    line(
        radar.in_world(),
        linestyle="none",
        marker="D",
        markersize=7,
        color=RED,
        markeredgecolor=BACK,
        markeredgewidth=0.7,
    )
    times = np.linspace(0.1, TIME, 60) * SECOND
    path = log.poses("Chassis", times.astype(np.int64))[:, :3, 3] * (1, 1, 0)
    line(path, color=YELLOW, linewidth=2.5)
    _robot(line, robot)
    eye = log.poses("camera", np.array([round(TIME * SECOND)]))[0]
    corners = np.array([(x, y, 1.0) for x, y in ((-0.58, -0.33), (0.58, -0.33), (0.58, 0.33), (-0.58, 0.33))]) * 2.6
    corners = corners @ eye[:3, :3].T + eye[:3, 3]
    for corner in corners:
        line([eye[:3, 3], corner], color=YELLOW, linewidth=1, alpha=0.9)
    line([*corners, corners[0]], color=YELLOW, linewidth=1, alpha=0.9)
    badge(axis, f"lidar of 32 channels, 10 Hz: a second until {TIME:g} s, put together by TF, coloured by height")
    for place, (text, colour, mark) in enumerate(
        (
            ("planar lidar, 20 Hz", "#ffffff", "."),
            ("radar, 10 Hz", RED, "D"),
            ("path, and what the camera sees", YELLOW, "_"),
        )
    ):
        x = (0.02, 0.23, 0.38)[place]
        axis.plot(x, 0.035, mark, color=colour, transform=axis.transAxes, markersize=9, markeredgewidth=2)
        axis.text(x + 0.015, 0.035, text, transform=axis.transAxes, va="center", size=14)


def _robot(line: Callable[..., None], pose: np.ndarray) -> None:
    """The chassis as a box of 0.7 x 0.44 x 0.5 m, and its three axes."""
    signs = np.array([(x, y, z) for x in (-0.35, 0.35) for y in (-0.22, 0.22) for z in (-0.1, 0.45)])
    corners = signs @ pose[:3, :3].T + pose[:3, 3]
    for a, b in ((0, 1), (0, 2), (0, 4), (1, 3), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 6), (5, 7), (6, 7)):
        line(corners[[a, b]], color=INK, linewidth=1.6)
    for axis, colour in enumerate((RED, GREEN, BLUE)):
        line([pose[:3, 3], pose[:3, 3] + 1.3 * pose[:3, axis]], color=colour, linewidth=3)


def _yard_radar(axis: Any, run: RunReader) -> None:
    log = TransformLog()
    for scan in scans(run, "/radar/points", log):
        now = abs(scan.stamp_ns / SECOND - TIME) < 0.01
        speed, range_m = scan.points["radial_velocity_ms"], np.linalg.norm([scan.points[one] for one in "xyz"], axis=0)
        if now:
            axis.scatter(
                speed, range_m, 55, scan.points["intensity"], cmap=HEIGHTS, edgecolors=BACK, linewidths=0.6, zorder=3
            )
        else:
            axis.scatter(speed, range_m, 4, color="#4c5a6b", zorder=2)
    axis.set(xlabel="radial velocity [m/s]", ylabel="range [m]", xlim=(-4.5, 3.5), ylim=(0, 52))
    axis.grid(linewidth=0.6)
    badge(axis, f"radar, 10 Hz, at {TIME:g} s (grey: all)")


def _ticks(axis: Any, run: RunReader) -> None:
    """The clocks and the stamps of all sensors over the first second."""
    rows = [
        ("physics, 240 Hz", np.arange(1, 241) / 240, SOFT),
        ("updates, 60 Hz", np.arange(1, 61) / 60, INK),
        *(
            (label, np.array([stamp for stamp, _, _ in messages(run, topic)]), colour)
            for label, topic, colour in (
                ("lidar, 10 Hz", "/top/points", BLUE),
                ("planar lidar, 20 Hz", "/front/points", "#ffffff"),
                ("radar, 10 Hz", "/radar/points", RED),
                ("camera, 10 Hz", "/camera/rgb", YELLOW),
            )
        ),
    ]
    for row, (_, times, colour) in enumerate(rows):
        shown = times[times <= 1.0 + 1e-9]
        thick = 1.2 if len(shown) > 100 else 2 if len(shown) > 30 else 4
        axis.vlines(shown, row - 0.34, row + 0.34, color=colour, linewidth=thick)
    axis.set(
        xlim=(-0.005, 1.005),
        ylim=(len(rows) - 0.4, -0.6),
        xlabel="stamps: simulation time [s], exact to the nanosecond",
    )
    axis.set_yticks(range(len(rows)), [name for name, _, _ in rows])
    axis.tick_params(length=0, axis="y")
    axis.grid(axis="x", linewidth=0.6)
