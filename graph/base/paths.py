"""Paths of prims and of nodes, with "/" between their names."""


def at_or_below(path: str, root: str) -> bool:
    """Whether a path is another one, or below it; "/" is above all."""
    return path == root or path.startswith(f"{root.rstrip('/')}/")
