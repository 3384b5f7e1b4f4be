"""Numbers that kernels and their callers share, without Warp."""

MESH = 100
"""The kind of an item that is a mesh; the other kinds are those of `raycast.forms`."""

FEW_ITEMS = 32
"""Up to so many items, a ray is tested against a sphere around each; above, a tree of boxes finds them."""
