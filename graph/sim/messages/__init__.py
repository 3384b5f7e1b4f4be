"""The message bus, its sources and its recorders."""
