"""Values of attribute types: the zero of each, and the check of what a user wrote.

Scalars are plain Python, those of half and float rounded to their precision (`precision`). Tuples, matrices and
numeric arrays are NumPy arrays of the type's dtype, made read-only here because many nodes may share them; `token[]`
and `target` are lists of str, `bundle` a dict. Quaternions are x, y, z, w; matrices are row-vector matrices.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any

from .precision import ROUNDERS
from .types import INTEGER_RANGES, TYPES, AnyType, Extended, Type

if TYPE_CHECKING:
    import numpy as np

_DTYPES = {
    "uchar": "uint8",
    "int": "int32",
    "uint": "uint32",
    "half": "float16",
    "float": "float32",
    "double": "float64",
}
LARGEST = {"half": 65504.0, "float": 3.4028234663852886e38}
"""The largest finite number of the types that are stored as a wider Python float."""


@cache
def dtype_of(type_: Type) -> np.dtype[Any]:
    """The NumPy dtype of one number (or bool) of a tuple, matrix or array type."""
    import numpy as np

    return np.dtype(_DTYPES.get(type_.storage, type_.storage))


def zero(type_: AnyType) -> Any:
    """The value of an unset attribute: 0, False, "", empty, or the identity for quaternions and matrices."""
    if isinstance(type_, Extended):
        return None
    if type_.storage == "target" or (type_.storage == "token" and type_.array):
        return []
    if type_.storage == "bundle":
        return {}
    if type_.array or type_.count > 1:
        return _zero_array(type_)
    if type_.storage in ("token", "string"):
        return ""
    if type_.storage in ("bool", "execution"):
        return False
    return 0 if type_.storage in INTEGER_RANGES else 0.0


@cache
def _zero_array(type_: Type) -> np.ndarray[Any, Any]:
    import numpy as np

    if type_.array:
        array = np.zeros((0, *type_.shape), dtype_of(type_))
    elif type_.square:
        array = np.eye(type_.count, dtype=dtype_of(type_))
    else:
        array = np.zeros(type_.shape, dtype_of(type_))
        if type_.role == "quat":
            array[3] = 1
    array.setflags(write=False)
    return array


def coerce(type_: Type, value: Any) -> Any:
    """`value` (from a file, a test or a script) as a value of `type_`.

    Accepted: whole floats for integers, ints for reals, one path for a target, flat lists for matrices. Refused: bool
    for a number, text for a bool or a number. Raises ValueError that says what was expected and what was given.
    """
    return _coercer(type_)(value)


@cache
def _coercer(type_: Type) -> Callable[[Any], Any]:
    if type_.storage in ("execution", "bundle"):
        return lambda value: _refuse(f"{type_} attributes hold no value that can be set; connect it instead")
    if type_.storage == "target":
        return _target
    if type_.storage == "token" and type_.array:
        return _token_array
    if type_.array or type_.count > 1:
        return lambda value: _array(type_, value)
    if type_.text:
        return _text
    if type_.storage == "bool":
        return _bool
    if type_.storage in INTEGER_RANGES:
        return lambda value: _integer(type_, value)
    return lambda value: _real(type_, value)


def _refuse(message: str) -> Any:
    raise ValueError(message)


def shown(value: Any) -> str:
    """The value as error messages show it: short, on one line."""
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # Python does not print integers of more than 4,300 digits
        text = "a number of thousands of digits"
    return text if len(text) <= 60 else text[:57] + "..."


def _text(value: Any) -> str:
    if isinstance(value, str):
        return str(value)
    raise ValueError(f"expected text, got {shown(value)}; put it in quotes if it is meant as text")


def _bool(value: Any) -> bool:
    if isinstance(value, bool) or type(value).__name__ in ("bool", "bool_"):
        return bool(value)
    raise ValueError(f"expected true or false, got {shown(value)}")


def _is_number(value: Any) -> bool:
    if isinstance(value, (bool, str, bytes)) or type(value).__name__ == "bool_":
        return False
    return isinstance(value, (int, float)) or (hasattr(value, "__float__") and getattr(value, "ndim", 0) == 0)


def _integer(type_: Type, value: Any) -> int:
    if not _is_number(value):
        raise ValueError(f"expected a whole number ({type_}), got {shown(value)}")
    try:
        whole = operator.index(value)
    except TypeError:
        real = float(value)
        if not real.is_integer():
            raise ValueError(f"expected a whole number ({type_}), got {shown(value)}") from None
        whole = int(real)
    low, high = INTEGER_RANGES[type_.storage]
    if not low <= whole <= high:
        raise ValueError(f"{shown(whole)} does not fit {type_} ({low} to {high})")
    return whole


def _real(type_: Type, value: Any) -> float:
    if not _is_number(value):
        raise ValueError(f"expected a number ({type_}), got {shown(value)}")
    try:
        real = float(value)
    except OverflowError:
        real = math.inf
    # An infinity that the user wrote is kept; a finite number that would become infinite is refused.
    if (math.isinf(real) and isinstance(value, int)) or LARGEST.get(type_.storage, math.inf) < abs(real) < math.inf:
        raise ValueError(f"{shown(value)} does not fit {type_}")
    rounder = ROUNDERS.get(type_.storage)
    return rounder(real) if rounder else real


def _target(value: Any) -> list[str]:
    paths = [value] if isinstance(value, str) else value
    if not isinstance(paths, (list, tuple)) or not all(isinstance(path, str) for path in paths):
        raise ValueError(f"expected a prim path or a list of prim paths, got {shown(value)}")
    return [path for path in paths if path]


def _token_array(value: Any) -> list[str]:
    if hasattr(value, "tolist"):
        value = value.tolist()
    if not isinstance(value, (list, tuple)) or not all(isinstance(token, str) for token in value):
        raise ValueError(f"expected a list of texts (token[]), got {shown(value)}")
    return [str(token) for token in value]


def _array(type_: Type, value: Any) -> np.ndarray[Any, Any]:
    import numpy as np

    expected = _expected(type_)
    if not isinstance(value, (list, tuple, np.ndarray)):
        raise ValueError(f"expected {expected}, got {shown(value)}")
    try:
        array = np.array(value if len(value) else np.zeros((0,)))
    except (ValueError, OverflowError):
        raise ValueError(f"expected {expected}, got {shown(value)}") from None
    booleans = array.dtype.kind == "b" or (not isinstance(value, np.ndarray) and _holds_bool(value))
    if (type_.storage == "bool") != booleans and array.size:
        raise ValueError(f"expected {expected}, got {shown(value)}")
    # NumPy reads [2**64 - 1, 1] as float64; only Python's own integers keep every digit.
    rounded = array.dtype.kind == "f" and type_.storage in INTEGER_RANGES and not isinstance(value, np.ndarray)
    if (rounded and array.size) or array.dtype.kind not in ("b" if booleans else "iuf"):
        array = _from_objects(type_, value, expected)
    array = _shaped(type_, array, value, expected)
    result = array.astype(dtype_of(type_), copy=True) if booleans else _numbers(type_, array, value)
    result.setflags(write=False)
    return result


def _expected(type_: Type) -> str:
    element = type_.element
    of = "true and false" if type_.storage == "bool" else "numbers"
    if type_.array:
        inner = of if element.count == 1 else f"{' x '.join(map(str, element.shape))} {of}"
        return f"a list of {inner} ({type_})" if element.count == 1 else f"a list of elements of {inner} ({type_})"
    return f"{' x '.join(map(str, type_.shape))} {of} ({type_})"


def _holds_bool(value: Any) -> bool:
    pending = [value]
    while pending:
        one = pending.pop()
        if isinstance(one, bool):
            return True
        if isinstance(one, (list, tuple)):
            pending.extend(one)
    return False


def _from_objects(type_: Type, value: Any, expected: str) -> np.ndarray[Any, Any]:
    """An array of integers too large for NumPy's own choice of dtype; ValueError if a value is not a number."""
    import numpy as np

    array = np.array(value, dtype=object)
    if array.size and all(isinstance(one, (int, float)) for one in array.flat):
        return array
    raise ValueError(f"expected {expected}, got {shown(value)}")


def _shaped(type_: Type, array: np.ndarray[Any, Any], value: Any, expected: str) -> np.ndarray[Any, Any]:
    shape = type_.shape
    if type_.array:
        if array.size == 0 and array.ndim <= 1:
            return array.reshape((0, *shape))
        flat_matrices = type_.square and array.ndim == 2 and array.shape[1] == type_.count**2
        array = array.reshape((-1, *shape)) if flat_matrices else array
        if array.shape[1:] == shape:
            return array
    elif array.shape == shape or (type_.square and array.shape == (type_.count**2,)):
        return array.reshape(shape)
    raise ValueError(f"expected {expected}, got {shown(value)}")


def _numbers(type_: Type, array: np.ndarray[Any, Any], value: Any) -> np.ndarray[Any, Any]:
    import numpy as np

    if array.dtype.kind == "O":
        array = np.array([_coercer(TYPES[type_.storage])(one) for one in array.flat], object).reshape(array.shape)
    elif type_.storage in INTEGER_RANGES:
        low, high = INTEGER_RANGES[type_.storage]
        if array.dtype.kind == "f" and not (np.isfinite(array) & (array == np.trunc(array))).all():
            raise ValueError(f"expected whole numbers ({type_}), got {shown(value)}")
        if array.size and (int(array.min()) < low or int(array.max()) > high):
            raise ValueError(f"{shown(value)} does not fit {type_} ({low} to {high} each)")
    elif array.size and (np.abs(array[np.isfinite(array)]) > LARGEST.get(type_.storage, math.inf)).any():
        raise ValueError(f"{shown(value)} does not fit {type_}")
    return array.astype(dtype_of(type_), copy=True)
