"""Queries and events of physics (`omni.physx.graph`): rays, overlaps, contacts and triggers of colliders."""
