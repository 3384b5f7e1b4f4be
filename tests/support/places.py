"""Where things are in the checkout."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
"""The root of the repository."""

PACKAGES = ("graph", "nodes", "sensors", "wings")
"""The folders of the packages that ship."""

LIBRARY_FACTS = ROOT / "tests" / "nodes" / "data"
"""The folder of the JSON tables of facts on OmniGraph's node library."""
