"""Randomisation (`isaacsim.replicator`): random places and numbers, and which of many environments are next."""
