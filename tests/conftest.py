"""Options of the whole suite."""

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--fuzz", type=int, default=100, metavar="N", help="spoiled files that the fuzz test runs")
    parser.addoption("--fuzz-seed", type=int, default=1, metavar="S", help="which ones")
