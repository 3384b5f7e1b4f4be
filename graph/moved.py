"""Old module paths of this package, importable for one more release with a DeprecationWarning.

Only modules of the former flat layout are here; what the README names has not moved.
"""

from __future__ import annotations

import sys
import warnings
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType

MOVED = {
    "graph.assembly": "graph.session.open",
    "graph.brief": "graph.base.shorten",
    "graph.context": "graph.node.context",
    "graph.conversion": "graph.values.conversion",
    "graph.db": "graph.node.database",
    "graph.declaration": "graph.node.declaration",
    "graph.errors": "graph.base.errors",
    "graph.events": "graph.node.events",
    "graph.exact": "graph.base.exact",
    "graph.leniency": "graph.session.leniency",
    "graph.loading": "graph.session.load",
    "graph.migration": "graph.spec.migration",
    "graph.overrides": "graph.session.overrides",
    "graph.registry": "graph.node.registry",
    "graph.runner": "graph.session.runner",
    "graph.sim.state.articulation": "graph.sim.physics.articulation",
    "graph.sim.state.inertial": "graph.sim.physics.inertial",
    "graph.staging": "graph.session.staging",
    "graph.suggest": "graph.base.suggest",
    "graph.tracing": "graph.session.tracing",
    "graph.types": "graph.values.types",
    "graph.variables": "graph.node.variables",
}
"""Old dotted path to the present one."""


class _Forwarding:
    """Gives the present module under its old name."""

    def find_spec(self, name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        return ModuleSpec(name, self) if name in MOVED else None  # type: ignore[arg-type]  # an ABC would cost its import

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        present = import_module(MOVED[spec.name])
        warnings.warn(f"{spec.name} is now {MOVED[spec.name]}; import that", DeprecationWarning, stacklevel=2)
        spec.loader_state = present.__spec__
        return present

    def exec_module(self, module: ModuleType) -> None:
        """Leaves the module, which was executed under its present name, the spec of that name."""
        if module.__spec__ is not None:
            module.__spec__ = module.__spec__.loader_state


def install() -> None:
    """Makes the old paths importable."""
    if not any(isinstance(finder, _Forwarding) for finder in sys.meta_path):
        sys.meta_path.append(_Forwarding())
