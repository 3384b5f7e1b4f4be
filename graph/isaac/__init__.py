"""Isaac Sim's and OmniGraph's names over the engine and the world; nothing of theirs stands on this package."""
