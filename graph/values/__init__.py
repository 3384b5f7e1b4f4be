"""Attribute types and their values: zero values, coercion, conversion on connections, equality."""
