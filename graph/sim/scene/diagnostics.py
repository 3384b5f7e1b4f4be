"""Turns USD's messages about a scene, printed or raised, into warnings and one-line errors."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from graph.base.errors import RunError, UserError
from graph.base.shorten import listed

Warn = Callable[[str, str, str], None]
"""Takes a warning: stable code, place, message."""


def ignore_warning(code: str, where: str, message: str) -> None:
    """A `Warn` that ignores everything."""


@contextmanager
def quiet(warn: Warn, where: str) -> Iterator[None]:
    """Turns USD's printed messages about a scene into warnings `usd-composition`."""
    from graph.sim.usd import UsdUtils

    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        yield
    finally:
        said = {_readable(message.commentary): None for message in delegate.TakeUncoalescedDiagnostics()}
        texts = [text for text in said if not any(known in text for known in _KNOWN)]
        if texts:
            warn("usd-composition", where, listed(texts))
        del delegate


_KNOWN = "Could not open asset", "Could not load sublayer", "was muted for"
"""Messages about missing assets, which are already reported."""


def _readable(text: str) -> str:
    """A message of USD without its internal details."""
    text = re.sub(r"\(instantiating stage on stage [^)]*\)|,@[^@]*-session\.usda@", "", " ".join(text.split()))
    # Anonymous layers are named by their address, which differs from run to run.
    return re.sub(r"anon:0x[0-9a-f]+:|<?0x[0-9a-f]{6,}>?", "", text).strip()


@contextmanager
def reading(name: str, failure: type[UserError | RunError] = UserError) -> Iterator[None]:
    """Turns an exception that USD raises about the content of a file (`name`) into one line.

    A binary layer is read lazily, value by value, so damage may be found at any access.
    """
    from graph.sim.usd import Tf, UsdUtils

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
