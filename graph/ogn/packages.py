"""Node types from the `.ogn` files of installed packages and the Python beside them."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from importlib import import_module, resources
from importlib.resources.abc import Traversable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

from graph.base.errors import UserError
from graph.base.inputs import start_of
from graph.node.database import Database, NodeError
from graph.node.declaration import Compute, NodeType
from graph.node.registry import Registry

from .database import OgnDatabase
from .kit_modules import kit
from .reading import OgnNode, read_ogn

_LOG = logging.getLogger("tickgraph")
MAX_BYTES = 1_000_000


def register_package(registry: Registry, extension: str, package: str) -> list[NodeType]:
    """Registers a type for each `.ogn` file in a package and the folders below it; returns them.

    A file with mistakes is left out, with a warning for each mistake in the log: a graph that does not use its type
    runs, a graph that uses it gets an error with the reason. Raises ImportError if the package is not installed.
    """
    made = []
    for name, module_name, file in sorted(_ogn_files(resources.files(package), package), key=lambda one: one[0]):
        try:
            node = read_ogn(_text(file, name), name=name, extension=extension)
            one = _node_type(node, name, _implementation(module_name, name))
            registry.add(one)
        except UserError as error:
            for problem in error.problems:
                _LOG.warning("warning node-package: %s (%s): %s; its type is left out", extension, package, problem)
            registry.add_broken(module_name, str(error.problems[0]))
        else:
            made.append(one)
    return made


def _ogn_files(folder: Traversable, package: str) -> Iterator[tuple[str, str, Traversable]]:
    """Each `.ogn` file with its name for messages and the module that implements it."""
    for entry in folder.iterdir():
        if entry.name.endswith(".ogn"):
            stem = entry.name.removesuffix(".ogn")
            yield f"{package.replace('.', '/')}/{entry.name}", f"{package}.{stem}", entry
        elif entry.is_dir() and entry.name.isidentifier() and not entry.name.startswith("__"):
            yield from _ogn_files(entry, f"{package}.{entry.name}")


def _text(file: Traversable, name: str) -> str:
    data = start_of(file, MAX_BYTES + 1) if isinstance(file, Path) else file.read_bytes()
    if len(data) > MAX_BYTES:
        raise UserError(f"{name}: larger than {MAX_BYTES} bytes; that is not a declaration")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise UserError(f"{name}: not UTF-8 text; save it as UTF-8") from None


def _implementation(module_name: str, name: str) -> Any:
    """The class named after the file in the module of that name, else the module itself with its `compute`."""
    stem = module_name.rpartition(".")[2]
    try:
        with kit().importable():
            module = import_module(module_name)
    except ModuleNotFoundError as error:
        if error.name != module_name:
            problem = f"its Python, {module_name}, cannot be imported: {error}{kit().advice(error)}"
            raise UserError(f"{name}: {problem}") from error
        raise UserError(f"{name}: there is no {stem}.py beside it with its Python compute") from None
    except Exception as error:
        raise UserError(f"{name}: its Python, {module_name}, cannot be imported: {error}") from error
    found: type | ModuleType = getattr(module, stem, module)
    if not callable(getattr(found, "compute", None)):
        raise UserError(f"{name}: {module_name} has neither a class {stem} with compute(db) nor a function compute(db)")
    return found


def _node_type(node: OgnNode, name: str, implementation: Any) -> NodeType:
    """The node type that a declaration and its compute function make."""
    made_state: Callable[[], Any] | None = getattr(implementation, "internal_state", None)
    release: Callable[[Any], Any] | None = getattr(implementation, "release", None)
    keeps = callable(made_state) or bool(node.state)

    def specialize(db: Database) -> Compute:
        view = OgnDatabase(db, node.tokens)

        def compute(db: Database) -> bool:
            try:
                with kit().acting_on(db.context.app):
                    return implementation.compute(view) is not False
            except ImportError as error:
                raise NodeError(f"{error}{kit().advice(error)}") from error
            finally:
                view.outputs.close()

        return compute

    def compute(db: Database) -> bool | None:
        return specialize(db)(db)

    return NodeType(
        node.id,
        node.version,
        node.inputs,
        node.outputs,
        node.state,
        compute,
        memory=(made_state if callable(made_state) else SimpleNamespace) if keeps else None,
        event=0 if node.is_event else None,
        release=(lambda db: release(db.node)) if callable(release) else None,
        volatile=node.volatile,
        doc=node.doc,
        origin=f"{name}:{node.line}",
        specialize=specialize,
    )
