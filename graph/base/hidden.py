"""Detects modules of the user that hide our packages: `graph`, `nodes`, `sensors` and `wings` are common names."""

from __future__ import annotations

import os.path
import sys

from .errors import UserError

OTHERS = ("nodes", "sensors", "wings")
"""The packages beside `graph`."""


class HiddenPackageError(UserError, ImportError):
    """A module of the user comes before one of our packages on Python's path."""


def refuse_hidden_packages() -> None:
    """Raises HiddenPackageError, with the file, where Python finds another package of these names before ours.

    Folders without `__init__.py` hide nothing. `graph` itself, when it is hidden, cannot say so.
    """
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    for entry in sys.path:
        folder = os.path.abspath(entry or ".")
        if folder == root:
            return
        for name in OTHERS:
            for file in (os.path.join(folder, f"{name}.py"), os.path.join(folder, name, "__init__.py")):
                if os.path.isfile(file):
                    raise HiddenPackageError(f'{file} hides the package "{name}" of TickGraph; rename it')
