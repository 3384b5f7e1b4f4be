"""The log of libraries and of our own modules: printable lines on stderr, or nothing."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from .printing import safe_line


class SafeFormatter(logging.Formatter):
    """One printable line for each record of the log."""

    def format(self, record: logging.LogRecord) -> str:
        """The line."""
        return safe_line(super().format(record))


def safe_log(debug: bool = False) -> None:
    """Prints log records that no other handler takes on stderr, as printable lines.

    Libraries' own warnings (numpy's of overflow and others) name lines of source code, not of the user's file: they are
    hidden unless `debug`. The computing code reports what is wrong with a result.
    """
    if logging.lastResort is not None:
        logging.lastResort.setFormatter(SafeFormatter())
    if not debug:
        warnings.simplefilter("ignore")


@contextmanager
def quiet_warnings() -> Iterator[None]:
    """Keeps warnings out of the log, because the command shows them itself."""
    log = logging.getLogger("tickgraph.warnings")
    before, log.disabled = log.disabled, True
    try:
        yield
    finally:
        log.disabled = before
