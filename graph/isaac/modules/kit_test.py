"""`omni.kit.test` and `omni.graph.core.tests`: test cases whose coroutines run in the application's loop."""

from __future__ import annotations

import inspect
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any
from unittest import TestCase

import numpy as np

from graph.isaac.session import kit

__all__ = [
    "AsyncTestCase",
    "AsyncTestCaseFailOnLogError",
    "OmniGraphTestCase",
    "OmniUiTest",
    "load_test_file",
    "verify_values",
]


class AsyncTestCase(TestCase):
    """A unittest case: setUp, tearDown, tests and cleanups may be coroutines, and await app updates."""

    fail_on_log_error = False

    def _callSetUp(self) -> None:
        _finish(self.setUp)

    def _callTearDown(self) -> None:
        _finish(self.tearDown)

    def _callTestMethod(self, method: Callable[[], Any]) -> None:
        _finish(method)

    def _callCleanup(self, function: Callable[..., Any], *arguments: Any, **named: Any) -> None:
        _finish(lambda: function(*arguments, **named))


class AsyncTestCaseFailOnLogError(AsyncTestCase):
    fail_on_log_error = True


class OmniUiTest(AsyncTestCase):
    """A case for widgets, which do not exist here: only steps that need no window run."""


class OmniGraphTestCase(AsyncTestCase):
    """A case with an empty stage of its own."""

    async def setUp(self) -> None:  # type: ignore[override]
        await _new_stage()

    async def tearDown(self) -> None:  # type: ignore[override]
        await _new_stage()


async def load_test_file(test_file_name: str, use_caller_subdirectory: bool = False) -> tuple[bool, str]:
    """Opens a USD file; a relative one beside the caller, or in its folder `data`."""
    from .usd import get_context

    path = Path(test_file_name)
    frame = inspect.currentframe()
    if not path.is_absolute() and frame is not None and frame.f_back is not None:
        folder = Path(frame.f_back.f_code.co_filename).parent
        path = folder / ("data" if use_caller_subdirectory else "") / path
    return await get_context().open_stage_async(str(path))


def verify_values(expected_value: Any, actual_value: Any, error_message: str, tolerance: float = 1e-5) -> None:
    """Raises ValueError if two values differ; numbers by more than `tolerance`."""
    if _same(expected_value, actual_value, tolerance):
        return
    raise ValueError(f"{error_message}: Expected {expected_value!r}, got {actual_value!r}")


def _same(expected: Any, actual: Any, tolerance: float) -> bool:
    if isinstance(expected, (str, bool)) or expected is None:
        return bool(expected == actual)
    try:
        left, right = np.asarray(expected, float), np.asarray(actual, float)
    except (TypeError, ValueError):
        return [str(one) for one in expected] == [str(one) for one in actual]
    return left.shape == right.shape and bool(np.allclose(left, right, atol=tolerance, equal_nan=True))


async def _new_stage() -> None:
    from .usd import get_context

    await get_context().new_stage_async()


def _finish(function: Callable[[], Any]) -> None:
    """Calls a function; runs what it gives, if that is a coroutine, to its end."""
    result = function()
    if isinstance(result, Awaitable):
        kit().finish(result)
