"""Functions that Numba compiles at their first call, and the parts that they take in.

Code is made again when a file changes that holds the function, what is inlined into it, or named tuples whose fields it
reads by number.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cached_property, update_wrapper
from types import FunctionType
from typing import Any, Generic, ParamSpec, TypeVar, cast, overload

from graph.base.errors import UserError

from .compile_time import watch_compiling
from .kept import Kept, numba

P = ParamSpec("P")
R = TypeVar("R")


class Inlined(Generic[P, R]):
    """A part of compiled functions, which take its code into theirs. Called from Python, it runs as Python."""

    def __init__(self, function: Callable[P, R]) -> None:
        self.python = cast(FunctionType, function)
        update_wrapper(self, function)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """The function's result."""
        return cast(R, self.python(*args, **kwargs))

    @cached_property
    def code(self) -> Any:
        """What Numba made of the function."""
        alone = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}  # nothing but compiled code calls it
        return self._made(forceinline=True, _nrt=False, **alone)

    @property
    def used(self) -> dict[str, Inlined[Any, Any]]:
        """The inlined functions that it calls."""
        names = self.python.__globals__
        # `co_names` has attributes too: one of them may be called as this function is.
        found = {name: names.get(name) for name in self.python.__code__.co_names}
        return {name: one for name, one in found.items() if isinstance(one, Inlined) and one is not self}

    @property
    def _files(self) -> set[str]:
        """The files that its code comes from: those of functions, and of tuples whose fields they read by number."""
        own = {self.python.__code__.co_filename, *_tuple_files(self.python.__globals__)}
        return own.union(*(one._files for one in self.used.values()))

    def _made(self, **options: Any) -> Any:
        try:
            njit = numba().njit
        except ImportError as error:
            raise UserError(f"Numba does not import ({error}). Run `graph doctor` to see what is missing") from error
        function = self.python
        names = {**function.__globals__, **{name: one.code for name, one in self.used.items()}}
        # Errors of compiled code name its file: without the folder, the code is the same wherever it is made.
        placeless = function.__code__.replace(co_filename=f"{function.__module__}.py")
        plain = FunctionType(placeless, names, function.__name__)
        update_wrapper(plain, function)
        return njit(plain, nogil=True, error_model="numpy", **options)


class Compiled(Inlined[P, R]):
    """A function that is compiled at its first call; until then Numba is not even imported.

    makes_arrays: whether it makes any. Otherwise arrays are not counted as references, which takes longer than most
    loops. Division by zero gives inf or NaN, as in NumPy. Raises UserError if Numba does not import.
    """

    def __init__(self, function: Callable[P, R], makes_arrays: bool) -> None:
        super().__init__(function)
        self._makes_arrays = makes_arrays

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """The function's result; the first call compiles, or loads what an earlier process compiled."""
        return cast(R, self.code(*args, **kwargs))

    @cached_property
    def code(self) -> Any:
        """What Numba made of the function."""
        code = self._made(_nrt=self._makes_arrays, no_cfunc_wrapper=True)  # no C code calls it
        code._cache = self.kept  # in the place of Numba's own, which depends on the folder
        watch_compiling()
        return code

    @cached_property
    def kept(self) -> Kept:
        """The function's compiled forms on disk."""
        return Kept(self.name, self._files)

    @property
    def name(self) -> str:
        """Module and function."""
        return f"{self.python.__module__}.{self.python.__qualname__}"


def _tuple_files(names: dict[str, Any]) -> set[str]:
    """The files of the named tuples among some names, and of those that these may hold."""
    spaces, modules = [names], set()
    for space in spaces:  # which grow
        for one in list(space.values()):
            if isinstance(one, type) and issubclass(one, tuple) and one.__module__ not in modules:
                modules.add(one.__module__)
                spaces.append(vars(sys.modules[one.__module__]))
    files = (getattr(sys.modules[module], "__file__", None) for module in modules)
    return {file for file in files if file is not None}


def inlined(function: Callable[P, R]) -> Inlined[P, R]:
    """Decorates a part of compiled functions: what one step of a loop does."""
    return Inlined(function)


@overload
def compiled(function: Callable[P, R]) -> Compiled[P, R]: ...
@overload
def compiled(*, makes_arrays: bool) -> Callable[[Callable[P, R]], Compiled[P, R]]: ...
def compiled(function: Callable[P, R] | None = None, *, makes_arrays: bool = False) -> Any:
    """Decorates a loop over arrays, which may call what is inlined.

    makes_arrays: whether it makes arrays, rather than write into those that it is given.
    """
    if function is None:
        return lambda function: Compiled(function, makes_arrays)
    return Compiled(function, makes_arrays)
