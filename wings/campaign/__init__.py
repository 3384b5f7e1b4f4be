"""Campaigns: the same graph files at many points, each run in its own process, with one table of results."""
