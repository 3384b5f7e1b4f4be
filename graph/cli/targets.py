"""Other products, for whose faults `graph check --target` looks; packages bring them as `tickgraph.targets`."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol

from graph.base.plugins import TARGETS, required
from graph.base.records import dataclass

if TYPE_CHECKING:
    from graph.spec.file_spec import Note


class Finding(Protocol):
    """What works here and fails or differs in a target."""

    def note(self) -> Note:
        """Code, place and message of the warning."""

    def as_dict(self) -> dict[str, Any]:
        """What the JSON report holds beside them."""


@dataclass(frozen=True, slots=True)
class Target:
    """A product that runs the same files or scripts, declared under its name in `--target NAME`.

    module: the one that looks for its faults, imported when a check needs it. It has these functions:
    `of_file(target, spec, graphs, stage, settings) -> list[Finding]`, `of_script(target, file) -> list[Finding]`,
    `without_twins(notes, findings) -> Iterable[Note]`: the notes that no finding repeats, and
    `fix_file(file, spec, findings, target) -> list[str]`: applies the safe fixes, returns a line for each.
    """

    module: str


def checks_of(target: str) -> Any:
    """The module that looks for a target's faults. Raises UserError for a target that is unknown or missing here."""
    return import_module(required(TARGETS, target, Target, "target").module)
