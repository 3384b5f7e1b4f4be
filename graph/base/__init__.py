"""The base of every other package: errors, exact numbers, suggestions, short messages, memory limits."""
