"""The work of a trade's processes: each job is plain data that is sent to a worker and run there."""

from __future__ import annotations

import functools
import pickle
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Protocol

from graph.sim.fidelity import Fidelity

from .errors import Errors, Horizon, errors_of, horizon_of
from .study import Scene, Setting
from .trial import Measured, Timed, clock, measure, present_values, without_arrays


class Job(Protocol):
    """A piece of work in another process."""

    def run(self, scene: Scene) -> Any:
        """The result. Raises UserError or RunError."""


@dataclass(frozen=True, slots=True)
class Present:
    """The knobs of the file."""

    def run(self, scene: Scene) -> Fidelity:
        """Opens the file and closes it again."""
        return present_values(scene)


@dataclass(frozen=True, slots=True)
class Keep:
    """Measures a setting and keeps everything in a file."""

    setting: Setting
    duration: Fraction
    file: Path

    def run(self, scene: Scene) -> Measured:
        """The measured run, without its arrays, which are in the file."""
        found = measure(scene, self.setting, self.duration)
        with self.file.open("wb") as stream:
            pickle.dump(found, stream, protocol=pickle.HIGHEST_PROTOCOL)
        return without_arrays(found)


@dataclass(frozen=True, slots=True)
class Judge:
    """Compares a reference with its refinement, and with itself. refined: None if it could not be refined."""

    reference: Path
    refined: Path | None

    def run(self, scene: Scene) -> tuple[Horizon, Errors, Errors]:
        """The horizon; by how much the refinement moves each metric; the errors of the reference itself."""
        reference = _kept(self.reference)
        finer = None if self.refined is None else _kept(self.refined)
        horizon = horizon_of(reference, finer)
        moved = errors_of(finer, reference, horizon) if finer is not None else {}
        return horizon, moved, errors_of(reference, reference, horizon)


@dataclass(frozen=True, slots=True)
class Match:
    """Compares a kept run with a kept reference."""

    run_file: Path
    reference: Path
    horizon: Horizon

    def run(self, scene: Scene) -> Errors:
        """The errors of the kept run."""
        return errors_of(_kept(self.run_file), _kept(self.reference), self.horizon)


@dataclass(frozen=True, slots=True)
class Compare:
    """Measures a setting against a kept reference."""

    setting: Setting
    duration: Fraction
    reference: Path
    horizon: Horizon

    def run(self, scene: Scene) -> tuple[Measured, Errors]:
        """The measured run without its arrays, and its errors."""
        found = measure(scene, self.setting, self.duration)
        return without_arrays(found), errors_of(found, _kept(self.reference), self.horizon)


@dataclass(frozen=True, slots=True)
class Clock:
    """Times a setting; see `trial.clock`."""

    setting: Setting
    duration: Fraction
    start: float
    recording: Path

    def run(self, scene: Scene) -> Timed:
        """What it cost."""
        return clock(scene, self.setting, self.duration, self.start, self.recording)


@functools.lru_cache(maxsize=2)
def _kept(file: Path) -> Measured:
    with file.open("rb") as stream:  # written by `Keep`, in a folder of this study's own
        found: Measured = pickle.load(stream)
    return found
