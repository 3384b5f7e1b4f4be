"""What a further App of a file adds to a process."""

from __future__ import annotations

import subprocess
import sys

from tests.support.places import ROOT

PROGRAM = """
import gc, os, sys
from graph.sim import App
from graph.base.inputs import start_of
from graph.sim.messages.bus import CountingSink
kept, sizes = [], []
for _ in range(4):
    kept.append(App.from_file(sys.argv[1]))
    kept[-1].bus.subscribe(CountingSink())
    kept[-1].play()
    kept[-1].update(steps=7)
    gc.collect()
    sizes.append(int(start_of("/proc/self/statm", 200).split()[1]) * os.sysconf("SC_PAGE_SIZE"))
print((sizes[3] - sizes[1]) / 2e6)
"""


def further_app_mb(file: str) -> float:
    """Resident memory [MB] of a third and a fourth App that play a file, each; on Linux."""
    command = [sys.executable, "-c", PROGRAM, file]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return float(done.stdout)
