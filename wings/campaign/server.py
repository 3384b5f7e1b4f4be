"""The process that forks a process for each run: `python -m wings.campaign.server`.

Libraries, compiled loops, parsed scenes and the structures that rays are cast at are loaded here once; each run starts
as a copy that shares them until it writes. The server has one thread, so that a fork copies no lock of another. It
speaks JSON lines over standard input and output, and ends with its runs when its input is closed.
"""

from __future__ import annotations

import gc
import json
import os
import select
import signal
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from graph.base.outputs import created
from graph.base.work import usable_cores

LOG = "log.txt"
UNFIT = 3
"""Exit code of a server that cannot fork after a rehearsal."""
LOOK_S = 0.1
"""How often the memory of runs is looked at [s]."""

_PR_SET_PDEATHSIG = 1


@dataclass(slots=True)
class _Run:
    number: int
    began: float
    ends: float
    memory: int
    largest: int = 0
    ended: str = ""


class Server:
    """Starts runs and reports how they ended."""

    def __init__(self, orders: int, answers: int) -> None:
        self._orders, self._answers = orders, answers
        self._runs: dict[int, _Run] = {}
        self._waiting = b""
        self._woken, wake = os.pipe()
        for end in (self._woken, wake):
            os.set_blocking(end, False)
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.set_wakeup_fd(wake, warn_on_full_buffer=False)

    def serve(self) -> None:
        """Runs until the orders end."""
        while True:
            ready, _, _ = select.select([self._orders, self._woken], [], [], self._patience())
            if self._woken in ready:
                with suppress(BlockingIOError):
                    os.read(self._woken, 4096)
            if self._orders in ready and not self._obey():
                break
            self._reap()
            self._watch()
        for process in self._runs:
            _kill(process)

    def tell(self, answer: Mapping[str, Any]) -> None:
        """Writes an answer."""
        line = json.dumps(answer).encode() + b"\n"
        while line:
            line = line[os.write(self._answers, line) :]

    def _patience(self) -> float | None:
        if any(run.memory for run in self._runs.values()):
            return LOOK_S
        ends = [run.ends for run in self._runs.values() if run.ends]
        return max(0.0, min(ends) - time.monotonic()) if ends else None

    def _obey(self) -> bool:
        """Reads orders; False at their end."""
        part = os.read(self._orders, 65536)
        self._waiting += part
        *lines, self._waiting = self._waiting.split(b"\n")
        for line in lines:
            order = json.loads(line)
            if "rehearse" in order:
                self.tell({"rehearsed": _rehearsed(order["rehearse"], play=order["play"])})
            elif "kill" in order:
                for process, run in self._runs.items():
                    if run.number == order["kill"]:
                        run.ended = "stopped"
                        _kill(process)
            else:
                self._start(order)
        return bool(part)

    def _start(self, order: Mapping[str, Any]) -> None:
        process = os.fork()
        if not process:
            try:
                signal.set_wakeup_fd(-1)
                for end in (self._orders, self._answers, self._woken):
                    os.close(end)
                code = _run(order)
            except BaseException as error:
                _say(f"graph: internal error: {type(error).__name__}: {error}")
                code = 1
            os._exit(code)
        now = time.monotonic()
        ends = now + order["timeout"] if order.get("timeout") else 0.0
        self._runs[process] = _Run(order["number"], now, ends, order.get("memory") or 0)

    def _reap(self) -> None:
        while self._runs:
            try:
                process, status, usage = os.wait4(-1, os.WNOHANG)
            except ChildProcessError:
                return
            if not process:
                return
            run = self._runs.pop(process, None)
            if run is None:
                continue
            code = os.waitstatus_to_exitcode(status)
            _kill(process)  # what it started itself
            largest = max(run.largest, usage.ru_maxrss * 1024)
            self.tell(
                {
                    "number": run.number,
                    "code": code,
                    "ended": run.ended,
                    "seconds": round(time.monotonic() - run.began, 3),
                    "processor": round(usage.ru_utime + usage.ru_stime, 3),
                    "memory": largest,
                }
            )

    def _watch(self) -> None:
        now = time.monotonic()
        for process, run in self._runs.items():
            if run.ends and now >= run.ends and not run.ended:
                run.ended = "timeout"
                _kill(process)
            elif run.memory and not run.ended:
                run.largest = max(run.largest, _resident(process))
                if run.largest > run.memory:
                    run.ended = "memory"
                    _kill(process)


def _kill(process: int) -> None:
    """Ends a run and what it started: its group, or the process alone before it has one."""
    with suppress(OSError):
        os.killpg(process, signal.SIGKILL)
    with suppress(OSError):
        os.kill(process, signal.SIGKILL)


def _resident(process: int) -> int:
    """Memory of a process [bytes]; 0 if the system does not say."""
    from graph.base.inputs import start_of

    try:
        return int(start_of(Path(f"/proc/{process}/statm"), 200).split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, IndexError, ValueError):
        return 0


def _run(order: Mapping[str, Any]) -> int:
    """A run, in its own process."""
    os.setpgid(0, 0)
    _die_with_parent()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGCHLD):
        signal.signal(number, signal.SIG_DFL)
    folder = Path(order["folder"])
    log = created(folder / LOG)
    for stream in (1, 2):
        os.dup2(log.fileno(), stream)
    from graph.cli.main import main

    code = main([*order["arguments"], "--out", str(folder)])
    if order.get("metrics") and code in (0, 1):
        from .measuring import measure

        measure(folder, order["metrics"])
    for text in (sys.stdout, sys.stderr):
        text.flush()
    return code


def _die_with_parent() -> None:
    """Lets a run end with the server, however that ends (on Linux)."""
    if sys.platform != "linux":
        return
    import ctypes

    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _rehearsed(arguments: list[str], *, play: bool) -> bool:
    """Opens the file of a run here and keeps it, for the runs to come, and with `play` its beginning; whether it could.

    On one core libraries start no threads, here and in runs that begin with it. A server that has a second thread must
    fork no more, and ends: the next one does not rehearse.
    """
    cores = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()
    try:
        if cores:
            os.sched_setaffinity(0, {min(cores)})
            if play:  # as many runs as cores: each keeps to one
                usable_cores()
        from .rehearsal import rehearse

        rehearse(arguments, play=play and bool(cores))
        good = True
    except BaseException:
        good = False
    if cores:
        os.sched_setaffinity(0, cores)
    if threads() > 1:
        os._exit(UNFIT)
    gc.collect()
    gc.freeze()
    return good


def threads() -> int:
    """Threads of this process, those of libraries included."""
    try:
        return len(os.listdir("/proc/self/task"))
    except OSError:
        import threading

        return threading.active_count()


def _say(line: str) -> None:
    with suppress(OSError):
        os.write(2, f"{line}\n".encode("utf-8", "backslashreplace"))


def serve() -> None:
    """Serves this process's standard streams."""
    orders, answers = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nothing, stream)
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    Server(orders, answers).serve()


if __name__ == "__main__":
    serve()
