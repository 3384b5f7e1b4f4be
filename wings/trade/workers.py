"""Processes that run the jobs of a trade.

Runs have a process of their own, so that one that crashes or runs out of memory is a result and not the end. A process
runs many jobs, one after the other: libraries are loaded once, and every timed run finds the same warm process.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from types import TracebackType
from typing import Any

from graph.base.errors import Problem, RunError, UserError, reason_of
from graph.base.signals import ENDING

from .jobs import Job
from .study import Scene

MOST_WORKERS = 4
"""Most runs at a time; each holds a scene of its own."""

LOOK_S = 0.1
"""How often a waiting parent looks whether it is to end [s]."""


@dataclass(frozen=True, slots=True)
class Crashed:
    """The result of a job that failed, that was refused, or whose process ended.

    problems: of one that was refused. ended: whether the process is gone.
    """

    why: str
    ended: bool = True
    problems: tuple[Problem, ...] = ()


class Pool:
    """As many processes as there are cores, at most `MOST_WORKERS`. With `with`: they are ended at the end, whatever
    they do.

    interrupted: asked while waiting; True raises KeyboardInterrupt.
    """

    def __init__(self, scene: Scene, interrupted: Callable[[], bool] = lambda: False) -> None:
        self._scene, self._interrupted = scene, interrupted
        self._workers: list[_Worker] = []

    def __enter__(self) -> Pool:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for worker in self._workers:
            worker.end()

    def one(self, job: Job) -> Any:
        """The result of a short job, which nothing interrupts.

        Raises UserError if it was refused, RunError if it failed.
        """
        [(_, found)] = self._results([job], 1, lambda: False)
        if isinstance(found, Crashed):
            raise UserError(found.problems) if found.problems else RunError(found.why)
        return found

    def results(self, jobs: Sequence[Job], *, at_once: bool = False) -> Iterator[tuple[int, Any]]:
        """The number and the result of each job, as they are done: one after the other, or several at once.

        One that fails, is refused (it raises UserError), or whose process ends, gives `Crashed`.
        """
        most = min(MOST_WORKERS, os.cpu_count() or 1) if at_once else 1
        yield from self._results(jobs, most, self._interrupted)

    def _results(self, jobs: Sequence[Job], most: int, interrupted: Callable[[], bool]) -> Iterator[tuple[int, Any]]:
        left = list(enumerate(jobs))[::-1]
        busy: dict[Connection, tuple[int, _Worker]] = {}
        while left or busy:
            while left and len(busy) < most:
                worker = self._idle([worker for _, worker in busy.values()])
                number, job = left.pop()
                worker.pipe.send(job)
                busy[worker.pipe] = number, worker
            for pipe in wait(list(busy), timeout=LOOK_S):
                assert isinstance(pipe, Connection)
                number, worker = busy.pop(pipe)
                found = worker.answer()
                if isinstance(found, Crashed) and found.ended:
                    self._workers.remove(worker)
                yield number, found
            if interrupted():
                for _, worker in busy.values():  # their answers would be taken for those of later jobs
                    worker.end()
                    self._workers.remove(worker)
                raise KeyboardInterrupt

    def _idle(self, busy: list[_Worker]) -> _Worker:
        for worker in self._workers:
            if worker not in busy:
                return worker
        self._workers.append(_Worker(self._scene))
        return self._workers[-1]


class _Worker:
    def __init__(self, scene: Scene) -> None:
        context = multiprocessing.get_context("spawn")  # a fork would copy threads of libraries
        self.pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, scene), daemon=True)
        self._process.start()
        theirs.close()

    def answer(self) -> Any:
        """The result of the job that was sent."""
        try:
            kind, found = self.pipe.recv()
        except (EOFError, OSError):
            self._process.join()
            return Crashed(_ending(self._process.exitcode))
        if kind == "wrong":
            return Crashed("; ".join(map(str, found)), ended=False, problems=tuple(found))
        return Crashed(found, ended=False) if kind == "failed" else found

    def end(self) -> None:
        """Ends the process."""
        self.pipe.close()
        self._process.terminate()
        self._process.join()


def _ending(code: int | None) -> str:
    if code is not None and code < 0:
        return f"the process of the run was ended by {signal.Signals(-code).name}"
    return f"the process of the run ended with code {code}"


def _serve(pipe: Connection, scene: Scene) -> None:
    """Runs the jobs that come through the pipe until it is closed."""
    for number in ENDING:
        signal.signal(number, signal.SIG_IGN if number == signal.SIGINT else signal.SIG_DFL)
    nothing = os.open(os.devnull, os.O_WRONLY)  # what nodes print, many times over, is not for the terminal
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
        os.dup2(nothing, stream.fileno())
    failure: list[Problem] = []
    try:
        scene.prepare()
    except UserError as error:
        failure += error.problems
    while True:
        try:
            job: Job = pipe.recv()
        except EOFError:
            return
        try:
            pipe.send(("wrong", failure) if failure else ("done", job.run(scene)))
        except UserError as error:
            pipe.send(("wrong", list(error.problems)))
        except RunError as error:
            pipe.send(("failed", str(error)))
        except Exception as error:  # a defect of ours at one setting is a row of the table, and told there
            pipe.send(("failed", f"internal error: {type(error).__name__}: {reason_of(error)}"))
