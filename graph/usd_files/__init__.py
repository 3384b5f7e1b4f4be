"""USD scenes as graph files: reads their OmniGraph prims into a `FileSpec`, and writes a `FileSpec` as such prims.

USD is imported inside functions, through the one module that owns it, `graph.sim.usd`. `graph.files.examine` and `graph
convert` import this package by name for a file that ends in `.usd`, `.usda` or `.usdc`.
"""
