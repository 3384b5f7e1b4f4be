"""What scripts for Isaac Sim lose or must change, found in their syntax trees: a module for each subject of rules."""

from . import edits, names, prims, running
from .reading import FINDERS

__all__ = ["FINDERS", "edits", "names", "prims", "running"]
