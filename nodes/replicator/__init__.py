"""Randomisation (`isaacsim.replicator`): random places and numbers, and the choice of environments."""
