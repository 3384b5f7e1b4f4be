"""Runs on this machine: a server that forks a process for each, and what came of them."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

from graph.base.errors import RunError

SERVER = "wings.campaign.server"
LOST, AGAIN = "lost", "again"
"""How a run ended whose process was ended from outside; one that is to be started again, as nobody could say."""


@dataclass(frozen=True, slots=True)
class Order:
    """A run to start: its number, its command line, its folder, its limits [s, bytes; 0: none], its metrics."""

    number: int
    arguments: Sequence[str]
    folder: str
    timeout: float = 0.0
    memory: int = 0
    metrics: Any = None


@dataclass(frozen=True, slots=True)
class Ended:
    """How a run ended: its exit code, below 0 the signal; why it was ended, if it was; what it cost.

    ended: "timeout", "memory", "stopped", `LOST`, or "". seconds, processor: wall and processor time [s]. memory: the
    most that it held [bytes]. attempts: how often it was started.
    """

    number: int
    code: int
    ended: str = ""
    seconds: float = 0.0
    processor: float = 0.0
    memory: int = 0
    attempts: int = 1


class Launcher:
    """Runs orders in processes of their own, as many at a time as they come. Use with `with`.

    rehearse: command lines whose files the server opens first, for runs to find libraries and scenes loaded. play: it
    plays their beginning too, for runs to find compiled loops and the structures of static scenes; they then use one
    core each. place: the working folder of runs (default: this process's).
    """

    def __init__(self, rehearse: Sequence[Sequence[str]] = (), *, play: bool = False, place: str | None = None) -> None:
        self._rehearse = [[], *map(list, rehearse)]
        self._play, self._place = play, place
        self._server: subprocess.Popen[bytes] | None = None
        self._answers = b""
        self._ready = False
        """Whether the server has rehearsed, and so survived it."""
        self._orders: dict[int, dict[str, Any]] = {}
        self.running: dict[int, float] = {}
        """When each run was started, by number."""

    def __enter__(self) -> Launcher:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    @property
    def process(self) -> int:
        """The number of the server's process; 0 without one."""
        return self._server.pid if self._server is not None else 0

    def slots(self, jobs: int) -> int:
        """As many runs as the user asks for."""
        return jobs

    def start(self, order: Order) -> None:
        """Starts a run. Raises RunError if no server can be started."""
        self.running[order.number] = time.monotonic()
        self._orders[order.number] = {key: value for key, value in asdict(order).items() if value or key == "number"}
        self._order(self._orders[order.number])

    def stop(self, number: int) -> None:
        """Ends a run."""
        self._order({"kill": number})

    def wait(self, seconds: float) -> list[Ended]:
        """The runs that have ended since the last call; waits for the first at most `seconds`."""
        server = self._server
        if server is None or server.stdout is None:
            time.sleep(seconds)
            return []
        ready, _, _ = select.select([server.stdout], [], [], seconds)
        if not ready:
            return []
        part = os.read(server.stdout.fileno(), 65536)
        if not part:
            return self._lost()
        *lines, self._answers = (self._answers + part).split(b"\n")
        answers = [json.loads(line) for line in lines]
        self._ready |= any("rehearsed" in answer for answer in answers)
        found = [Ended(**answer) for answer in answers if "number" in answer]
        for one in found:
            self.running.pop(one.number, None)
            self._orders.pop(one.number, None)
        return found

    def close(self) -> None:
        """Ends the server, and with it every run."""
        server, self._server = self._server, None
        if server is None:
            return
        assert server.stdin is not None
        with suppress(OSError):
            server.stdin.close()
        try:
            server.wait(timeout=10)
        except subprocess.TimeoutExpired:
            server.kill()
            server.wait()
        if server.stdout is not None:
            server.stdout.close()
        self._answers = b""

    def _lost(self) -> list[Ended]:
        """The server is gone, and every run with it; the next one does not rehearse, which may have ended it.

        The runs that a server never started, because the rehearsal ended it, are started by the next.
        """
        rehearsing, self._rehearse = bool(self._rehearse) and not self._ready, []
        self.close()
        if rehearsing:
            orders, self._orders = [*self._orders.values()], {}
            for order in orders:
                self._order(order)
            return []
        now = time.monotonic()
        found = [Ended(number, -9, LOST, round(now - began, 3)) for number, began in self.running.items()]
        self.running.clear()
        self._orders.clear()
        return found

    def _order(self, order: dict[str, Any]) -> None:
        if self._server is None:
            self._server = self._started()
        assert self._server.stdin is not None
        with suppress(OSError):  # of a server that is gone, which `wait` finds
            self._server.stdin.write(json.dumps(order).encode() + b"\n")
            self._server.stdin.flush()

    def _started(self) -> subprocess.Popen[bytes]:
        if not hasattr(os, "fork"):
            raise RunError("campaigns need a system that can fork processes, such as Linux or macOS")
        path = os.pathsep.join(one or os.getcwd() for one in sys.path)
        server = subprocess.Popen(
            [sys.executable, "-m", SERVER],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd=self._place,
            start_new_session=True,  # Ctrl-C is for the campaign alone, which ends its runs
            env={**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": os.environ.get("OMP_NUM_THREADS", "1")},
        )
        assert server.stdin is not None
        for arguments in self._rehearse:
            server.stdin.write(json.dumps({"rehearse": arguments, "play": self._play}).encode() + b"\n")
        server.stdin.flush()
        return server
