"""Machine code for loops over arrays, made by Numba: one pass over a ray's numbers instead of one pass a formula.

`functions` has the decorators `compiled` and `inlined`, `kept` keeps what Numba made, `signatures` is the list of what
is compiled, `warming` compiles it ahead of the first run.

Floats are computed in the order that is written, by one thread, so the bytes are the same in every run and on every
processor. Other threads go on meanwhile. Constants stand in the functions' files, everything else is an argument.
A loop over elements compiles in 0.05 to 0.1 s; `np.zeros` takes 0.2 s, an assignment to a slice 1.7 s, `transpose` with
axes 2.1 s: they stay outside. What is inlined is compiled once for each combination of types, and a plain `0` has a
type of its own: counters begin as `np.int64(0)`, and callers convert to int64 and float64 what is int32 or float32.
"""

from .functions import Compiled, Inlined, compiled, inlined

__all__ = ["Compiled", "Inlined", "compiled", "inlined"]
