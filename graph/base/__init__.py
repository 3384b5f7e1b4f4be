"""What every room stands on: errors with their places, exact numbers, suggestions, short messages, memory limits."""
