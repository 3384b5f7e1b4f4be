"""The USD stage: opened, watched, edited, and restored when a play ends."""
