"""Machine code for loops over arrays, made by Numba: one pass over a ray's numbers instead of one pass a formula.

Numba compiles a function for the argument types of a call and keeps the code beside its source (`__pycache__`) or else
in the user's cache folder: a machine compiles once, in tenths of a second a function. Floats are computed in the order
that is written, by one thread, so the bytes are the same in every run. Other threads go on meanwhile.

Numba keeps the code until the function's *file* changes. So a compiled function uses nothing of another file: constants
and compiled functions that it names stand beside it, everything else is an argument. A loop over elements compiles in
0.05 to 0.1 s; `np.zeros` takes 0.2 s, an assignment to a slice 1.7 s, `transpose` with axes 2.1 s: they stay outside.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache, cached_property, update_wrapper
from types import FunctionType
from typing import Any, Generic, ParamSpec, TypeVar, cast

from graph.base.errors import UserError

P = ParamSpec("P")
R = TypeVar("R")


class Compiled(Generic[P, R]):
    """A function that is compiled at its first call; until then Numba is not even imported.

    Division by zero gives inf or NaN, as in NumPy. Raises UserError if Numba does not import.
    """

    def __init__(self, function: Callable[P, R]) -> None:
        self._function = cast(FunctionType, function)
        update_wrapper(self, function)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """The function's result; the first call compiles, or loads what an earlier process compiled."""
        try:
            return cast(R, self.code(*args, **kwargs))
        except OSError:  # what is kept cannot be read or written, for example because the disk is full
            self.__dict__["code"] = self._made(keep=False)
            return cast(R, self.code(*args, **kwargs))

    @cached_property
    def code(self) -> Callable[..., Any]:
        """What Numba made of the function."""
        try:
            return self._made(keep=True)
        except RuntimeError:  # no folder for the code can be written
            return self._made(keep=False)

    def _made(self, *, keep: bool) -> Callable[..., Any]:
        try:
            from numba import njit
        except ImportError as error:
            raise UserError(f"Numba does not import ({error}). Run `graph doctor` to see what is missing") from error
        function = self._function
        names = function.__globals__
        used = {  # `co_names` has attributes too: one of them may be called as this function is
            name: one.code
            for name in function.__code__.co_names
            if isinstance(one := names.get(name), Compiled) and one is not self
        }
        plain = FunctionType(function.__code__, {**names, **used}, function.__name__, function.__defaults__)
        update_wrapper(plain, function)
        _tell_of_compiling()
        return cast(Callable[..., Any], njit(plain, cache=keep, nogil=True, error_model="numpy"))


@cache
def _tell_of_compiling() -> None:
    """From now on, says at a terminal why the first frame takes seconds, if it does."""
    from numba.core import event

    class Compiling(event.Listener):  # type: ignore[misc]
        def on_start(self, event: Any) -> None:
            print("compiling the sensors' loops: a few seconds, once on this machine", file=sys.stderr)
            unregister("numba:compile", self)

        def on_end(self, event: Any) -> None:
            pass

    unregister = event.unregister
    if sys.stderr.isatty():
        event.register("numba:compile", Compiling())


def compiled(function: Callable[P, R]) -> Compiled[P, R]:
    """Decorates a loop over arrays; it may call others of its file that are decorated above it."""
    return Compiled(function)
