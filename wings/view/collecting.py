"""Reads a recording and keeps what the page shows of it, within a budget of bytes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from graph.recording.contents.clouds import CLOUD, TYPES
from graph.recording.contents.images import IMAGE
from graph.recording.contents.poses import TRANSFORMS, TransformLog, read_transforms
from graph.recording.contents.scans import scan_of
from graph.recording.sources import WALL_CLOCK_NS

from .clouds import CloudPanel, chosen
from .frames import DETECTIONS, LENS, boxes, frames, lens
from .pictures import image_of, range_image, small, source
from .times import Times
from .values import MOST_POINTS, Series

if TYPE_CHECKING:
    from graph.recording.run_reader import RunReader
    from graph.recording.sources import Entry

FRAMES_A_MEGABYTE = 1.5
"""Clouds or pictures of a topic in the page, at most, for each megabyte of the budget."""
CLOUD_SHARE, IMAGE_SHARE = 0.65, 0.3
"""Of the budget; the rest is for values and times."""
POINT_BYTES = 12
"""Of a point in the page: three places of two bytes and about three colours, as base64."""
RECORDED_POINT = 16
"""Bytes of a point in a message, about."""
FEWEST_POINTS, MOST_POINTS_A_CLOUD = 3_000, 60_000
PICTURE_BYTES = 40_000
"""Of a picture in the page, about."""
NOT_DRAWN = (
    "rosgraph_msgs/msg/Clock",
    "sensor_msgs/msg/CompressedImage",
    "nav_msgs/msg/OccupancyGrid",
    TRANSFORMS,
)
"""Types whose numbers are not drawn over time."""


@dataclass(slots=True)
class Picture:
    """One picture of a topic: its time, the image, its format, and the values [m] of the first and the last colour."""

    topic: str
    stamp_ns: int
    image: Any
    form: str
    bar: tuple[float, float] | None = None


@dataclass(slots=True)
class Collected:
    """What a page shows: by topic clouds, range images, pictures, values, times, boxes, lenses; poses; problems."""

    clouds: dict[str, CloudPanel] = field(default_factory=dict)
    ranges: dict[str, list[Picture]] = field(default_factory=dict)
    pictures: dict[str, list[Picture]] = field(default_factory=dict)
    values: dict[str, Series] = field(default_factory=dict)
    times: dict[str, Times] = field(default_factory=dict)
    boxes: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    lenses: dict[str, dict[str, Any]] = field(default_factory=dict)
    poses: list[dict[str, Any]] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)


def collect(run: RunReader, sizes: Mapping[str, float], budget: int) -> Collected:
    """What the page shows of these topics within `budget` bytes, from two passes: transforms, then everything.

    sizes: the mean size [bytes] of each topic's messages. A message that contradicts itself is left out, with a line
    in `problems`.
    """
    found = Collected()
    moving = [topic.name for topic in run.recorded.values() if topic.type_name == TRANSFORMS]
    log = read_transforms(run.read(moving)) if moving else TransformLog()
    types = {name: run.recorded[name].type_name for name in sizes}
    picks = _picks(run, types, budget)
    found.counts = {name: run.recorded[name].messages for name in sizes}
    scanned = {name: sizes[name] / RECORDED_POINT for name, one in types.items() if one in TYPES}
    points = points_a_cloud(scanned, {name: len(picks[name]) for name in scanned}, CLOUD_SHARE * budget)
    seen: Counter[str] = Counter()
    for entry in run.read(list(sizes)):
        stamp = _stamp(entry)
        name, number = entry.topic, seen[entry.topic]
        seen[name] += 1
        found.times.setdefault(name, Times(name, run.recorded[name].metadata)).add(stamp, entry.time_ns)
        if number not in picks[name]:
            continue
        try:
            _take(entry, stamp, number, log, points, found)
        except ValueError as error:
            found.problems.append(f"{name} at {stamp / 1e9:.9f} s is not shown: {error}")
    found.poses = list(frames(log))
    return found


def _picks(run: RunReader, types: dict[str, str], budget: int) -> dict[str, frozenset[int]]:
    """The numbers of the messages of each topic that the page shows."""
    shown = max(10, round(FRAMES_A_MEGABYTE * budget / 1e6))
    images = [name for name, one in types.items() if one == IMAGE]
    pictures = int(IMAGE_SHARE * budget / PICTURE_BYTES / max(1, len(images)))
    most = {IMAGE: max(1, min(shown, pictures)), LENS: 1, **dict.fromkeys((*TYPES, DETECTIONS), shown)}
    return {
        name: frozenset(() if one in NOT_DRAWN else chosen(run.recorded[name].messages, most.get(one, MOST_POINTS)))
        for name, one in types.items()
    }


def points_a_cloud(sizes: Mapping[str, float], frames: Mapping[str, int], budget: float) -> int:
    """The most points of a cloud with which all clouds fit into `budget` bytes.

    sizes: points of a cloud by topic, about; frames: clouds of each topic in the page.
    """
    low, high = FEWEST_POINTS, MOST_POINTS_A_CLOUD
    while high - low > 1:
        middle = (low + high) // 2
        needed = sum(POINT_BYTES * min(sizes[name], middle) * frames[name] for name in sizes)
        low, high = (middle, high) if needed <= budget else (low, middle)
    return low


def _take(entry: Entry, stamp: int, number: int, log: TransformLog, points: int, found: Collected) -> None:
    name = entry.topic
    if entry.type_name in TYPES:
        scan = scan_of(entry, number, log)
        root = log.chain(scan.frame_id)[-1]
        found.clouds.setdefault(name, CloudPanel(name)).add(scan, root, points)
        if entry.type_name == CLOUD and (image := range_image(scan)) is not None:
            found.ranges.setdefault(name, []).append(Picture(name, stamp, image[0], "PNG", (0.0, image[1])))
    elif entry.type_name == IMAGE:
        image, form, bar = image_of(entry.load())
        found.pictures.setdefault(name, []).append(Picture(name, stamp, small(image), form, bar))
    elif entry.type_name == DETECTIONS:
        found.boxes.setdefault(name, []).append(boxes(entry.load(), stamp, log))
    elif entry.type_name == LENS:
        if (seen := lens(entry.load())) is not None:
            found.lenses[seen["frame"]] = seen
    else:
        found.values.setdefault(name, Series(name)).add(stamp, entry.type_name, entry.load())


def _stamp(entry: Entry) -> int:
    """The stamp of a message [ns]; the time of its publishing if it is without a stamp, or has that of a wall clock."""
    if entry.stamp_ns is None or entry.stamp_ns >= WALL_CLOCK_NS > entry.time_ns:
        return entry.time_ns
    return entry.stamp_ns


def source_of(picture: Picture) -> dict[str, Any]:
    """A picture as the page's script takes it."""
    bar = {} if picture.bar is None else {"low": picture.bar[0], "high": picture.bar[1]}
    return {"t": picture.stamp_ns / 1e9, "src": source(picture.image, picture.form), **bar}
