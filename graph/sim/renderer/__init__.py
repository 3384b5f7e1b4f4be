"""Which sensors render when, and the frames they deliver."""
