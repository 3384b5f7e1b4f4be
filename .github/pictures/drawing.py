"""Runs of shipped graphs, what they recorded, and figures in one look: a dark card that light and dark pages carry."""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from PIL import Image

from graph.recording.contents.images import pixels
from graph.recording.contents.poses import TRANSFORMS, TransformLog, read_transforms
from graph.recording.contents.scans import Scan, scan_of
from graph.recording.run_reader import RunReader

ROOT = Path(__file__).resolve().parents[2]
IMAGES = ROOT / ".github" / "images"
WIDTH, DPI = 1600, 100
LARGEST = 290_000
"""Bytes of a picture."""
BACK, PANEL, INK, SOFT, LINE = "#10151c", "#171d26", "#e6ebf2", "#98a4b3", "#303a47"
BLUE, ORANGE, GREEN, RED, YELLOW, VIOLET = "#5aa9f5", "#f0a35e", "#6fcf8f", "#ff6b6b", "#ffd166", "#b794f6"
HEIGHTS = LinearSegmentedColormap.from_list("heights", plt.get_cmap("turbo")(np.linspace(0.08, 0.93, 256)))
SECOND = 1_000_000_000

plt.rcParams |= {
    "figure.facecolor": BACK,
    "axes.facecolor": PANEL,
    "savefig.facecolor": BACK,
    "text.color": INK,
    "axes.edgecolor": LINE,
    "axes.labelcolor": SOFT,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "xtick.labelcolor": SOFT,
    "ytick.labelcolor": SOFT,
    "grid.color": LINE,
    "font.size": 15,
    "axes.titlesize": 16,
    "axes.titlecolor": INK,
    "axes.titlelocation": "left",
    "axes.titlepad": 9,
    "legend.facecolor": PANEL,
    "legend.edgecolor": LINE,
    "font.family": "DejaVu Sans",
}


class Runs:
    """Runs of shipped graphs in a folder; one that is there is used again."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def play(self, name: str, *arguments: str) -> Path:
        """The folder of `graph run` with these arguments."""
        out = self.folder / name
        if not (out / "report.json").is_file():
            graph("run", *arguments, "--out", str(out))
        return out


def graph(*arguments: str) -> str:
    """What the command `graph` prints."""
    print("graph", *arguments, flush=True)
    command = [sys.executable, "-m", "graph", *arguments]
    return subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def transforms(run: RunReader) -> TransformLog:
    """The recorded transforms of a run."""
    return read_transforms(run.read([one.name for one in run.recorded.values() if one.type_name == TRANSFORMS]))


def scans(run: RunReader, topic: str, log: TransformLog, start: float = 0.0, end: float = 1e9) -> list[Scan]:
    """The scans of a topic with stamps from `start` to `end` [s]."""
    found = (scan_of(entry, number, log) for number, entry in enumerate(run.read([topic])))
    return [one for one in found if start <= one.stamp_ns / SECOND <= end]


def messages(run: RunReader, topic: str) -> list[tuple[float, float, Any]]:
    """(stamp, time of publishing, message) of a topic [s]."""
    entries = run.read([topic])
    return [((one.stamp_ns or one.time_ns) / SECOND, one.time_ns / SECOND, one.load()) for one in entries]


def image_at(run: RunReader, topic: str, time: float) -> np.ndarray:
    """The image of a topic whose stamp is nearest to a time [s]."""
    return pixels(min(messages(run, topic), key=lambda one: abs(one[0] - time))[2])


def figure(height: int, title: str, command: str) -> Any:
    """A figure of `WIDTH` x height pixels with a title above and the command that makes it below."""
    made = plt.figure(figsize=(WIDTH / DPI, height / DPI), dpi=DPI)
    made.text(24 / WIDTH, 1 - 22 / height, title, size=20, weight="bold", va="top")
    made.text(24 / WIDTH, 20 / height, "$ " + command, size=15, family="DejaVu Sans Mono", color=GREEN, va="bottom")
    return made


def axes(made: Any, left: float, top: float, width: float, height: float, title: str = "", **more: Any) -> Any:
    """Axes at pixels from the upper left corner."""
    across, down = made.get_size_inches() * DPI
    axis = made.add_axes((left / across, 1 - (top + height) / down, width / across, height / down), **more)
    axis.set_title(title)
    for side in axis.spines.values():
        side.set_color(LINE)
    return axis


def save(made: Any, name: str) -> None:
    """Writes a figure as a PNG; with a palette of 256 colours if it would be too large otherwise."""
    stream = io.BytesIO()
    made.savefig(stream, format="png", dpi=DPI)
    plt.close(made)
    write(Image.open(stream), name)


def write(image: Any, name: str) -> None:
    """Writes an image as the picture of this name."""
    path = IMAGES / f"{name}.png"
    IMAGES.mkdir(parents=True, exist_ok=True)
    image = image.convert("RGB")
    image.save(path, optimize=True)
    if path.stat().st_size > LARGEST:
        image.quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)
    print(f"wrote {path.relative_to(ROOT)} ({path.stat().st_size / 1000:.0f} kB)")


def badge(axis: Any, text: str) -> None:
    """A line of text in the upper left corner."""
    axis.text(
        0.015,
        0.97,
        text,
        transform=axis.transAxes,
        va="top",
        size=15,
        zorder=9,
        bbox={"facecolor": BACK, "edgecolor": "none", "alpha": 0.75, "pad": 5},
    )
