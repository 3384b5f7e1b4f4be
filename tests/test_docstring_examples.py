"""The examples in docstrings are run, and what users call has one."""

import doctest
from importlib import import_module

import pytest

from tests.support.places import PACKAGES, ROOT

FILES = sorted(
    path
    for package in PACKAGES
    for path in (ROOT / package).rglob("*.py")
    if "    >>> " in path.read_text(encoding="utf8")
)
CALLED_BY_USERS = {
    "graph/isaac/og/controller.py",
    "graph/node/decorator.py",
    "graph/session/load.py",
    "graph/sim/app.py",
    "graph/testing/node.py",
    "sensors/lidar/authoring.py",
}


def test_what_users_call_has_an_example():
    assert {str(path.relative_to(ROOT)) for path in FILES} >= CALLED_BY_USERS


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_the_examples_of_a_module_give_what_they_say(path, monkeypatch):
    monkeypatch.chdir(ROOT)
    module = import_module(".".join(path.relative_to(ROOT).with_suffix("").parts))
    found = doctest.testmod(module)
    assert found.attempted > 0
    assert found.failed == 0
