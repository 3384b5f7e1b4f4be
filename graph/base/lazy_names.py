"""Names of a package that are imported when they are first used (PEP 562).

Our own few lines: `lazy_loader` would double what `import graph` costs (12 ms to 24 ms; 40 ms with the stub files that
mypy needs then, which it parses when the package is imported).
"""

from __future__ import annotations

from importlib import import_module
from sys import modules

TYPE_CHECKING = False  # importing typing would take longer than all the rest
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from typing import Any


def lazy_names(package: str, homes: Mapping[str, str]) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """The `__getattr__` and the `__dir__` of a package; `homes` has the module of each name, below the package."""

    def get(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(f"{package}.{homes[name]}"), name)
        setattr(modules[package], name, value)
        return value

    def names() -> list[str]:
        return sorted({*vars(modules[package]), *homes})

    return get, names
