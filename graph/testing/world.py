"""An App under test: what it published and rendered, by update."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.node.registry import Registry
from graph.spec.file_spec import FileSpec

if TYPE_CHECKING:
    from graph.recording.sources import Source
    from graph.sim.app import App
    from graph.sim.messages.message import Message


@dataclass(slots=True)
class Observed:
    """An App and its outputs; `update` is the index of the present update. It is a sink of the App's bus."""

    app: App
    update: int = 0
    messages: dict[str, list[tuple[int, Any]]] = field(default_factory=dict)
    frames: dict[str, list[int]] = field(default_factory=dict)

    def advertise(self, topic: str, type_name: str) -> None:
        """A publisher of `topic` exists."""
        self.messages.setdefault(topic, [])

    def write(self, message: Message) -> None:
        """Takes one message."""
        self.messages.setdefault(message.topic, []).append((self.update, message.message))

    def close(self) -> None:
        """Does nothing."""

    def receive(self, sources: Iterable[str | Path | Source]) -> None:
        """Sends the messages of files and sources to the App's subscribers from its next play on."""
        from graph.session.message_sources import open_sources, play_into

        opened = [one for each in sources for one in (open_sources([each]) if isinstance(each, str | Path) else [each])]
        if opened:
            play_into(self.app, opened)

    def play(self, playing: bool) -> None:
        """Plays or pauses the timeline, if needed."""
        if playing != self.app.timeline.is_playing():
            (self.app.play if playing else self.app.pause)()

    def note_frames(self) -> None:
        """Records whose frame came in this update; products without a frame have an empty list."""
        rendering = self.app.rendering
        for product in rendering.products.values():
            self.frames.setdefault(product.camera_path, [])
        for product in rendering.new_frames:
            self.frames[product.camera_path].append(self.update)


def observe(
    spec: FileSpec,
    allow: Sequence[Path],
    seed: int,
    registry: Registry,
    cleanup: ExitStack,
    *,
    allow_scripts: bool = False,
) -> Observed:
    """Opens the App of a file and observes it; `cleanup` closes it. Raises UserError with every problem."""
    from graph.isaac.managers.app import App
    from graph.session.open import open_app

    app = open_app(App, spec, allow=allow, seed=seed, registry=registry, allow_scripts=allow_scripts)
    cleanup.enter_context(app)
    observed = Observed(app)
    app.bus.subscribe(observed)
    app.on("end", observed.note_frames)
    return observed
