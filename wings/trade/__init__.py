"""The measured trade of speed against accuracy: one graph file, run at many settings of its fidelity knobs."""
