"""Turns USD's printed messages about a scene into warnings."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from graph.base.shorten import listed

Warn = Callable[[str, str, str], None]


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
