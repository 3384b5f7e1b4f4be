"""Options of the whole suite, and how often its processes collect garbage."""

import gc

import pytest


def pytest_collection_finish() -> None:
    """Collects seldom: else a tenth of the processor time goes into walking what is imported."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--fuzz", type=int, default=100, metavar="N", help="spoiled files that the fuzz test runs")
    parser.addoption("--fuzz-seed", type=int, default=1, metavar="S", help="which ones")
