"""Annotators: what hands out the frames of a sensor in one shape each, by name."""
