"""Data nodes (`omni.graph.nodes`, `omni.graph.core`): constants, arithmetic, vectors, arrays, text, graph variables."""
