"""Ray casting against the stage: one protocol, scenes that are rebuilt only where geometry moved."""
