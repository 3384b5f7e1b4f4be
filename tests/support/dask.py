"""A Dask cluster of this machine, whose scheduler and workers can be killed."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from contextlib import ExitStack

from tests.support.places import ROOT


class Dask:
    """A scheduler and workers, each a process, on the loopback interface."""

    def __init__(self, folder):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.folder, self.held, self.workers = folder, ExitStack(), []

    def started(self, *arguments):
        process = subprocess.Popen(
            [sys.executable, "-m", *arguments, "--host", "127.0.0.1", "--no-dashboard"],
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            cwd=self.folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.held.callback(process.wait)
        self.held.callback(process.kill)
        return process

    def start_scheduler(self):
        self.scheduler = self.started("distributed.cli.dask_scheduler", "--port", str(self.port), "--no-show")

    def start_worker(self):
        options = ("--nthreads", "1", "--no-nanny", "--local-directory", str(self.folder))
        self.workers.append(self.started("distributed.cli.dask_worker", self.address, *options))

    def restart_worker(self, worker):
        """Kills a worker; another takes its place."""
        self.workers.remove(worker)
        worker.kill()
        worker.wait()
        self.start_worker()

    def restart_scheduler(self):
        """Kills the scheduler, with which its workers end; others take their places."""
        for one in (self.scheduler, *self.workers):
            one.kill()
            one.wait()
        count, self.workers = len(self.workers), []
        self.start_scheduler()
        for _ in range(count):
            self.start_worker()

    def __enter__(self):
        self.start_scheduler()
        self.start_worker()
        self.start_worker()
        return self

    def __exit__(self, *error):
        self.held.close()
