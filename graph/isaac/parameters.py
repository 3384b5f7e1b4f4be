"""Functions that are made in a loop, with the names of calls and parameters that scripts know."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import Parameter, Signature
from typing import Any


def renamed(
    function: Callable[..., Any], name: str, *parameters: str, indices: bool = False, optional: bool = False
) -> Callable[..., Any]:
    """A method `name` that takes these parameters by place or by name and passes them on by place.

    indices: whether it also takes the keyword `indices`, and passes that on. optional: parameters are None by default.
    """
    listed = [Parameter("self", Parameter.POSITIONAL_OR_KEYWORD)]
    default = None if optional else Parameter.empty
    listed += [Parameter(one, Parameter.POSITIONAL_OR_KEYWORD, default=default) for one in parameters]
    if indices:
        listed.append(Parameter("indices", Parameter.KEYWORD_ONLY, default=None))
    signature = Signature(listed)

    @wraps(function)
    def called(*given: Any, **named: Any) -> Any:
        bound = signature.bind(*given, **named)
        bound.apply_defaults()
        return function(*bound.args, **bound.kwargs)

    called.__name__ = called.__qualname__ = name
    called.__signature__ = signature  # type: ignore[attr-defined]
    return called
