"""`isaacsim.core.experimental.utils.backend`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from typing import Any

__all__ = [
    "SimStateMode",
    "get_current_backend",
    "get_simstate_mode",
    "is_backend_set",
    "should_raise_on_fallback",
    "should_raise_on_unsupported",
    "use_backend",
]
_USED: list[tuple[str, bool, bool]] = []


class SimStateMode(StrEnum):
    DISABLED = "disabled"
    ENABLED = "enabled"


@contextmanager
def use_backend(backend: str, *, raise_on_unsupported: bool = False, raise_on_fallback: bool = False) -> Iterator[None]:
    if backend not in ("usd", "usdrt", "fabric", "tensor", "simstate"):
        raise ValueError(f"Invalid backend: {backend}")
    _USED.append((backend, raise_on_unsupported, raise_on_fallback))
    try:
        yield
    finally:
        _USED.pop()


def get_current_backend(supported_backends: list[str], *, raise_on_unsupported: bool | None = None) -> str:
    name = _USED[-1][0] if _USED else supported_backends[0]
    if name in supported_backends:
        return name
    if should_raise_on_unsupported() if raise_on_unsupported is None else raise_on_unsupported:
        raise RuntimeError(f"the backend {name} is not among {', '.join(supported_backends)}")
    return supported_backends[0]


def is_backend_set() -> bool:
    return bool(_USED)


def should_raise_on_unsupported() -> bool:
    return bool(_USED) and _USED[-1][1]


def should_raise_on_fallback() -> bool:
    return bool(_USED) and _USED[-1][2]


def get_simstate_mode() -> Any:
    return SimStateMode.DISABLED
