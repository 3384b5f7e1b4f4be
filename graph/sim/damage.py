"""Turns USD's exceptions about the content of a file into one line that names the file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

from graph.base.errors import RunError, UserError


@contextmanager
def reading(name: str, failure: type[UserError | RunError] = UserError) -> Iterator[None]:
    """Turns an exception that USD raises about the content of a file (`name`) into one line.

    A binary layer is read lazily, value by value, so damage may be found at any access.
    """
    from .usd import Tf, UsdUtils

    unheard = UsdUtils.CoalescingDiagnosticDelegate()  # otherwise USD writes them to stderr itself
    try:
        yield
    except (Tf.ErrorException, UnicodeDecodeError) as error:
        raise failure(f"{name}: USD cannot make sense of it: {reason_of(error)}; repair the file") from error
    except TypeError as error:
        if "UnregisteredValue" not in str(error):
            raise
        raise failure(f"{name}: a value in it is of a type that USD does not know; repair the file") from error
    finally:
        del unheard


def reason_of(error: Exception) -> str:
    """USD's message in an exception, without the place in USD's own source."""
    try:
        text = str(error.args[0]) if not isinstance(error, UnicodeDecodeError) else "a text in it is not UTF-8"
    except UnicodeDecodeError:  # the message quotes the file
        return "a text in it is not UTF-8"
    said = re.findall(r" in file \S+ : '(.*?)'\s*(?:\n|$)", text, re.DOTALL) or [text]
    return " ".join(said[0].split()).rstrip(".")
