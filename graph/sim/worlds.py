"""`Worlds`: many worlds at once, by the plug-in for the devices on which they run."""

from typing import Any

from .devices import plugin_of


def __getattr__(name: str) -> Any:
    """The class `Worlds`. Raises UserError if the plug-in is missing."""
    if name != "Worlds":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return plugin_of("cuda").Worlds
