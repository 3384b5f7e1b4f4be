"""Paths of the former flat layout."""

from importlib import import_module

import pytest

from graph.moved import MOVED as MOVED_IN_GRAPH
from sensors.moved import MOVED as MOVED_IN_SENSORS

MOVED = MOVED_IN_GRAPH | MOVED_IN_SENSORS


@pytest.mark.parametrize("old", MOVED)
def test_an_old_path_is_the_present_module(old):
    present = import_module(MOVED[old])
    with pytest.warns(DeprecationWarning, match=f"{old} is now {MOVED[old]}"):
        assert import_module(old) is present
    assert present.__spec__.name == MOVED[old]
