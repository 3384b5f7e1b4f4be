"""`randomize:` of a graph file for many worlds: world i has what `graph run FILE --seed seed+i` draws."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import Problem, UserError
from graph.spec.file_spec import FileSpec

from .open import open_app
from .randomized import COPIES, randomized

if TYPE_CHECKING:
    from graph.sim.app import App


class WorldDraws:
    """What the seeds `seed`, `seed` + 1, ... draw for `count` worlds of a file.

    options: as for `App.from_file`. Raises UserError for a file with problems and for numbers of copies that differ.
    """

    def __init__(self, file: str | Path | FileSpec, count: int, seed: int, options: Mapping[str, Any]) -> None:
        from graph.files import load

        self._options, self.seed = dict(options), seed
        spec = file if isinstance(file, FileSpec) else load(file, allow=self._options.get("allow", ()))
        self._spec = spec
        fixed = self._options.get("overrides") or {}
        seeds = range(seed, seed + count) if spec.randomize else ()
        self.values: tuple[Mapping[str, Any], ...] = tuple(randomized(spec, each, fixed)[1] for each in seeds)
        """The drawn values of each world by their targets; none if the file draws nothing."""
        self.targets: dict[str, int] = {}
        """Targets whose values differ, and the first world whose value differs from world 0's."""
        for name, value in (self.values[0] if self.values else {}).items():
            world = next((n for n, each in enumerate(self.values) if each.get(name) != value), None)
            if world is None:
                continue
            if name.endswith(f".{COPIES}"):
                self.refuse(name, "worlds share their bodies and shapes, so that all have the same number of copies")
            self.targets[name] = world

    @contextmanager
    def playing(self, world: int, only: str | None = None) -> Iterator[App]:
        """The App of a world, which plays; only: that of world 0 with the value that `world` has for this target.

        Its warnings are not logged again: they are those of world 0.
        """
        from graph.sim.app import App

        options, seed = dict(self._options), self.seed + world
        if only is not None:
            options["overrides"] = {**(options.get("overrides") or {}), only: self.values[world][only]}
            seed = self.seed
        log = logging.getLogger("tickgraph.warnings")
        disabled, log.disabled = log.disabled, True
        try:
            with open_app(App, self._spec, seed=seed, **options) as app:
                app.play()
                yield app
        finally:
            log.disabled = disabled

    def refuse(self, name: str, why: str) -> None:
        """Raises UserError that this target cannot differ between worlds."""
        prim, _, key = name.rpartition(".")
        marks = (self._spec.marks.get(("randomize", each)) for each in (name, f"{prim.rpartition('_')[0]}.{key}"))
        raise UserError([Problem(f"randomize: {name}: {why}", next(filter(None, marks), None))])
