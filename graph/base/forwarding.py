"""Old module paths of a package, importable for one more release with a DeprecationWarning."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Mapping
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType


class _Forwarding:
    """Returns the present module when it is imported under its old name."""

    def __init__(self, moved: Mapping[str, str]) -> None:
        self.moved = moved

    def find_spec(self, name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        return ModuleSpec(name, self) if name in self.moved else None  # type: ignore[arg-type]  # an ABC would cost its import

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        present = import_module(self.moved[spec.name])
        warnings.warn(f"{spec.name} is now {self.moved[spec.name]}; import that", DeprecationWarning, stacklevel=2)
        spec.loader_state = present.__spec__
        return present

    def exec_module(self, module: ModuleType) -> None:
        """Restores the spec of the present module, which the import system would replace."""
        if module.__spec__ is not None:
            module.__spec__ = module.__spec__.loader_state


def forward(moved: Mapping[str, str]) -> None:
    """Makes old paths importable; moved: old dotted path -> the present one."""
    if not any(isinstance(finder, _Forwarding) and finder.moved is moved for finder in sys.meta_path):
        sys.meta_path.append(_Forwarding(moved))
