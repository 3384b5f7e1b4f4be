"""The two kinds of error, and who must act: the user, who mends the input, or nobody, because the run itself failed."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from .shorten import brief


@dataclass(frozen=True, order=True, slots=True)
class Mark:
    """A place in a file.

    Line and column count from 1; both are 0 where the file has no lines (a prim of a binary file).
    """

    file: str
    line: int
    column: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}" if self.line else self.file


@dataclass(frozen=True, slots=True)
class Problem:
    """One mistake: where it is (if the place is known), what is wrong, and what to do."""

    message: str
    mark: Mark | None = None
    whole: bool = False
    """Whether a long message is shown in full, because the user is to copy it."""

    def __post_init__(self) -> None:
        if not self.whole:
            object.__setattr__(self, "message", brief(self.message))

    def __str__(self) -> str:
        return f"{self.mark}: {self.message}" if self.mark else self.message


watcher: Callable[[UserError], object] | None = None
"""Called with every UserError that is made, while a script runs that may catch it."""


class UserError(Exception):
    """The user's input is wrong; carries every problem found, one line each. The command exits with status 2."""

    def __init__(self, problems: str | Problem | Iterable[Problem]) -> None:
        if isinstance(problems, str):
            problems = (Problem(problems),)
        elif isinstance(problems, Problem):
            problems = (problems,)
        self.problems: tuple[Problem, ...] = tuple(dict.fromkeys(problems))
        super().__init__("\n".join(map(str, self.problems)))
        if watcher is not None:
            watcher(self)


class RunError(Exception):
    """The run failed: a node raised, the physics diverged. The command exits with status 1 and keeps the recording."""

    def __init__(self, message: str = "") -> None:
        super().__init__(brief(message))


def reason_of(error: BaseException) -> str:
    """A library's exception as one line of at most 120 characters; the name of its type if it has no text."""
    return " ".join(str(error).split())[:120] or type(error).__name__
