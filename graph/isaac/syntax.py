"""A Python script as its syntax tree shows it: what names stand for, and the calls of each body in their order.

Nothing of the script runs.
"""

from __future__ import annotations

import ast
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from graph.base.errors import Mark, Problem, UserError
from graph.base.inputs import read_text
from graph.base.records import dataclass, field

from .constants import Folder, NotConstant

MOST_NAMES = 100
"""Longest chain of names that is followed."""
LONGEST_NAME = 1000
"""Characters of a dotted name; assignments could make it grow with every line."""


@dataclass(slots=True, eq=False)
class Script:
    """A parsed script. imports: each module that is imported with its place; names: what each name stands for."""

    file: str
    tree: ast.Module
    imports: list[tuple[str, ast.stmt]] = field(default_factory=list)
    names: dict[str, str] = field(default_factory=dict)
    values: dict[str, ast.expr] = field(default_factory=dict)
    """The last expression assigned to a name or attribute chain."""

    nodes: list[ast.AST] = field(default_factory=list)
    """Every node of the tree."""
    called: list[tuple[ast.Call, str]] = field(default_factory=list)
    """Every call with the name that it calls."""

    def mark(self, node: ast.AST) -> Mark:
        """The place of a node."""
        return Mark(self.file, getattr(node, "lineno", 1), getattr(node, "col_offset", 0) + 1)

    def name_of(self, node: ast.AST) -> str:
        """The dotted name that an expression stands for, imports and assignments resolved; "" for other expressions.

        Of a call, the called name with `()`: `timeline.play` is `omni.timeline.get_timeline_interface().play`.
        """
        chain: list[str] = []
        for _ in range(MOST_NAMES):
            if isinstance(node, ast.Attribute):
                chain.append(node.attr)
                node = node.value
            elif isinstance(node, ast.Call):
                chain.append("()")
                node = node.func
            elif isinstance(node, ast.Await):
                node = node.value
            elif isinstance(node, ast.Name):
                chain.append(self.names.get(node.id, node.id))
                name = ".".join(reversed(chain)).replace(".()", "()")
                return name if len(name) <= LONGEST_NAME else ""
            else:
                return ""
        return ""

    def value_of(self, node: ast.AST | None) -> Any:
        """The value of an expression of constants, names of constants included; None if only a run knows it."""
        try:
            return Folder(self.values.get).value(node)
        except (NotConstant, RecursionError):
            return None

    def bodies(self) -> Iterator[list[ast.AST]]:
        """The statements and expressions of the module and of each function, each body in textual order."""
        pending: list[Sequence[ast.AST]] = [self.tree.body]
        while pending:
            body: list[ast.AST] = []
            stack: list[ast.AST] = [*reversed(pending.pop())]
            while stack:
                node = stack.pop()
                if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
                    pending.append(node.body)
                    continue
                body.append(node)
                stack += reversed([*ast.iter_child_nodes(node)])
            yield body


def read_script(path: str | Path) -> Script:
    """The script of a file. Raises UserError, with line and column, for one that Python cannot read."""
    try:
        text = read_text(path, "file.script")
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of odd escapes and comparisons, which Python tells its user
            tree = ast.parse(text)
    except SyntaxError as error:
        where = Mark(str(path), error.lineno or 1, max(1, error.offset or 1))
        raise UserError(Problem(f"Python cannot read it: {error.msg}", where)) from None
    except ValueError as error:
        raise UserError(f"{path}: Python cannot read it: {error}") from None
    except (RecursionError, MemoryError):
        raise UserError(f"{path}: its expressions nest too deeply to be read; break them up") from None
    script = Script(str(path), tree, nodes=[*ast.walk(tree)])
    for node in script.nodes:
        _learn(script, node)
    script.called = [(node, script.name_of(node.func)) for node in script.nodes if isinstance(node, ast.Call)]
    return script


def _learn(script: Script, node: ast.AST) -> None:
    """Notes what an import or assignment names."""
    if isinstance(node, ast.Import):
        for alias in node.names:
            script.imports.append((alias.name, node))
            script.names[alias.asname or alias.name.partition(".")[0]] = (
                alias.name if alias.asname else alias.name.partition(".")[0]
            )
    elif isinstance(node, ast.ImportFrom) and not node.level:
        for alias in node.names:
            script.imports.append((f"{node.module}.{alias.name}", node))
            script.names[alias.asname or alias.name] = f"{node.module}.{alias.name}"
    elif isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        for target in targets:
            if isinstance(target, ast.Name):
                script.values[target.id] = node.value
                name = script.name_of(node.value)
                if name and name != target.id and not name.startswith(f"{target.id}."):
                    script.names[target.id] = name
                elif not name:
                    script.names.pop(target.id, None)
