"""Conducts a campaign: starts runs while there is room, keeps their results, repeats what was lost or is to be retried.

A run that fails, hangs, crashes or is killed is a row of the table. Its folder appears whole when it has ended; until
then the run is not done, whatever happens to this process, the machine or the disk.
"""

from __future__ import annotations

import errno
import os
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from graph.base.errors import RunError
from graph.base.inputs import start_of

from .folder import Folder, Result
from .launcher import AGAIN, LOST, Ended, Order
from .points import arguments_of
from .server import LOG
from .specification import Campaign

OK, FAILED, REFUSED, TIMEOUT, MEMORY, KILLED, CRASHED = (
    *("ok", "failed", "refused", "timeout", "memory", "killed", "crashed"),
)
"""The states of a finished run: `crashed` by a signal of its own, `killed` from outside twice."""

LOOK_S = 0.1
"""How often it is looked whether the campaign is to end [s]."""
LOST_REPEATS = 1
"""How often a run is repeated whose process was ended from outside."""
FULL = os.strerror(errno.ENOSPC)
LEAST_SPACE = 2**20
"""Free bytes below which a disk is full."""
LONGEST_WHY = 300


class Executor(Protocol):
    """Runs orders: in processes of this machine, or on a cluster."""

    def start(self, order: Order) -> None:
        """Starts a run, or queues it."""

    def slots(self, jobs: int) -> int:
        """How many runs are started before one has ended; jobs: what the user asks for."""

    def stop(self, number: int) -> None:
        """Ends a run."""

    def wait(self, seconds: float) -> list[Ended]:
        """The runs that have ended since the last call; waits for the first at most `seconds`."""


@dataclass(slots=True)
class Limits:
    """How many runs at a time; of each its time [s] and memory [bytes] (0: none).

    retries: how often a run that failed is started again. failures: after so many failed runs no further one is
    started; 0: however many fail.
    """

    jobs: int = 1
    timeout: float = 0.0
    memory: int = 0
    retries: int = 0
    failures: int = 0


@dataclass(slots=True)
class State:
    """The progress of a campaign."""

    total: int
    done: int = 0
    failed: int = 0
    running: int = 0
    kept: int = 0
    """Runs that an earlier start of the campaign had finished."""
    why_stopped: str = ""
    last: Result = field(default_factory=dict)


Tell = Callable[[State], None]


def conduct(
    campaign: Campaign,
    folder: Folder,
    executor: Executor,
    limits: Limits,
    *,
    only: Sequence[int] | None = None,
    interrupted: Callable[[], bool] = lambda: False,
    tell: Tell = lambda state: None,
) -> State:
    """Runs what is missing, and returns how far it came.

    only: the numbers of the runs to consider (default: all). tell: called as the campaign begins, and after each run;
    `last` is that run. interrupted: asked while waiting; then running runs are ended, and are missing.
    """
    numbers = range(len(campaign.points)) if only is None else only
    state = State(len(numbers))
    earlier = {number: folder.result(campaign.name_of(number)) for number in numbers}
    tried = {number: result["attempts"] if result else 0 for number, result in earlier.items()}
    queue = deque(number for number in numbers if is_due(earlier[number], limits))
    state.kept = state.done = len(numbers) - len(queue)
    state.failed = sum(result is not None and result["status"] != OK for result in earlier.values()) - sum(
        earlier[number] is not None for number in queue
    )
    lost = dict.fromkeys(numbers, 0)
    parts: dict[int, Path] = {}
    tell(state)
    try:
        while queue or parts:
            if interrupted():
                raise KeyboardInterrupt
            if limits.failures and state.failed >= limits.failures and queue:
                state.why_stopped = f"{state.failed:,} runs have failed (--max-failures {limits.failures})"
                queue.clear()
            while queue and len(parts) < executor.slots(limits.jobs):
                number = queue.popleft()
                parts[number] = folder.begin(campaign.name_of(number))
                tried[number] += 1
                executor.start(_order(campaign, number, parts[number], limits))
            state.running = len(parts)
            for ended in executor.wait(LOOK_S) if parts else ():
                number, part = ended.number, parts.pop(ended.number)
                if ended.ended == AGAIN:
                    folder.drop(part)
                    queue.appendleft(number)
                    continue
                tried[number] += ended.attempts - 1
                if ended.ended == LOST or (ended.code in (-9, -15, -1) and not ended.ended):
                    lost[number] += 1
                    if lost[number] <= LOST_REPEATS:
                        folder.drop(part)
                        queue.appendleft(number)
                        continue
                result = result_of(ended, part, tried[number])
                if result["status"] == FAILED and (FULL in result["why"] or _is_full(folder.root)):
                    folder.drop(part)
                    raise OSError(errno.ENOSPC, FULL, str(folder.root))
                if result["status"] not in (OK, REFUSED) and tried[number] <= limits.retries + min(
                    lost[number], LOST_REPEATS
                ):
                    folder.drop(part)
                    queue.append(number)
                    continue
                folder.commit(part, campaign.name_of(number), result)
                state.done += 1
                state.failed += result["status"] != OK
                state.last = result
                state.running = len(parts)
                tell(state)
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise RunError(f"{error.filename or folder.root}: {error.strerror}") from error
        state.why_stopped = f"{folder.root}: {FULL}; make space and go on with --resume"
    finally:
        for number in parts:
            with suppress(OSError):
                executor.stop(number)
        _end(executor, parts, folder)
    return state


def _end(executor: Executor, parts: dict[int, Path], folder: Folder) -> None:
    """Waits until the stopped runs have ended, and removes their folders."""
    for _ in range(50):
        if not parts:
            return
        for ended in executor.wait(LOOK_S):
            folder.drop(parts.pop(ended.number, Path()) if ended.number in parts else folder.root / "-")
    for part in parts.values():
        folder.drop(part)


def is_due(result: Result | None, limits: Limits) -> bool:
    """Whether a run is still to be made: it has not finished, or failed and has a retry left."""
    if result is None:
        return True
    return result["status"] not in (OK, REFUSED) and result["attempts"] <= limits.retries


def _order(campaign: Campaign, number: int, part: Path, limits: Limits) -> Order:
    arguments = arguments_of(campaign.points[number], campaign.common)
    return Order(number, arguments, str(part), limits.timeout, limits.memory, dict(campaign.metrics))


def result_of(ended: Ended, part: Path, attempts: int) -> Result:
    """The result of a run that ended."""
    status, exit_code = OK, max(ended.code, 0) if ended.code >= 0 else 128 - ended.code
    if ended.ended in (TIMEOUT, MEMORY):
        status = ended.ended
    elif ended.code in (-9, -15, -1) or ended.ended == LOST:
        status = KILLED
    elif ended.code < 0:
        status = CRASHED
    elif ended.code:
        status = REFUSED if ended.code == 2 else FAILED
    return {
        "number": ended.number,
        "status": status,
        "exit": exit_code,
        "attempts": attempts,
        "why": "" if status == OK else _why(ended, part),
        "seconds": ended.seconds,
        "processor": ended.processor,
        "memory": ended.memory,
    }


def _why(ended: Ended, part: Path) -> str:
    """The line of a failed run's log that says what went wrong; of one that was ended, by what."""
    if ended.code < 0 or ended.ended:
        import signal

        if ended.ended in (TIMEOUT, MEMORY):
            return {TIMEOUT: "it took longer than --timeout", MEMORY: "it held more memory than --memory"}[ended.ended]
        return f"its process was ended by {signal.Signals(-ended.code).name}"
    with suppress(OSError):
        lines = start_of(part / LOG, 2**20).decode("utf-8", "replace").split("\n")
        lines = [line.strip() for line in lines]
        said = [line for line in lines if line and not line.startswith(("warning ", "next: ", "wrote "))]
        told = [line for line in said if line.startswith("graph: ")] or said
        if told:
            text = told[-1] if ended.code != 2 else told[0]
            return text.removeprefix("graph: ").replace(str(part), "OUT")[:LONGEST_WHY]
    return "its log is empty"


def _is_full(folder: Path) -> bool:
    """Whether no more can be written below a folder."""
    try:
        found = os.statvfs(folder)
    except (OSError, AttributeError):
        return False
    return found.f_bavail * found.f_frsize < LEAST_SPACE
