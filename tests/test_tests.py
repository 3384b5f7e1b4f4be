"""What every test keeps to: it can fail, and it looks at what is public."""

import ast
from typing import NamedTuple

import pytest

from tests.support.places import ROOT

FILES = sorted(str(path.relative_to(ROOT)) for path in (ROOT / "tests").rglob("*.py"))
CHECKS = ("pytest.raises", "pytest.warns", "pytest.fail", "np.testing.assert_")

NOT_OURS = {"_simulation_manager_interface", "_clear_type_cache", "_repr_html_"}
"""Names that begin with an underscore: of Isaac Sim's public API, of CPython's `sys`, and what notebooks call."""


def tree(name):
    return ast.parse((ROOT / name).read_text(encoding="utf8"))


class Function(NamedTuple):
    """What a function of the tests does to check something."""

    place: str
    name: str
    asserts: bool
    calls: frozenset[str]

    def checks(self, checking):
        """Whether it asserts something, itself or by one of the functions `checking`."""
        return self.asserts or not self.calls.isdisjoint(checking)


def functions(name, parsed):
    """Every function of a file of tests."""
    for one in ast.walk(parsed):
        if isinstance(one, ast.FunctionDef | ast.AsyncFunctionDef):
            nodes = list(ast.walk(one))
            calls = [ast.unparse(node.func) for node in nodes if isinstance(node, ast.Call)]
            asserts = any(isinstance(node, ast.Assert) for node in nodes) or any(c.startswith(CHECKS) for c in calls)
            last = frozenset(call.rpartition(".")[2] for call in calls)
            yield Function(f"{name}:{one.lineno}: {one.name}", one.name, asserts, last)


def helpers(found):
    """Names of functions that are not tests and check something, by way of each other too."""
    checking = set()
    while True:
        more = {one.name for one in found if not one.name.startswith("test_") and one.checks(checking)}
        if more <= checking:
            return checking
        checking |= more


def test_every_test_checks_something():
    found = [one for name in FILES for one in functions(name, tree(name))]
    checking = helpers(found)
    assert [one.place for one in found if one.name.startswith("test_") and not one.checks(checking)] == []


def test_a_test_that_checks_nothing_would_be_found():
    text = "def test_a(): run()\ndef test_b():\n    with pytest.raises(ValueError): run()"
    silent, loud = functions("test_file.py", ast.parse(text))
    assert not silent.checks({"look"})
    assert silent.checks({"run"})
    assert loud.checks(set())


@pytest.mark.parametrize("name", FILES)
def test_no_private_name_is_used(name):
    private = [
        f"{name}:{node.lineno}: {used}"
        for node in ast.walk(tree(name))
        for used in names_used(node)
        if used.startswith("_") and not used.startswith("__") and used not in NOT_OURS
    ]
    assert private == []


def names_used(node):
    """Names of attributes of others, of imports, and of what `monkeypatch.setattr` replaces."""
    if isinstance(node, ast.Attribute) and not (isinstance(node.value, ast.Name) and node.value.id in ("self", "cls")):
        yield node.attr
    elif isinstance(node, ast.ImportFrom):
        yield from (one.name for one in node.names)
    elif isinstance(node, ast.Call) and ast.unparse(node.func) == "monkeypatch.setattr":
        words = [one.value for one in node.args[:2] if isinstance(one, ast.Constant) and isinstance(one.value, str)]
        yield from (part for word in words for part in word.split("."))
