"""The stage while it plays: watched, edited, animated, reset."""
