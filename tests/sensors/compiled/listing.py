"""Which loops the examples use, for which argument types.

python -m tests.sensors.compiled.listing   writes them into `sensors/compiled/signatures.json`
"""

from __future__ import annotations

import contextlib
import gc
import io
import json
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

from graph.cli import main
from sensors.compiled.functions import Compiled
from sensors.compiled.signatures import LIST, text_of
from tests.support.places import ROOT
from tests.support.without_wing import MISSING_EXAMPLES

COMMAND = "python -m tests.sensors.compiled.listing"
EXAMPLES = sorted(
    path
    for path in (ROOT / "graphs").glob("*.yaml")
    if not path.name.endswith(".test.yaml") and path.stem not in MISSING_EXAMPLES
)
REST = Path(__file__).with_name("rest.yaml")
UPDATES = "18"
"""0.3 s: at least two frames of each sensor of the examples."""

CHOICES: dict[str, list[tuple[str, ...]]] = {
    "yard": [("lidar.motion=update",), ("lidar.motion=continuous",)],
    "quickstart": [("lidar.noise=on",), ("lidar.motion=continuous", "lidar.noise=on"), ("mesh.solids=mesh",)],
    "lidar_echoes": [("lidar.motion=continuous",), ("lidar.subrays=1",)],
    "rest": [("lidar.motion=continuous", "lidar.noise=on")],
    "camera": [("camera.samples=4",), ("camera.noise=on",)],
}
"""Further runs of an example, with other fidelity knobs."""


def used() -> dict[str, list[Any]]:
    """The argument types of each loop in runs of the examples, as they stand in the list."""
    for path in (*EXAMPLES, REST):
        for knobs in ((), *CHOICES.get(path.stem, [])):
            chosen = [word for knob in knobs for word in ("--fidelity", knob)]
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                status = main.main(["run", str(path), "--updates", UPDATES, "--json", *chosen])
            if status:
                raise RuntimeError(f"{path} ends with status {status}")
    found: dict[str, list[Any]] = defaultdict(list)
    for loop in gc.get_objects():
        if isinstance(loop, Compiled) and loop.name.startswith("sensors.") and "code" in vars(loop):
            found[loop.name] += [list(map(text_of, types)) for types in loop.code.signatures]
    return {name: sorted(forms, key=repr) for name, forms in sorted(found.items())}


def lines(forms: dict[str, list[Any]]) -> str:
    """The list's text: a line a form."""
    blocks = (
        f"{json.dumps(name)}: [\n" + ",\n".join(f"  {json.dumps(one)}" for one in forms[name]) + "\n]" for name in forms
    )
    return "{\n" + ",\n".join(blocks) + "\n}\n"


def write() -> int:
    """Writes the list."""
    forms = used()
    LIST.write_text(lines(forms))
    print(f"{sum(map(len, forms.values()))} forms of {len(forms)} loops in {LIST.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(write())
