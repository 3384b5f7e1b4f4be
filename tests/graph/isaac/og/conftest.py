import pytest

from graph import Controller


@pytest.fixture
def control(library):
    """A controller over the test library, without graphs."""
    return Controller(registry=library)
