"""What every test keeps to: it can fail, and it looks at what is public."""

import ast

import pytest

from tests.support.places import ROOT

FILES = sorted((ROOT / "tests").rglob("*.py"))
TREES = {str(path.relative_to(ROOT)): ast.parse(path.read_text(encoding="utf8")) for path in FILES}
FUNCTIONS = {
    name: [one for one in ast.walk(tree) if isinstance(one, ast.FunctionDef | ast.AsyncFunctionDef)]
    for name, tree in TREES.items()
}
CHECKS = ("pytest.raises", "pytest.warns", "pytest.fail", "np.testing.assert_")

NOT_OURS = {"_simulation_manager_interface", "_clear_type_cache", "_repr_html_"}
"""Names that begin with an underscore: of Isaac Sim's public API, of CPython's `sys`, and what notebooks call."""


def checks(function, checking):
    """Whether a function asserts something, itself or by one of the functions `checking`."""
    return any(
        isinstance(node, ast.Assert)
        or (isinstance(node, ast.Call) and ast.unparse(node.func).startswith(CHECKS))
        or (isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[2] in checking)
        for node in ast.walk(function)
    )


def helpers():
    """Names of functions that are not tests and check something, by way of each other too."""
    found = set()
    while True:
        more = {
            one.name
            for functions in FUNCTIONS.values()
            for one in functions
            if not one.name.startswith("test_") and checks(one, found)
        }
        if more <= found:
            return found
        found |= more


def test_every_test_checks_something():
    checking = helpers()
    without = [
        f"{name}:{one.lineno}: {one.name}"
        for name, functions in FUNCTIONS.items()
        for one in functions
        if one.name.startswith("test_") and not checks(one, checking)
    ]
    assert without == []


def test_a_test_that_checks_nothing_would_be_found():
    silent, loud = ast.parse("def test_a(): run()\ndef test_b():\n    with pytest.raises(ValueError): run()").body
    assert not checks(silent, {"look"})
    assert checks(silent, {"run"})
    assert checks(loud, set())


@pytest.mark.parametrize("name", TREES)
def test_no_private_name_is_used(name):
    private = [
        f"{name}:{node.lineno}: {used}"
        for node in ast.walk(TREES[name])
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
