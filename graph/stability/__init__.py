"""Cases at the extremes: far away, tiny, huge, fast, stiff, degenerate, not a number; each with the bound it must meet.

`graph doctor --stability` runs them on the user's machine, the tests of `tests/stability` in CI.
"""
