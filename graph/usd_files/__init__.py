"""USD scenes as graph files: their OmniGraph prims read into a `FileSpec`, and a `FileSpec` written as such prims.

USD is imported inside functions, through its one owner `graph.sim.usd`. `graph.files.examine` and `graph convert` reach
this package by name when a file ends in `.usd`, `.usda` or `.usdc`.
"""
