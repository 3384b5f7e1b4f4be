"""Acoustic sensors: what mounts hear of the pulses that others of the same sensor send."""
