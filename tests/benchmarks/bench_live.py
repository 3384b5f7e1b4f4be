"""What a live listener in another process adds to the yard, whose clouds of 50,000 points it receives at 10 Hz."""

from __future__ import annotations

import importlib.util
import os
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from measure import Median, Row, seconds

from graph.recording.transports.targets import connect, read_targets
from graph.sim import App
from graph.sim.messages.bus import CountingSink
from tests.support.live_rig import free_port, listening, ros_domain

TITLE = "Live"
LIBRARIES = {"foxglove": "foxglove", "dds": "cyclonedds", "zenoh": "zenoh"}
NEEDS = tuple(LIBRARIES.values())
DOMAIN = 93
YARD = Path(__file__).parents[2] / "graphs" / "yard.yaml"
POINTS = {"top_cloud.topicName": "/points"}
"""The topic of the listeners."""
SETTLE_S = 0.1


def measure(quick: bool) -> Iterator[Row]:
    """Updates with a live sink over the same updates without, for each transport that is installed."""
    for name, library in LIBRARIES.items():
        if importlib.util.find_spec(library) is not None:
            yield Row(f"the yard with a listener over {name} / without", with_listener(name, quick), 1.1)


def with_listener(name: str, quick: bool) -> Median:
    """How much longer 6 updates, in which one cloud is made, take with a listener."""
    domain, port = DOMAIN if name == "dds" else 0, free_port()
    environment: dict[str, Any] = ros_domain(domain)
    os.environ["ROS_DOMAIN_ID"] = str(domain)
    with ExitStack() as stack:
        stack.enter_context(listening(name, 10**9, *([] if name == "dds" else [port]), environment=environment))
        alone, live = (stack.enter_context(App.from_file(YARD, overrides=POINTS)) for _ in range(2))
        [target] = read_targets([name if name == "dds" else f"{name}:{port}"])
        connect(live, target)
        for app in (alone, live):
            app.bus.subscribe(CountingSink())
            app.play()
        ratios = []
        for _ in range(4 if quick else 30):
            # What is still being sent and read must not slow the side that has no listener.
            time.sleep(SETTLE_S)
            under = seconds(lambda: alone.update(6))
            over = seconds(lambda: live.update(6))
            ratios.append(over / under)
        return Median(ratios[3:])
