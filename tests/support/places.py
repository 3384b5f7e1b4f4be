"""Where things are in the checkout."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
"""The root of the repository."""

LIBRARY_FACTS = ROOT / "tests" / "nodes" / "data"
"""The folder of the JSON tables of facts on OmniGraph's node library."""
