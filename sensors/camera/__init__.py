"""Cameras: images of the stage by ray casting, with what is known of each pixel."""
