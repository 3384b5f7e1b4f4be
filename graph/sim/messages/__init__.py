"""The message bus, what feeds it and what records it."""
