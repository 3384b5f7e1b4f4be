"""`carb`: the log and small vectors."""

from __future__ import annotations

import logging
from collections import namedtuple
from typing import Any

__all__ = [
    "Double2",
    "Double3",
    "Double4",
    "Float2",
    "Float3",
    "Float4",
    "Int2",
    "log_error",
    "log_info",
    "log_verbose",
    "log_warn",
    "log_warning",
]
_LOG = logging.getLogger("tickgraph")
Double2, Double3 = namedtuple("Double2", "x y"), namedtuple("Double3", "x y z")
Double4 = namedtuple("Double4", "x y z w")
Float2, Float3, Float4 = namedtuple("Float2", "x y"), namedtuple("Float3", "x y z"), namedtuple("Float4", "x y z w")
Int2 = namedtuple("Int2", "x y")


def log_error(message: Any, *_: Any, **__: Any) -> None:
    _LOG.error("%s", message)


def log_warn(message: Any, *_: Any, **__: Any) -> None:
    _LOG.warning("%s", message)


log_warning = log_warn


def log_info(message: Any, *_: Any, **__: Any) -> None:
    _LOG.debug("%s", message)


def log_verbose(message: Any, *_: Any, **__: Any) -> None:
    _LOG.debug("%s", message)
