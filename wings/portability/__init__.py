"""What works here and fails, or differs silently, in another product: `graph check --target`.

`rules` declares every rule; `wiring`, `sensors`, `clocks` and `script_rules` find what breaks them; `fixing` applies
the safe fixes to a graph file.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.lazy_names import lazy_names as _lazy_names

if TYPE_CHECKING:
    from .fixing import fix_file
    from .report import of_file, of_script, without_twins

_HOMES = {"fix_file": "fixing", "of_file": "report", "of_script": "report", "without_twins": "report"}

__all__ = ["fix_file", "of_file", "of_script", "without_twins"]

__getattr__, __dir__ = _lazy_names(__name__, _HOMES)
