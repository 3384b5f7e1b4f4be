"""What a script names that `graph exec` cannot run: modules and names of Isaac Sim that are missing or refused here.

Nothing of the script runs. What only a run can decide, because it stands in a function or under a condition, is a
warning; what catches its own failure is passed over.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

from graph.base.errors import Mark, Problem
from graph.base.records import dataclass
from graph.base.suggest import did_you_mean
from graph.isaac.finder import KIT
from graph.isaac.names import home_of, names_of, public_names, table
from graph.isaac.outcomes import Refusing, refusal

from .syntax import Script

CATCHES = {"ImportError", "ModuleNotFoundError", "AttributeError", "NotImplementedError", "Exception", "BaseException"}
"""Errors whose handlers a missing or refused name reaches."""
LATER = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.If, ast.IfExp, ast.Try, ast.ExceptHandler)
"""Parts of a script that may never run."""


@dataclass(frozen=True, slots=True)
class Lack:
    """One missing or refused name; certain: whether a run comes to it."""

    problem: Problem
    certain: bool


def lacks(script: Script) -> list[Lack]:
    """What `graph exec` would fail at, in the order of the lines."""
    certain, caught = _circumstances(script.tree)
    found: dict[Problem, bool] = {}
    for place, message in (*_imports(script), *_attributes(script), *_refused(script)):
        if id(place) not in caught:
            found.setdefault(Problem(message, script.mark(place)), id(place) in certain)
    lines = [Lack(problem, sure) for problem, sure in found.items()]
    return sorted(lines, key=lambda one: one.problem.mark or Mark("", 0, 0))


def _circumstances(tree: ast.Module) -> tuple[set[int], set[int]]:
    """The nodes that a run comes to for sure, and those in a `try` that catches what is missing, by `id`."""
    certain: set[int] = set()
    caught: set[int] = set()
    stack: list[tuple[ast.AST, bool, bool]] = [(tree, True, False)]
    while stack:
        node, sure, held = stack.pop()
        (caught.add if held else certain.add if sure else int)(id(node))
        sure = sure and not isinstance(node, LATER)
        guarded = node.body if isinstance(node, ast.Try) and any(map(_catches, node.handlers)) else ()
        stack += [(child, sure, held or any(child is one for one in guarded)) for child in ast.iter_child_nodes(node)]
    return certain, caught


def _catches(handler: ast.ExceptHandler) -> bool:
    return handler.type is None or any(
        getattr(one, "id", getattr(one, "attr", "")) in CATCHES for one in ast.walk(handler.type)
    )


def _is_ours(name: str) -> bool:
    return name.partition(".")[0] in KIT


def _imports(script: Script) -> Iterator[tuple[ast.AST, str]]:
    for name, place in script.imports:
        if not _is_ours(name):
            continue
        module, _, last = name.rpartition(".") if isinstance(place, ast.ImportFrom) else (name, "", "")
        if not names_of(module).known:
            yield place, f"TickGraph does not have the module {module}{did_you_mean(module, table())}"
        elif last not in ("", "*") and not _has(module, last):
            yield place, _no_name(module, last)


def _attributes(script: Script) -> Iterator[tuple[ast.AST, str]]:
    own = _own_names(script)
    for node in script.nodes:
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load) and _root(node) not in own:
            module = script.name_of(node.value)
            if _is_ours(module) and names_of(module).known and not _has(module, node.attr):
                yield node, _no_name(module, node.attr)


def _refused(script: Script) -> Iterator[tuple[ast.AST, str]]:
    own = _own_names(script)
    for call, name in script.called:
        if not _is_ours(name) or "(" in name or _root(call.func) in own:
            continue
        parts = name.split(".")
        for count in range(len(parts) - 1, 0, -1):
            module = ".".join(parts[:count])
            if names_of(module).known:
                if why := _refusal(module, *parts[count:]):
                    yield call, f"{name}: {why}"
                break


def _own_names(script: Script) -> set[str]:
    """Names that the script binds otherwise than by an import: what they stand for differs from place to place."""
    bound = {node.arg for node in script.nodes if isinstance(node, ast.arg)}
    return bound | {node.id for node in script.nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}


def _root(node: ast.AST) -> str:
    while isinstance(node, ast.Attribute | ast.Call):
        node = node.value if isinstance(node, ast.Attribute) else node.func
    return node.id if isinstance(node, ast.Name) else ""


def _has(module: str, name: str) -> bool:
    names = names_of(module)
    return (
        name.startswith("__")
        or name in names.submodules
        or names.row(name) is not None
        or any(name in public_names(home_of(home)) for home in names.homes)
    )


def _refusal(module: str, name: str, *further: str) -> str:
    """Why a name of a module, or a further name of a namespace there, refuses at its first use; "" if it does not."""
    names = names_of(module)
    for home in map(home_of, names.homes):
        if name in public_names(home):
            found = getattr(home, name)
            for part in further:
                found = getattr(found, part) if isinstance(found, Refusing) else found
            return refusal(found)
    row = names.row(name)
    return row.text if row is not None and row.kind == "C" and name not in names.submodules else ""


def _no_name(module: str, name: str) -> str:
    names = names_of(module)
    return f"TickGraph has no {module}.{name}{did_you_mean(name, {*names.public(), *names.submodules})}"
