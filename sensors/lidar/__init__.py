"""Lidars: configuration, firing pattern, authoring and runtime."""
