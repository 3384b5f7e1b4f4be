"""Annotators: each gives the frames of a sensor in one form, by name."""
