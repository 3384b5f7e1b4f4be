"""Names of a package that are imported at their first use (PEP 562).

Our own few lines, because `lazy_loader` would double the cost of `import graph`: 12 ms to 24 ms, and 40 ms with the
stub files that mypy needs then and that `lazy_loader` parses at import.
"""

from __future__ import annotations

from importlib import import_module
from sys import modules

TYPE_CHECKING = False  # importing typing would take longer than the rest of the import
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from typing import Any

checked: list[bool] = []
"""Contains one item once it is known that Python finds our packages, and not others of these names."""


def lazy_names(
    package: str, homes: Mapping[str, str], more: Callable[[str], Any] | None = None
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """The `__getattr__` and the `__dir__` of a package.

    homes: each public name and its module in the package (`.other.module`: in a package beside it); a module that is
    public itself ends with that name. more: finds other names, or raises AttributeError.
    """

    def get(name: str) -> Any:
        if name not in homes:
            if more and not name.startswith("_"):
                return more(name)
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        if not checked:
            import_module("graph.base.hidden").refuse_hidden_packages()
            checked.append(True)
        module = import_module(f".{homes[name]}", package)
        value = module if homes[name].rpartition(".")[2] == name else getattr(module, name)
        setattr(modules[package], name, value)
        return value

    def names() -> list[str]:
        return sorted({*vars(modules[package]), *homes})

    return get, names
