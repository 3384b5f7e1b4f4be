"""Isaac Sim's and OmniGraph's names over the engine and the world; nothing of theirs stands on this package.

    with graph.isaac.importable():
        import omni.timeline

`og`: the Controller; `modules`, `omnigraph`: what scripts import, by the table `names.txt`; `script`: `graph exec`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.lazy_names import lazy_names

if TYPE_CHECKING:
    from .finder import importable as importable

__all__ = ["importable"]
__getattr__, __dir__ = lazy_names(__name__, {"importable": "finder"})
