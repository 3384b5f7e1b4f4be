"""Live topics: the messages of a run on other programs' networks, and theirs in the run (`graph run --live`)."""
