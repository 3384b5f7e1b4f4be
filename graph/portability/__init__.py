"""What works here and fails, or differs silently, in another product: `graph check --target`.

`rules` declares every rule; `nodes`, `sensors`, `clocks` and `scripts` find what breaks them; `fixing` applies the safe
fixes to a graph file.
"""
