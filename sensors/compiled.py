"""Machine code for loops over arrays, made by Numba: one pass over a ray's numbers instead of one pass a formula.

Numba compiles a function for the argument types of a call and keeps the code beside its source (`__pycache__`) or else
in the user's cache folder: a machine compiles once, in tenths of a second a function. Floats are computed in the order
that is written, by one thread, so the bytes are the same in every run. Other threads go on meanwhile.

Numba keeps the code until the function's *file* changes; here, until a file does that holds what is inlined, or named
tuples that the function's file names. Constants stand in these files, everything else is an argument. A loop over
elements compiles in 0.05 to 0.1 s; `np.zeros` takes 0.2 s, an assignment to a slice 1.7 s, `transpose` with axes 2.1 s:
they stay outside.
"""

from __future__ import annotations

import os
import sys
import zlib
from collections.abc import Callable
from functools import cache, cached_property, update_wrapper
from types import FunctionType
from typing import Any, Generic, ParamSpec, TypeVar, cast, overload

from graph.base.errors import UserError

P = ParamSpec("P")
R = TypeVar("R")


class Inlined(Generic[P, R]):
    """A part of compiled functions, which take its code into theirs. Called from Python, it runs as Python."""

    def __init__(self, function: Callable[P, R]) -> None:
        self._function = cast(FunctionType, function)
        update_wrapper(self, function)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """The function's result."""
        return cast(R, self._function(*args, **kwargs))

    @cached_property
    def code(self) -> Callable[..., Any]:
        """What Numba made of the function."""
        alone = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}  # nothing but compiled code calls it
        return self._made(forceinline=True, _nrt=False, **alone)

    @property
    def _used(self) -> dict[str, Inlined[Any, Any]]:
        """The functions of this kind that it calls."""
        names = self._function.__globals__
        # `co_names` has attributes too: one of them may be called as this function is.
        found = {name: names.get(name) for name in self._function.__code__.co_names}
        return {name: one for name, one in found.items() if isinstance(one, Inlined) and one is not self}

    @property
    def _files(self) -> set[str]:
        """The files that its code comes from: those of functions, and of tuples whose fields they read by number."""
        own = {self._function.__code__.co_filename, *_tuple_files(self._function.__globals__)}
        return own.union(*(one._files for one in self._used.values()))

    def _made(self, *, cache: bool = False, **options: Any) -> Callable[..., Any]:
        try:
            from numba import njit
        except ImportError as error:
            raise UserError(f"Numba does not import ({error}). Run `graph doctor` to see what is missing") from error
        function = self._function
        code = {name: one.code for name, one in self._used.items()}
        plain = FunctionType(function.__code__, {**function.__globals__, **code}, function.__name__)
        update_wrapper(plain, function)
        others = self._files - {function.__code__.co_filename}
        if cache and others:  # Numba keeps the code under this name
            plain.__qualname__ += f"_{_stamp(others):x}"
        return cast(Callable[..., Any], njit(plain, cache=cache, nogil=True, error_model="numpy", **options))


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
        try:
            return cast(R, self.code(*args, **kwargs))
        except OSError:  # what is kept cannot be read or written, for example because the disk is full
            self.__dict__["code"] = self._made(_nrt=self._makes_arrays)
            return cast(R, self.code(*args, **kwargs))

    @cached_property
    def code(self) -> Callable[..., Any]:
        """What Numba made of the function."""
        try:
            code = self._made(cache=True, _nrt=self._makes_arrays)
        except RuntimeError:  # no folder for the code can be written
            code = self._made(_nrt=self._makes_arrays)
        _tell_of_compiling()
        return code


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


def _stamp(files: set[str]) -> int:
    """A number that changes when one of some files does."""
    states = [(status.st_mtime_ns, status.st_size) for status in map(os.stat, sorted(files))]
    return zlib.crc32(repr(states).encode())


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
