"""Recordings in the formats of other tools: point clouds, images, tables, data set layouts."""
