"""`graph doctor --warm`: compiles the sensors' loops ahead, so that no run waits for it."""

from __future__ import annotations

import sys
import time

from .printing import counted, say, tell
from .progress import counting


def run() -> int:
    """Compiles what is missing, with a bar on a terminal; returns 0."""
    from sensors.compiled.kept import user_folder, why_not_kept
    from sensors.compiled.warming import warm

    reason = why_not_kept()
    if reason:
        say(f"compiled code cannot be kept: {reason}. Set TICKGRAPH_CACHE to a folder of your own")
        return 1
    start = time.monotonic()
    number = 0
    with counting("compiling", shown=sys.stderr.isatty()) as bar:
        for done, number in warm():
            if number and not done and not sys.stderr.isatty():
                tell(f"compiling {counted(number, 'loops')} of the sensors, once on this machine")
            bar.update(bar.task_ids[0], completed=done, total=number)
    if not number:
        say("the sensors' loops are compiled already")
    else:
        say(f"compiled {counted(number, 'loops')} in {time.monotonic() - start:.0f} s into {user_folder()}")
    return 0
