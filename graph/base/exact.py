"""Exact time: rates and durations as fractions, stamps as integer nanoseconds."""

from __future__ import annotations

import math
import operator
import struct
from fractions import Fraction

NANOSECONDS = 1_000_000_000


def rate(value: int | float | str | Fraction, *, stored_as_float32: bool = False) -> Fraction:
    """The rate [Hz] that a user meant: the shortest decimal that round-trips the stored type.

    Text such as "60000/1001" is accepted. Raises ValueError for anything that is not a finite number.

    >>> rate(29.97), rate(29.969999313354492, stored_as_float32=True), rate("60000/1001")
    (Fraction(2997, 100), Fraction(2997, 100), Fraction(60000, 1001))
    """
    number = _number(value)
    if isinstance(number, Fraction):
        return number
    return Fraction(_shortest_float32(number) if stored_as_float32 else repr(number))


def duration(value: int | float | str | Fraction) -> Fraction:
    """A time step or duration [s]; a float becomes the nearest fraction with a denominator <= 10**9.

    Raises ValueError for anything that is not a finite number.

    >>> duration(1 / 60), duration(0.1)
    (Fraction(1, 60), Fraction(1, 10))
    """
    number = _number(value)
    return number if isinstance(number, Fraction) else Fraction(number).limit_denominator(10**9)


def nanoseconds(seconds: Fraction) -> int:
    """Seconds as a whole number of nanoseconds; a tie goes to the even number."""
    numerator, denominator = seconds.as_integer_ratio()
    whole, rest = divmod(numerator * NANOSECONDS, denominator)  # ten times as fast as to round a Fraction
    return whole + (2 * rest > denominator or (2 * rest == denominator and whole % 2))


def shortest(value: Fraction | int) -> str:
    """An exact number as text: a short decimal if the decimal is exact, else a fraction.

    >>> shortest(Fraction(1, 8)), shortest(Fraction(1, 3))
    ('0.125', '1/3')
    """
    exact = Fraction(value)
    if exact.denominator == 1:
        return str(exact.numerator)
    decimal = f"{float(exact):g}"
    return decimal if Fraction(decimal) == exact else str(exact)


def count(value: int, what: str, least: int | None = None) -> int:
    """A number of things, as a whole number.

    Raises TypeError unless `value` is a whole number, ValueError below `least`.
    """
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{what} {value!r}: give a whole number") from None
    if least is not None and number < least:
        raise ValueError(f"{what} {number}: give {least} or more")
    return number


def _number(value: int | float | str | Fraction) -> Fraction | float:
    """An exact value, a finite float or text, as a fraction without rounding. Raises ValueError for anything else."""
    if isinstance(value, bool):
        raise ValueError(f"{value!r} is not a number")
    if isinstance(value, (int, Fraction)):
        return Fraction(value)
    if isinstance(value, str):
        return _parse(value)
    try:
        finite = math.isfinite(value)
    except TypeError:
        raise ValueError(f"{value!r} is not a number") from None
    if not finite:
        raise ValueError(f"{value!r} is not a finite number")
    return float(value)


def _parse(text: str) -> Fraction:
    # Bounding the text also bounds the digits and the exponent that Fraction would expand ("1e999999999").
    try:
        if len(text) > 64 or ("e" in text.lower() and abs(int(text.lower().rsplit("e", 1)[1])) > 30):
            raise ValueError
        return Fraction(text.replace(" ", ""))
    except (ValueError, ZeroDivisionError):
        raise ValueError(f"{text[:64]!r} is not a number or a fraction such as 1/240") from None


def _shortest_float32(value: float) -> str:
    stored = struct.pack("f", value)
    for digits in range(1, 10):
        text = f"{value:.{digits}g}"
        if struct.pack("f", float(text)) == stored:
            return text
    return repr(struct.unpack("f", stored)[0])
