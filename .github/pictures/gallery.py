"""The gallery of the README: lidar, radar, depth and labels, clocks, speed against accuracy."""

from __future__ import annotations

import json
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from drawing import (
    BACK,
    BLUE,
    GREEN,
    HEIGHTS,
    INK,
    LINE,
    PANEL,
    RED,
    SECOND,
    SOFT,
    VIOLET,
    YELLOW,
    Runs,
    axes,
    figure,
    graph,
    image_at,
    messages,
    save,
    scans,
    transforms,
    write,
)
from matplotlib.colors import to_rgb
from PIL import Image
from yard import TIME, YARD, yard_run

from graph.recording.run_reader import open_run

RADAR, CAMERA = "graphs/radar.yaml", "graphs/camera.yaml"
SHADES = {
    "ball": YELLOW,
    "barrel": BLUE,
    "building": VIOLET,
    "crate": RED,
    "floor": "#5f7a5c",
    "BACKGROUND": "#26303c",
}


def _from_above(axis: Any, far: float, step: float) -> None:
    """Rings of equal range about the sensor, with their ranges, and its mark; ahead is up."""
    turn = np.linspace(0, 2 * np.pi, 200)
    for ring in np.arange(step, far + step / 2, step):
        axis.plot(ring * np.cos(turn), ring * np.sin(turn), color=LINE, linewidth=1, zorder=0)
        axis.text(
            0,
            ring,
            f"{ring:g} m",
            ha="center",
            va="center",
            size=11,
            color=SOFT,
            zorder=1,
            clip_on=True,
            bbox={"facecolor": PANEL, "edgecolor": "none", "pad": 1},
        )
    axis.plot(0, 0, marker="^", markersize=13, color=INK, zorder=5)
    axis.set(xlabel="left [m]", ylabel="ahead [m]", aspect="equal")


def lidar(runs: Runs) -> None:
    """One turn of the lidar on the mast: from above, as ranges, and as intensities."""
    made = figure(760, "A lidar of 32 channels, one turn", f"graph run {YARD} && graph view out/yard")
    with open_run(yard_run(runs)) as run:
        (scan,) = scans(run, "/top/points", transforms(run), TIME - 0.01, TIME + 0.01)
    points = scan.points
    x, y, z = (points[axis].astype(float) for axis in "xyz")
    distance = np.sqrt(x * x + y * y + z * z)
    above = axes(made, 90, 96, 560, 560, "from above, by height [m]")
    order = np.argsort(z)
    above.scatter(y[order], x[order], 0.7, z[order] + 1.05, cmap=HEIGHTS, vmin=-0.1, vmax=5, linewidths=0, zorder=3)
    _from_above(above, 40, 10)
    above.set(xlim=(33, -33), ylim=(-33, 33))
    rings, row = np.unique(points["ring"], return_inverse=True)
    mean = np.bincount(row, np.arcsin(z / distance)) / np.bincount(row)
    place = np.empty(len(rings), int)
    place[np.argsort(-mean)] = np.arange(len(rings))
    columns = 800
    column = np.clip(((np.pi - np.arctan2(y, x)) / (2 * np.pi) * columns).astype(int), 0, columns - 1)
    for top, values, high, title in (
        (96, distance, 30, "ranges [m]"),
        (406, points["intensity"].astype(float), np.percentile(points["intensity"], 98), "intensities"),
    ):
        image = np.full((len(rings), columns), np.nan)
        far = np.argsort(-distance)
        image[place[row[far]], column[far]] = values[far]
        axis = axes(made, 740, top, 740, 250, title)
        shown = axis.imshow(
            image,
            cmap=HEIGHTS if high > 2 else "magma",
            vmin=0,
            vmax=high,
            aspect="auto",
            extent=(180, -180, -16, 15),
            interpolation="nearest",
        )
        axis.set(xticks=(180, 90, 0, -90, -180), ylabel="elevation [°]")
        bar = made.colorbar(shown, cax=axes(made, 1500, top, 16, 250))
        bar.outline.set_edgecolor(LINE)
    axis.set_xlabel("azimuth [°], ahead in the middle", labelpad=0)
    save(made, "lidar")


def radar(runs: Runs) -> None:
    """Detections of five seconds: a corner reflector that stands, a ball that comes nearer at 3 m/s."""
    made = figure(
        700, "A radar: a corner reflector stands, a ball rolls by at 3 m/s", f"graph run {RADAR} --out out/radar"
    )
    with open_run(runs.play("radar", RADAR)) as run:
        found = scans(run, "/radar_point_cloud", transforms(run))
    stamps = np.concatenate([np.full(len(one.points), one.stamp_ns / SECOND) for one in found])
    points = np.concatenate([one.points for one in found])
    distance = np.sqrt(points["x"] ** 2 + points["y"] ** 2 + points["z"] ** 2)
    time = axes(made, 90, 96, 620, 490, "range over time, by radial velocity [m/s]")
    shown = time.scatter(
        stamps, distance, 16, points["radial_velocity_ms"], cmap="coolwarm_r", vmin=-3, vmax=3, linewidths=0
    )
    time.set(xlabel="time [s]", ylabel="range [m]", ylim=(0, 36), xlim=(0, 5.05))
    time.grid(linewidth=0.6)
    made.colorbar(shown, cax=axes(made, 724, 96, 16, 490)).outline.set_edgecolor(LINE)
    above = axes(made, 890, 96, 600, 490, "from above, by intensity [dB]")
    shown = above.scatter(points["y"], points["x"], 16, points["intensity"], cmap=HEIGHTS, linewidths=0, zorder=3)
    _from_above(above, 30, 10)
    above.set(xlim=(21, -21), ylim=(-1, 33.3))
    made.colorbar(shown, cax=axes(made, 1510, 96, 16, 490)).outline.set_edgecolor(LINE)
    save(made, "radar")


def depth_labels(runs: Runs) -> None:
    """Colours with boxes, depth and labels of one image."""
    size = ("--set", "/World/ActionGraph/product.width=640", "--set", "/World/ActionGraph/product.height=480")
    made = figure(560, "A camera: colours and boxes, depth, labels", f"graph run {CAMERA} --out out/camera")
    when = 0.6
    with open_run(runs.play("camera", CAMERA, *size, "--fidelity", "camera.samples=4")) as run:
        rgb, depth, labels = (image_at(run, topic, when) for topic in ("/rgb", "/depth", "/labels"))
        boxes = min(messages(run, "/boxes"), key=lambda one: abs(one[0] - when))[2]
        names = json.loads(messages(run, "/semantic_labels")[0][2].data)
    names = {int(key): one["class"] for key, one in names.items() if key.isdigit()}
    panels = [
        axes(made, 24 + 520 * place, 96, 508, 381, title)
        for place, title in enumerate(("colours, boxes", "depth [m]", "labels"))
    ]
    panels[0].imshow(rgb[..., :3])
    for one in boxes.detections:
        at, wide, high = one.bbox.center.position, one.bbox.size_x, one.bbox.size_y
        if wide < 600:
            corner = (at.x - wide / 2, at.y - high / 2)
            panels[0].add_patch(plt.Rectangle(corner, wide, high, fill=False, edgecolor=GREEN, linewidth=2))
    shown = panels[1].imshow(np.where(np.isfinite(depth) & (depth > 0), depth, np.nan), cmap=HEIGHTS)
    bar = made.colorbar(shown, cax=axes(made, 1000, 110, 14, 150))
    bar.ax.tick_params(labelcolor=INK, labelsize=12)
    bar.ax.yaxis.set_ticks_position("left")
    image = np.zeros((*labels.shape[:2], 3))
    for number, name in names.items():
        image[labels.reshape(labels.shape[:2]) == number] = to_rgb(SHADES.get(name, "#808080"))
    panels[2].imshow(image)
    for number, name in names.items():
        rows, columns = np.nonzero(labels.reshape(labels.shape[:2]) == number)
        if len(rows) and name != "BACKGROUND":
            panels[2].text(
                np.median(columns),
                np.median(rows),
                name,
                ha="center",
                va="center",
                size=14,
                weight="bold",
                bbox={"facecolor": BACK, "edgecolor": "none", "alpha": 0.7, "pad": 3},
            )
    for axis in panels:
        axis.set(xticks=[], yticks=[])
    save(made, "depth-labels")


def clocks(runs: Runs) -> None:
    """Ticks of sensors at four rates, each with the update that rendered its frame."""
    chassis = "/World/Robot/Chassis"
    options = (
        "--set",
        f"{chassis}/radar.omni:sensor:tickRate=13",
        "--set",
        f"{chassis}/camera.omni:sensor:tickRate=23",
    )
    made = figure(
        640,
        "Clocks: a sensor is due at k / rate; the first update that reaches it renders the frame",
        f"graph run {YARD} --set {chassis}/radar.omni:sensor:tickRate=13 ...",
    )
    axis = axes(made, 236, 84, 1334, 440)
    with open_run(runs.play("clocks", YARD, "--duration", "1", *options)) as run:
        rows = [
            (
                f"{name}, {rate} Hz",
                [(int(came * rate + 1e-6) / rate, came) for _, came, _ in messages(run, topic)],
                colour,
            )
            for name, rate, topic, colour in (
                ("camera", 23, "/camera/rgb", YELLOW),
                ("radar", 13, "/radar/points", RED),
                ("planar lidar", 20, "/front/points", "#ffffff"),
                ("lidar", 10, "/top/points", BLUE),
            )
        ]
    end = 0.505
    axis.vlines(np.arange(1, 121) / 240, -0.32, 0.32, color=SOFT, linewidth=1.6)
    updates = np.arange(1, 31) / 60
    axis.vlines(updates, 0.68, 1.32, color=INK, linewidth=2.6)
    for row, (_, times, colour) in enumerate(rows, 2):
        shown = [(due, came) for due, came in times if due < end]
        axis.vlines([due for due, _ in shown], row - 0.3, row + 0.3, color=colour, linewidth=4)
        for due, came in shown:
            axis.plot([due, came], [row - 0.3, 1.32], color=colour, linewidth=0.9, alpha=0.55)
            axis.plot(came, 1.32, marker="v", color=colour, markersize=6)
    axis.set(xlim=(0, end), ylim=(len(rows) + 1.5, -0.5), xlabel="simulation time [s]")
    axis.set_yticks(range(len(rows) + 2), ["physics, 240 Hz", "updates, 60 Hz", *(name for name, _, _ in rows)])
    axis.tick_params(length=0, axis="y")
    axis.grid(axis="x", linewidth=0.6)
    save(made, "clocks")


def trade(runs: Runs) -> None:
    """What `graph trade` draws."""
    out = runs.folder / "trade"
    if not (out / "trade.png").is_file():
        graph(
            *("trade", "graphs/lidar_motion_frozen.yaml", "--vary", "lidar.motion=frozen,update,continuous"),
            *("--vary", "physics.hz=120,240,480", "--budget", "lidar.range_p99=0.2", "--duration", "0.5"),
            *("--out", str(out)),
        )
    write(Image.open(out / "trade.png"), "trade")


def campaign(runs: Runs) -> None:
    """What `graph sweep --report` draws of 64 randomised yards."""
    out = runs.folder / "yards"
    if not (out / "campaign.png").is_file():
        graph(
            *("sweep", "graphs/random_yard.yaml", "--vary", "seed=0..63", "--updates", "30"),
            *("--metric", "returns=mean(topic('points').width)", "--report", "--out", str(out)),
        )
    write(Image.open(out / "campaign.png"), "campaign")
