"""The argument types for which the loops are compiled, as text: what a warm-up compiles, and wheels carry.

`signatures.json` holds them by function. An array is `float32[:, ::1]` (C order), `[::1, :]` (Fortran's) or `[:, :]`
(any), a tuple a list, a named tuple an object with its class as key, an array of records names the dtype.
`tests/sensors/compiled/test_signatures.py` runs the examples and finds what is missing; `python -m
tests.sensors.compiled.listing` writes the file.
"""

from __future__ import annotations

import json
import sys
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, TypeAlias

from .functions import Compiled
from .kept import numba

LIST = Path(__file__).with_name("signatures.json")

Text: TypeAlias = "str | list[Text] | dict[str, list[Text]]"
"""One type: a scalar or an array; a tuple; a named tuple by its class."""


def listed(loaded_only: bool = False) -> list[tuple[Compiled[Any, Any], tuple[Any, ...]]]:
    """Each loop with the argument types of one of its compiled forms, in the order of the list.

    loaded_only: those of modules that this process has imported.
    """
    return [
        (function(name), tuple(map(type_of, types)))
        for name, forms in json.loads(LIST.read_text()).items()
        if not loaded_only or name.rpartition(".")[0] in sys.modules
        for types in forms
    ]


def number_left() -> int:
    """How many listed forms of the imported modules are not kept yet."""
    target = numba().core.registry.cpu_target.target_context
    return sum(not loop.kept.has(types, target) for loop, types in listed(loaded_only=True))


def function(name: str) -> Compiled[Any, Any]:
    """A loop by module and name."""
    found = _named(name)
    if not isinstance(found, Compiled):
        raise TypeError(f"{name} in {LIST.name} is not a compiled function")
    return found


def text_of(kind: Any) -> Text:
    """A type of Numba as it stands in the list. Raises TypeError if the list has no form for it."""
    types = numba().types
    if isinstance(kind, types.Array):
        order = {"C": [":"] * (kind.ndim - 1) + ["::1"], "F": ["::1"] + [":"] * (kind.ndim - 1)}
        element = kind.dtype
        name = _record_name(element) if isinstance(element, types.Record) else str(element)
        return f"{name}[{', '.join(order.get(kind.layout, [':'] * kind.ndim))}]"
    if isinstance(kind, types.BaseNamedTuple):
        cls = kind.instance_class
        return {f"{cls.__module__}.{cls.__qualname__}": [text_of(one) for one in kind]}
    if isinstance(kind, types.BaseTuple):
        return [text_of(one) for one in kind]
    if isinstance(kind, types.Number | types.Boolean):
        return str(kind)
    raise TypeError(f"no text for the type {kind}")


def type_of(text: Text) -> Any:
    """The type of Numba that a text of the list stands for."""
    types = numba().types
    if isinstance(text, list):
        return types.BaseTuple.from_types([type_of(one) for one in text])
    if isinstance(text, dict):
        ((name, fields),) = text.items()
        return types.BaseTuple.from_types([type_of(one) for one in fields], _named(name))
    name, bracket, axes = text.partition("[")
    if not bracket:
        return getattr(types, text)
    element = numba().from_dtype(_named(name)) if "." in name else getattr(types, name)
    ways = axes.rstrip("]").split(", ")
    layout = "C" if ways[-1] == "::1" else "F" if ways[0] == "::1" else "A"
    return types.Array(element, len(ways), layout, aligned=getattr(element, "aligned", True))


def _named(path: str) -> Any:
    module, _, name = path.rpartition(".")
    return getattr(import_module(module), name)


@cache
def _record_name(kind: Any) -> str:
    """The name of a dtype of records among those of the modules with loops."""
    import numpy as np

    wanted = numba().np.numpy_support.as_dtype(kind)
    for name, module in sorted(sys.modules.items()):
        if name.startswith("sensors."):
            for key, value in vars(module).items():
                if isinstance(value, np.dtype) and value == wanted and value.names:
                    return f"{name}.{key}"
    raise TypeError(f"no module names the dtype {wanted}")
