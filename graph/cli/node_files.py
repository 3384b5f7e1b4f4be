"""`--nodes FILE.py`: node types from a Python file that the user names, without a package around it."""

from __future__ import annotations

import re
import sys
import traceback
from collections.abc import Iterable
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

from graph.base.errors import UserError

PREFIX = "node_files"
"""First part of the names of these modules, so that none hides a package."""


def load_node_files(files: Iterable[Path]) -> None:
    """Runs each file as a module, once. Modules beside it can be imported.

    Raises UserError for a file that fails or that registers no node type.
    """
    from graph.node.registry import DEFAULT

    for file in files:
        path = file.resolve()
        name = f"{PREFIX}.{re.sub(r'[^0-9A-Za-z_]', '_', path.stem)}"
        if str(path) == getattr(sys.modules.get(name), "__file__", None):
            continue
        if path.suffix != ".py" or not path.is_file():
            raise UserError(f"--nodes {file}: there is no Python file of that name; name a file such as my_nodes.py")
        if name in sys.modules:
            raise UserError(f"--nodes {file}: another file has the name {path.name}, too; rename one of them")
        spec = spec_from_file_location(name, path)
        assert spec is not None
        assert spec.loader is not None
        sys.path.append(str(path.parent))
        module = sys.modules[name] = module_from_spec(spec)
        try:
            spec.loader.exec_module(module)
        except (Exception, SystemExit) as error:  # the file may raise anything
            del sys.modules[name]
            raise UserError(f"--nodes {_place(file, path, error)}: {_reason(error)}") from error
        if not any(one.origin.startswith(f"{name}:") for one in DEFAULT.loaded()):
            del sys.modules[name]
            raise UserError(f"--nodes {file}: it registers no node type; put @node_type above a compute function")


def _place(file: Path, path: Path, error: BaseException) -> str:
    """The file with the line that raised."""
    if isinstance(error, SyntaxError) and error.filename == str(path):
        return f"{file}:{error.lineno}"
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
    return f"{file}:{lines[-1]}" if lines else str(file)


def _reason(error: BaseException) -> str:
    if isinstance(error, UserError):
        return str(error)
    text = error.msg if isinstance(error, SyntaxError) else str(error)
    return f"{type(error).__name__}: {' '.join(text.split())}"
