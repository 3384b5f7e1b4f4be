"""The scheduler of sensors, and the frames that they deliver."""
