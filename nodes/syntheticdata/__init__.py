"""Frames and render variables, as the pipelines of `omni.syntheticdata` hand them on."""
