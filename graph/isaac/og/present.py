"""The graphs that the Controller uses by default: those of the most recently entered App."""

from __future__ import annotations

import sys

from graph.base.errors import UserError
from graph.editing.graph_set import GraphSet
from graph.session.runner import graphs_of

_WITHOUT_APP = GraphSet()


def present_set() -> GraphSet:
    """The graphs of the most recently entered App; without an App, those of this process."""
    module = sys.modules.get("graph.sim.app")  # does not import the world if no App was made
    if module is not None:
        try:
            return graphs_of(module.App.current())
        except UserError:
            pass
    return _WITHOUT_APP
